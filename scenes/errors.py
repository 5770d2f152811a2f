"""The root exception of the room."""


class SceneError(Exception):
    """A scene cannot be built or found; the message says what, where and what to do."""
