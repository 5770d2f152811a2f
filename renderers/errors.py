"""The root exception of the room."""


class RendererError(Exception):
    """A picture cannot be rendered or recorded; the message says what, where and what to do."""
