"""The floor of a scene that does not say which it is: the lowest of its large level faces."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError
from scenes.model import FloatArray, IntArray, Surface
from scenes.occupancy import ROBOT_HEIGHT_M, obstacles

LEVEL = 0.99
"""Least z of a level face's unit normal: 8° of slope."""

THICKNESS_M = 0.02
"""Faces this far apart in height are one floor: tiles, mats, thresholds."""

LARGE = 0.3
"""Share of the roomiest level's room that the floor has at least; lower ones are undersides and pits."""

CANDIDATES = 8
CELLS = 150
"""Along a side, for comparing levels."""

SMALLEST_M2 = 1.0


@dataclass(frozen=True, eq=False)
class Floored:
    """Surfaces with the floor parted from the rest and laid to z = 0.

    Attributes
    ----------
    surfaces : tuple of Surface
    floor : tuple of str
        Names of those that are floor, the largest first.
    level_m : float
        Where the floor was; all surfaces are lowered by it.
    """

    surfaces: tuple[Surface, ...]
    floor: tuple[str, ...]
    level_m: float


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
        raise SceneError(
            f"floor {name!r} is none of the surfaces; they are {_some(s.name for s in surfaces)}"
        )
    level = _level(chosen, surfaces, name)
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
    return Floored((*floor, *parts), tuple(s.name for s in floor), level)


def _level(surfaces: tuple[Surface, ...], everything: tuple[Surface, ...], name: str) -> float:
    """Height of the floor: of all heights on which a robot has much room, the lowest.

    Room counts between walls and furniture alone, so that the ground outdoors does not.
    """
    heights, areas = [np.zeros(0)], [np.zeros(0)]
    for surface in surfaces:
        level, area = _is_level(surface)
        heights.append(surface.vertices[:, 2][surface.triangles[level]].mean(axis=1))
        areas.append(area[level])
    height, area = np.concatenate(heights), np.concatenate(areas)
    slot = np.round(height / THICKNESS_M).astype(np.int64)
    slots, which = np.unique(slot, return_inverse=True)
    total = np.bincount(which, weights=area, minlength=len(slots))
    candidates = [k for k in np.argsort(-total)[:CANDIDATES] if total[k] >= SMALLEST_M2]
    if not candidates:
        where = f" in {name!r}" if name else ""
        corners = np.concatenate([s.vertices[s.triangles].reshape(-1, 3) for s in surfaces])
        w, d, h = np.ptp(corners, axis=0)
        raise SceneError(
            f"no floor{where}: no level face of {SMALLEST_M2:g} m² looks up in {w:.3g} × {d:.3g} × {h:.3g} m "
            "(height last); is the file in metres, y up?"
        )
    bounds = _between_walls(everything)
    levels = {
        k: float(np.average(height[slot == slots[k]], weights=area[slot == slots[k]])) for k in candidates
    }
    room = {k: _room(surfaces, everything, levels[k], bounds) for k in candidates}
    large = LARGE * max(room.values())
    return min(levels[k] for k in candidates if room[k] >= large)


def _between_walls(surfaces: tuple[Surface, ...]) -> tuple[float, float, float, float]:
    """The plan's extent of all that is not level; of everything, if all is."""
    corners = [s.vertices[s.triangles[~_is_level(s, either=True)[0]]].reshape(-1, 3) for s in surfaces]
    points = np.concatenate(corners)
    if not len(points):
        points = np.concatenate([s.vertices for s in surfaces])
    (x0, y0), (x1, y1) = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    return float(x0), float(y0), float(x1), float(y1)


def _room(
    surfaces: tuple[Surface, ...],
    everything: tuple[Surface, ...],
    level: float,
    bounds: tuple[float, float, float, float],
) -> float:
    """Cells of a level on which nothing stands, and over which nothing hangs low."""
    resolution = max(bounds[2] - bounds[0], bounds[3] - bounds[1], 1.0) / CELLS
    flat = [_part(s, s.triangles[_is_level(s)[0]], s.name) for s in surfaces if _is_level(s)[0].any()]
    covered, _ = obstacles(flat, bounds, resolution, (level - THICKNESS_M, level + THICKNESS_M))
    low, high = ROBOT_HEIGHT_M
    blocked, _ = obstacles(everything, bounds, resolution, (level + low, level + high))
    return float((covered & ~blocked).sum())


def _is_level(surface: Surface, either: bool = False) -> tuple[NDArray[np.bool_], FloatArray]:
    """Which triangles look up (or down, with ``either``), and all triangles' areas."""
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    up = np.abs(normal[:, 2]) if either else normal[:, 2]
    return up > LEVEL * length, 0.5 * length


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
