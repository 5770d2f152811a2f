"""The true occupancy grid, computed from the geometry."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError
from scenes.model import FloatArray, Scene, Surface

ROBOT_HEIGHT_M = (0.05, 1.2)
"""The height band in which geometry is in the robot's way: above door sills, up to its camera mast."""

POINTS_AT_ONCE = 1_000_000

OUTSIDE, BLOCKED = -1, 0
"""What is no region of free cells: beyond the plan, geometry."""

TOUR_CELL_M = 0.1
"""Finer than the room that a robot needs beside it."""

STEP_M = 1.0
"""Between poses farther apart, as of a log read in strides, the robot need not have driven straight."""


@dataclass(frozen=True, eq=False)
class TrueOccupancy:
    """Where the robot's body could not be.

    Attributes
    ----------
    blocked : (rows, cols) bool
        Row is y, column is x; True where geometry stands, or where the tour's start cannot reach.
    origin : (2,) float64
        World position of the lower left corner of cell [0, 0], metres.
    resolution : float
        Cell edge, metres.
    """

    blocked: NDArray[np.bool_]
    origin: FloatArray
    resolution: float


def true_occupancy(
    scene: Scene, resolution: float, height_m: tuple[float, float] = ROBOT_HEIGHT_M
) -> TrueOccupancy:
    """Rasterise all geometry in a height band onto the floor plan.

    A cell is blocked if a triangle, cut to the band, passes through it. Cells that cannot be reached from
    the tour's start (the building's core, the outdoors) are blocked too.

    Raises
    ------
    SceneError
        If the tour starts in a blocked cell or outside the scene's bounds.
    """
    blocked, origin = obstacles(scene.surfaces, scene.bounds, resolution, height_m)
    return TrueOccupancy(~_reachable(blocked, origin, resolution, scene), origin, resolution)


def check_tour(scene: Scene) -> None:
    """Refuse a tour that runs through a wall.

    Raises
    ------
    SceneError
        It says where the robot would first be in a cell of `TOUR_CELL_M` with geometry, or leave the bounds.
    """
    blocked, origin = obstacles(scene.surfaces, scene.bounds, TOUR_CELL_M)
    way = _way(scene.tour.poses[:, :2], TOUR_CELL_M / 2)
    stuck = np.flatnonzero(_looked_up((~blocked).astype(np.int32), origin, TOUR_CELL_M, way) <= BLOCKED)
    if len(stuck):
        x, y = way[stuck[0]]
        raise SceneError(
            f"scene {scene.name!r}: the tour runs into an obstacle at ({x:.4g}, {y:.4g}) m; "
            "lead it around, or move what stands there"
        )


def obstacles(
    surfaces: Iterable[Surface],
    bounds: tuple[float, float, float, float],
    resolution: float,
    height_m: tuple[float, float] = ROBOT_HEIGHT_M,
) -> tuple[NDArray[np.bool_], FloatArray]:
    """Cells of a floor plan through which a triangle, cut to a height band, passes.

    Returns
    -------
    blocked : (rows, cols) bool
        Two cells wider than the bounds on each side.
    origin : (2,) float64
        World position of the lower left corner of cell [0, 0], metres.
    """
    margin = 2 * resolution
    x0, y0, x1, y1 = bounds
    origin = np.array([x0 - margin, y0 - margin])
    shape = (
        int(np.ceil((y1 + margin - origin[1]) / resolution)),
        int(np.ceil((x1 + margin - origin[0]) / resolution)),
    )
    far = origin + resolution * np.array(shape[::-1])
    box = np.array([[*origin, height_m[0]], [*far, height_m[1]]])
    blocked, spacing = np.zeros(shape, dtype=bool), resolution / 3
    for surface in surfaces:
        corners = surface.vertices[surface.triangles]
        low, high = corners.min(axis=1), corners.max(axis=1)
        wholly = ((low >= box[0]) & (high <= box[1])).all(axis=1)
        partly = ((high >= box[0]) & (low <= box[1])).all(axis=1) & ~wholly
        for triangles in _by_size(corners[wholly][..., :2], spacing):
            _mark(blocked, origin, resolution, triangles)
        for triangle in corners[partly]:
            _mark(blocked, origin, resolution, _sample(_clip(triangle, box), spacing))
    return blocked, origin


