"""The scenes by name. A scene is one module of this room with a ``build`` function marked by ``@scene``."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass

import scenes
from scenes.errors import SceneError
from scenes.model import Scene

Builder = Callable[..., Scene]
_MARK = "scene_name"


class UnknownSceneError(SceneError):
    """No scene has this name; ``known`` holds those that exist."""

    def __init__(self, name: str, known: list[str]) -> None:
        super().__init__(f"unknown scene {name!r}; known: {', '.join(known)}")
        self.name, self.known = name, known


@dataclass(frozen=True)
class SceneInfo:
    """What ``bench list scenes`` shows: name, one line about it, and its parameters with their defaults."""

    name: str
    summary: str
    parameters: dict[str, object]


def scene(name: str) -> Callable[[Builder], Builder]:
    """Mark a function as the builder of the scene ``name``."""

    def mark(build: Builder) -> Builder:
        setattr(build, _MARK, name)
        return build

    return mark


def _builders() -> dict[str, Builder]:
    found: dict[str, Builder] = {}
    for module in pkgutil.iter_modules(scenes.__path__):
        for member in vars(importlib.import_module(f"scenes.{module.name}")).values():
            if inspect.isfunction(member) and hasattr(member, _MARK):
                found[getattr(member, _MARK)] = member
    return found


def names() -> list[str]:
    """All scene names, sorted."""
    return sorted(_builders())


def describe() -> list[SceneInfo]:
    """Each scene's name, summary and parameters, sorted by name."""
    infos = []
    for name, build in sorted(_builders().items()):
        parameters = {p.name: p.default for p in inspect.signature(build).parameters.values()}
        summary = (inspect.getdoc(build) or "").partition("\n")[0]
        infos.append(SceneInfo(name, summary, parameters))
    return infos


def load(name: str, **parameters: object) -> Scene:
    """Build a scene by name.

    Raises
    ------
    UnknownSceneError
        If there is no such scene.
    SceneError
        If a parameter is not one of the scene's, or does not fit.
    """
    builders = _builders()
    if name not in builders:
        raise UnknownSceneError(name, sorted(builders))
    known = inspect.signature(builders[name]).parameters
    for parameter in parameters:
        if parameter not in known:
            raise SceneError(f"scene {name!r} has no parameter {parameter!r}; it has {', '.join(known)}")
    try:
        return builders[name](**parameters)
    except (TypeError, ValueError) as error:
        given = ", ".join(f"{key}={value!r}" for key, value in parameters.items())
        raise SceneError(f"scene {name!r}: {given} does not fit ({error})") from error
