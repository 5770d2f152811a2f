"""The root exception of the room."""


class VslamError(Exception):
    """Something the V-SLAM pipeline was given cannot be processed; the message says what and where."""
