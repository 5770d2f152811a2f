"""The root exception of the room."""


class ReportError(Exception):
    """A stored run cannot be read or shown; the message says what, where and what to do."""