def _mark(blocked: NDArray[np.bool_], origin: FloatArray, resolution: float, points: FloatArray) -> None:
    cell = np.floor((points.reshape(-1, 2) - origin) / resolution).astype(int)
    inside = (cell >= 0).all(1) & (cell < blocked.shape[::-1]).all(1)
    blocked[cell[inside, 1], cell[inside, 0]] = True


def _by_size(triangles: FloatArray, spacing: float) -> Iterator[FloatArray]:
    """Points on (m, 3, 2) triangles, at most ``spacing`` apart; those that need as many points at once."""
    edges = triangles - np.roll(triangles, 1, axis=1)
    longest = np.linalg.norm(edges, axis=2).max(axis=1, initial=0.0)
    steps = np.maximum(1, np.ceil(longest / spacing)).astype(int)
    for n in np.unique(steps):
        some = triangles[steps == n]
        weight = _weights(int(n))
        for part in np.array_split(some, max(1, len(some) * len(weight) // POINTS_AT_ONCE)):
            yield part[:, :1] + weight @ (part[:, 1:] - part[:, :1])


def _clip(polygon: FloatArray, box: FloatArray) -> FloatArray:
    """Cut a polygon to a box, (2, 3) lowest and highest corner (Sutherland–Hodgman)."""
    for axis in range(3):
        for sign, level in ((1.0, box[0, axis]), (-1.0, -box[1, axis])):
            kept: list[FloatArray] = []
            for p, q in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
                a, b = sign * p[axis] - level, sign * q[axis] - level
                if a >= 0:
                    kept.append(p)
                if (a >= 0) != (b >= 0):
                    kept.append(p + (q - p) * a / (a - b))
            polygon = np.array(kept).reshape(-1, 3)
    return polygon


def _sample(polygon: FloatArray, spacing: float) -> FloatArray:
    """Points on a convex polygon, at most ``spacing`` apart, seen from above."""
    if len(polygon) < 3:
        return np.zeros((0, 2))
    flat, points = polygon[:, :2], []
    for b, c in pairwise(flat[1:]):
        a = flat[0]
        longest = max(np.linalg.norm(b - a), np.linalg.norm(c - a), np.linalg.norm(c - b))
        weight = _weights(max(1, int(np.ceil(longest / spacing))))
        points.append(a + weight @ np.stack([b - a, c - a]))
    return np.concatenate(points)


def _weights(n: int) -> FloatArray:
    """(k, 2): weights of a triangle's second and third corner at its points, its edges in ``n`` steps."""
    i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
    return np.asarray(np.stack([i, j], axis=-1)[i + j <= n] / n)


def _reachable(
    blocked: NDArray[np.bool_], origin: FloatArray, resolution: float, scene: Scene
) -> NDArray[np.bool_]:
    from scipy import ndimage  # here, because listing the scenes' names must not wait for it

    regions, _ = ndimage.label(~blocked)
    here = _looked_up(regions, origin, resolution, scene.tour.poses[:1, :2])[0]
    x, y = scene.tour.poses[0, :2]
    if here == OUTSIDE:
        raise SceneError(f"scene {scene.name!r}: the tour starts outside its bounds at ({x:g}, {y:g}) m")
    if here == BLOCKED:
        raise SceneError(f"scene {scene.name!r}: the tour starts inside an obstacle at ({x:g}, {y:g}) m")
    return np.asarray(regions == here)


def _looked_up(
    regions: NDArray[np.integer], origin: FloatArray, resolution: float, points: FloatArray
) -> NDArray[np.int64]:
    """Regions of (n, 2) points, `OUTSIDE` where the plan has no cell."""
    column, row = np.floor((points - origin) / resolution).astype(int).T
    inside = (row >= 0) & (row < regions.shape[0]) & (column >= 0) & (column < regions.shape[1])
    found = np.full(len(points), OUTSIDE, dtype=np.int64)
    found[inside] = regions[row[inside], column[inside]]
    return found


def _way(places: FloatArray, spacing: float) -> FloatArray:
    """The places, and points between those that are no more than `STEP_M` apart, in order."""
    steps = np.diff(places, axis=0)
    length = np.hypot(*steps.T)
    count = np.where(length <= STEP_M, np.maximum(1, np.ceil(length / spacing)), 1).astype(int)
    between = [a + np.arange(n)[:, None] / n * step for a, step, n in zip(places, steps, count, strict=False)]
    return np.concatenate([*between, places[-1:]])
