"""Named parts of the SLAM system: back-ends, observation models and associations register themselves here."""

from __future__ import annotations

from collections.abc import Callable
from difflib import get_close_matches
from typing import Generic, TypeVar

from vslam.errors import VslamError

T = TypeVar("T")


class Registry(Generic[T]):
    """Factories by name; a name can be taken once.

    Parameters
    ----------
    kind : str
        What is registered, for error messages ("association").
    """

    def __init__(self, kind: str) -> None:
        self._kind = kind
        self._entries: dict[str, T] = {}

    def register(self, name: str) -> Callable[[T], T]:
        """Decorate a class or function so that `get` finds it under ``name``.

        Raises
        ------
        VslamError
            When the name is taken.
        """

        def enter(entry: T) -> T:
            if name in self._entries:
                raise VslamError(f"{self._kind} {name!r} is registered twice; choose another name")
            self._entries[name] = entry
            return entry

        return enter

    def get(self, name: str) -> T:
        """Look a name up.

        Raises
        ------
        VslamError
            When nothing is registered under it; the message holds the nearest names.
        """
        if name in self._entries:
            return self._entries[name]
        near = get_close_matches(name, self._entries, n=2, cutoff=0.5)
        hint = (
            f"did you mean {' or '.join(map(repr, near))}?" if near else f"known: {', '.join(self.names())}"
        )
        raise VslamError(f"unknown {self._kind} {name!r}: {hint}")

    def names(self) -> list[str]:
        """All names, sorted."""
        return sorted(self._entries)
