"""Named parts of the SLAM system: back-ends, observation models and associations register themselves here."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable
from difflib import get_close_matches
from importlib.metadata import entry_points
from typing import Generic, TypeVar

from vslam.errors import VslamError

T = TypeVar("T")


class Registry(Generic[T]):
    """Factories by name; a name can be taken once.

    Parameters
    ----------
    kind : str
        What is registered, for error messages ("association").
    package : str
        Package whose modules are imported at the first look-up, so that they register; empty: none.
    group : str
        Entry point group through which other installed packages add factories; empty: none do.
    """

    def __init__(self, kind: str, package: str = "", group: str = "") -> None:
        self._kind, self._package, self._group = kind, package, group
        self._entries: dict[str, T] = {}
        self._complete = False

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
            When nothing is registered under it; the message holds the nearest names. Also when a plug-in
            cannot be loaded.
        """
        entries = self._all()
        if name in entries:
            return entries[name]
        near = get_close_matches(name, entries, n=2, cutoff=0.5)
        hint = (
            f"did you mean {' or '.join(map(repr, near))}?" if near else f"known: {', '.join(self.names())}"
        )
        raise VslamError(f"unknown {self._kind} {name!r}: {hint}")

    def names(self) -> list[str]:
        """All names, sorted."""
        return sorted(self._all())

    def _all(self) -> dict[str, T]:
        if not self._complete:
            self._complete = True
            self._import_package()
            self._load_plugins()
        return self._entries

    def _import_package(self) -> None:
        if not self._package:
            return
        package = importlib.import_module(self._package)
        for module in pkgutil.iter_modules(package.__path__):
            if not module.ispkg:
                importlib.import_module(f"{self._package}.{module.name}")

    def _load_plugins(self) -> None:
        for point in entry_points(group=self._group) if self._group else ():
            try:
                entry = point.load()
            except Exception as error:  # whatever a foreign module does while it is imported
                raise VslamError(
                    f"{self._kind} {point.name!r}: its plug-in {point.value} cannot be loaded: {error}"
                ) from error
            self.register(point.name)(entry)
