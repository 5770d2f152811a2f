"""Metrics, one module a subject. Each is a document: sources and conventions, ``validate``, metrics, ``evaluate``."""
