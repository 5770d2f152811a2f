"""Metrics, one module a subject, each a document: sources, conventions, metrics, ``evaluate``."""
