"""The floor of a scene that does not say which it is: the lowest of its large level faces."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError
from scenes.model import FloatArray, IntArray, Surface

LEVEL = 0.99
"""Least z of a level face's unit normal: 8° of slope."""

THICKNESS_M = 0.02
"""Faces this far apart in height are one floor: tiles, mats, thresholds."""

LARGE = 0.3
"""Share of the largest level's area that the floor has at least; lower ones are undersides and pits."""

SMALLEST_M2 = 1.0


@dataclass(frozen=True, eq=False)
class Floored:
    """Surfaces with the floor parted from the rest and laid to z = 0.

    Attributes
    ----------
    surfaces : tuple of Surface
    floor : tuple of str
        Names of those that are floor, the largest first.
    """

    surfaces: tuple[Surface, ...]
    floor: tuple[str, ...]


def laid(surfaces: tuple[Surface, ...], name: str = "") -> Floored:
    """Find the floor, part it from what else its surfaces hold, and lay it to z = 0.

    Parameters
    ----------
    name : str
        Of the surface that is the floor, or of the node whose surfaces are (``name/…``); found if empty.

    Raises
    ------
    SceneError
        If there is no such surface, or no level face of a square metre.
    """
    chosen = surfaces if not name else tuple(s for s in surfaces if name in (s.name, s.name.split("/")[0]))
    if not chosen:
        raise SceneError(f"floor {name!r} is none of the surfaces; they are {_some(s.name for s in surfaces)}")
    level = _level(chosen, name)
    parts, floor = [], []
    for surface in surfaces:
        lowered = replace(surface, vertices=surface.vertices - (0.0, 0.0, level))
        height = np.abs(lowered.vertices[:, 2][lowered.triangles]).max(axis=1)
        is_floor = _is_level(lowered)[0] & (height < THICKNESS_M) & any(surface is s for s in chosen)
        if is_floor.all():
            floor.append(lowered)
        elif is_floor.any():
            floor.append(_part(lowered, lowered.triangles[is_floor], f"{surface.name} (floor)"))
            parts.append(_part(lowered, lowered.triangles[~is_floor], surface.name))
        else:
            parts.append(lowered)
    floor.sort(key=lambda s: -_is_level(s)[1].sum())
    return Floored((*floor, *parts), tuple(s.name for s in floor))


def _level(surfaces: tuple[Surface, ...], name: str) -> float:
    """Height of the floor: of all heights with a large level area, the lowest."""
    heights, areas = [np.zeros(0)], [np.zeros(0)]
    for surface in surfaces:
        level, area = _is_level(surface)
        heights.append(surface.vertices[:, 2][surface.triangles[level]].mean(axis=1))
        areas.append(area[level])
    height, area = np.concatenate(heights), np.concatenate(areas)
    slot = np.round(height / THICKNESS_M).astype(np.int64)
    slots, which = np.unique(slot, return_inverse=True)
    total = np.bincount(which, weights=area, minlength=len(slots))
    if not len(total) or total.max() < SMALLEST_M2:
        where = f" in {name!r}" if name else ""
        raise SceneError(f"no floor{where}: no level face of {SMALLEST_M2:g} m² that looks up; is z or y up, and in metres?")
    first = int(np.flatnonzero(total >= LARGE * total.max())[0])
    near = np.abs(slot - slots[first]) <= 1
    return float(np.average(height[near], weights=area[near]))


def _is_level(surface: Surface) -> tuple[NDArray[np.bool_], FloatArray]:
    """Which triangles look up, and all triangles' areas."""
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    return normal[:, 2] > LEVEL * length, 0.5 * length


def _part(surface: Surface, triangles: IntArray, name: str) -> Surface:
    """A surface of some of another's triangles, without vertices that they do not use."""
    used, compact = np.unique(triangles, return_inverse=True)
    return replace(
        surface,
        name=name,
        vertices=surface.vertices[used],
        triangles=compact.reshape(-1, 3).astype(np.int64),
        normals=None if surface.normals is None else surface.normals[used],
        uv=None if surface.uv is None else surface.uv[used],
    )


def _some(names: object) -> str:
    listed = list(names)  # type: ignore[call-overload]
    return ", ".join(listed[:8]) + (", …" if len(listed) > 8 else "")
