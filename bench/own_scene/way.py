"""The robot's way over the free floor: through way-points, or planned past far-apart places (A*)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise, permutations

import numpy as np
from numpy.typing import NDArray

from bench.own_scene.ground import Ground
from scenes.errors import SceneError
from scenes.model import FloatArray
from scenes.waypoints import resampled, smoothed
from vslam.astar import GridPath, shortest_path

SMOOTHINGS_M = (0.4, 0.3, 0.2, 0.15, 0.1, 0.05, 0.0)
"""Widths of the Gaussian that rounds corners, the widest that leaves room for the robot is taken."""

KEPT_CLEAR_M = (1.0, 0.75, 0.5, 0.4, 0.3)
"""Wished-for distances from walls; the largest that leaves most of the floor in reach is taken."""

REACHED = 0.6
"""Share of the places a robot can be at that stay in reach at a wished-for distance."""

PLACES = 6
SHRINK = 0.75
MARGIN_M = 0.02


@dataclass(frozen=True, eq=False)
class Way:
    """A polyline with a point each 2 cm, (n, 2) metres, and whether it leads back to its start."""

    points: FloatArray
    closed: bool


def through(points: FloatArray, closed: bool, ground: Ground, radius_m: float, scene: str) -> Way:
    """The way through way-points, its corners rounded as there is room.

    Raises
    ------
    SceneError
        Where it comes closer to geometry, or to the floor's end, than the robot's radius; it says where.
    """
    rounded = _rounded(points, closed, ground, radius_m)
    if rounded is not None:
        return Way(rounded, closed)
    straight = resampled(points, closed)
    tight = ground.at(straight) < radius_m
    k = int(np.flatnonzero(tight)[0])
    x, y = straight[k]
    raise SceneError(
        f"scene {scene!r}: the tour has no room at ({x:.2f}, {y:.2f}) m: a wall, an obstacle or the floor's "
        f"end is within the robot's {radius_m:g} m; move its way-points"
    )


def planned(ground: Ground, radius_m: float, longest_m: float, scene: str) -> Way:
    """A closed round past places that lie far apart, no longer than asked.

    Raises
    ------
    SceneError
        If there is no floor on which the robot has room.
    """
    free = _roomy(ground, radius_m + MARGIN_M, scene)
    cells = np.argwhere(free)
    centre = ground.centres(cells).mean(axis=0)
    start = cells[np.argmin(((ground.centres(cells) - centre) ** 2).sum(axis=1))]
    distance = np.linalg.norm(ground.centres(cells) - ground.centres(start[None]), axis=1)
    reach = min(float(distance.max()), longest_m / 2)
    while reach > 2 * ground.resolution:
        route = _round_trip(free, _far_apart(cells[distance <= reach]), ground.resolution)
        if route is not None and len(route) > 2:
            points = _rounded(ground.centres(route), True, ground, radius_m)
            if points is not None and _length(points) <= longest_m:
                return Way(points, True)
        reach *= SHRINK
    raise SceneError(
        f"scene {scene!r}: no round of at most {longest_m:g} m fits on its floor; give way-points"
    )


def _roomy(ground: Ground, radius_m: float, scene: str) -> NDArray[np.bool_]:
    """The largest connected piece of floor, as far from walls as leaves most of it in reach."""
    narrow = _largest(ground.clearance >= radius_m)
    if not narrow.any():
        raise SceneError(
            f"scene {scene!r}: its floor has no room for a robot of {radius_m:.2f} m radius; is it in "
            "metres, and is the right surface its floor?"
        )
    for wished in KEPT_CLEAR_M:
        if wished > radius_m:
            wide = _largest(ground.clearance >= wished)
            if wide.sum() and _grown(wide, wished - radius_m, ground.resolution)[narrow].mean() >= REACHED:
                return wide
    return narrow


def _largest(free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    from scipy import ndimage

    regions, count = ndimage.label(free)
    if count == 0:
        return free
    return np.asarray(regions == 1 + np.argmax(np.bincount(regions.reshape(-1))[1:]))


def _grown(free: NDArray[np.bool_], by_m: float, resolution: float) -> NDArray[np.bool_]:
    from scipy import ndimage

    return np.asarray(ndimage.distance_transform_edt(~free) * resolution <= by_m + resolution)


def _far_apart(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """Some cells, each the farthest from those before it (Gonzalez 1985)."""
    some = cells[:: max(1, len(cells) // 20_000)].astype(np.float64)
    nearest = np.linalg.norm(some - some.mean(axis=0), axis=1)
    chosen = []
    for _ in range(PLACES):
        k = int(np.argmax(nearest))
        chosen.append(some[k])
        gap = np.linalg.norm(some - some[k], axis=1)
        nearest = gap if len(chosen) == 1 else np.minimum(nearest, gap)
    return np.unique(np.array(chosen, dtype=np.int64), axis=0)


def _round_trip(
    free: NDArray[np.bool_], places: NDArray[np.int64], resolution: float
) -> NDArray[np.int64] | None:
    """The shortest round past all places, as cells; None where they are not connected."""
    n, paths = len(places), {}
    for i in range(n):
        for j in range(i + 1, n):
            path = shortest_path(~free, _cell(places[i]), _cell(places[j]), resolution)
            if not isinstance(path, GridPath):
                return None
            paths[i, j], paths[j, i] = path, GridPath(path.cells[::-1], path.cost_m)
    if n < 2:
        return None
    tours = ((0, *order, 0) for order in permutations(range(1, n)))
    best = min(tours, key=lambda tour: (sum(paths[a, b].cost_m for a, b in pairwise(tour)), tour))
    return np.concatenate([paths[a, b].cells[:-1] for a, b in pairwise(best)])


def _cell(place: NDArray[np.int64]) -> tuple[int, int]:
    return int(place[0]), int(place[1])


def _rounded(points: FloatArray, closed: bool, ground: Ground, radius_m: float) -> FloatArray | None:
    for sigma in SMOOTHINGS_M:
        way = smoothed(points, closed, sigma)
        if (ground.at(way) >= radius_m).all():
            return resampled(way, closed)
    return None


def _length(points: FloatArray) -> float:
    return float(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1).sum())
