"""From a glTF file to surfaces, lamps and named places, as they stand in the file."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from scenes.errors import SceneError
from scenes.gltf.document import Document, read
from scenes.gltf.lights import lights
from scenes.gltf.materials import Looks
from scenes.gltf.meshes import surfaces
from scenes.gltf.nodes import flatten
from scenes.model import Bulb, FloatArray, Sun, Surface

PLAUSIBLE_M = (0.5, 1000.0)
"""A scene smaller or larger than this was hardly made in metres."""

TALLEST_M = 100.0
"""Nor was a taller one: the ground around it may be wide, but a room in centimetres is 250 high."""


@dataclass(frozen=True)
class Mark:
    """A named node without a mesh or lamp of its own, or any other: its place, and how it is scaled."""

    name: str
    position: tuple[float, float, float]
    scale: float


@dataclass(frozen=True, eq=False)
class Import:
    """What a file holds, in world axes and metres.

    Attributes
    ----------
    suns : tuple of Sun
        Directional lights, the brightest first.
    marks : tuple of Mark
        All nodes, for who looks for names.
    notices : tuple of str
        What was changed or left out, a line each.
    """

    path: Path
    surfaces: tuple[Surface, ...]
    bulbs: tuple[Bulb, ...]
    suns: tuple[Sun, ...]
    marks: tuple[Mark, ...]
    notices: tuple[str, ...]

    @property
    def size_m(self) -> FloatArray:
        """(3,) extent along x, y and z."""
        corners = np.array([(s.vertices.min(axis=0), s.vertices.max(axis=0)) for s in self.surfaces])
        return np.asarray(corners[:, 1].max(axis=0) - corners[:, 0].min(axis=0))


def load(path: Path) -> Import:
    """Read a .glb or .gltf file.

    Raises
    ------
    SceneError
        One line with the file, what is wrong in it and what to do.
    """
    document = read(path)
    try:
        found = _import(document)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, struct.error) as error:
        detail = f"{type(error).__name__}: {error}"
        raise SceneError(f"{path}: is malformed ({detail}); check it with a glTF validator") from error
    if not found.surfaces:
        raise SceneError(f"{path}: holds no faces that can be seen; export the meshes with it")
    return found


def _import(document: Document) -> Import:
    nodes = flatten(document)
    notices: list[str] = []
    shapes = surfaces(document, nodes, Looks(document, notices))
    bulbs, suns = lights(document, nodes)
    marks = []
    for node in nodes:
        x, y, z = node.position.tolist()
        scale = float(np.cbrt(abs(np.linalg.det(node.T_world_node[:3, :3]))))
        marks.append(Mark(node.name, (x, y, z), scale))
    found = Import(document.path, tuple(shapes), bulbs, suns, tuple(marks), tuple(notices))
    return found if not shapes else _with_scale_checked(found)


def _with_scale_checked(found: Import) -> Import:
    from dataclasses import replace

    size = found.size_m
    low, high = PLAUSIBLE_M
    if low <= size.max() <= high and size[2] <= TALLEST_M:
        return found
    w, d, h = size
    notice = (
        f"{found.path}: measures {w:.3g} × {d:.3g} × {h:.3g} m; glTF is in metres: scale the model "
        "if that is not its size"
    )
    return replace(found, notices=(*found.notices, notice))
