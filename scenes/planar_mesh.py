"""Triangles that fill a floor plan: a Delaunay mesh that keeps to the plan's outline."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError
from scenes.model import FloatArray, IntArray

ROUNDS = 12
"""Of halving outline pieces that the mesh does not follow; sharp corners need a few."""


def triangulate(rings: list[FloatArray], spacing_m: float) -> tuple[FloatArray, IntArray]:
    """Fill the space between outlines with triangles.

    Pieces of outline are halved until each is an edge of the Delaunay triangulation (a conforming Delaunay
    mesh, Ruppert 1995, without his bound on angles); points of an even grid lie between.

    Parameters
    ----------
    rings : list of (n, 2) float64
        Closed outlines, of holes too, metres; none may cross another.
    spacing_m : float
        Longest piece of outline, and the grid's step.

    Returns
    -------
    vertices : (n, 2) float64, metres
    triangles : (m, 3) int64, counter-clockwise

    Raises
    ------
    SceneError
        If outlines cross or touch.
    """
    from scipy.spatial import Delaunay

    starts = np.concatenate(rings)
    stops = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    points, pieces = _outline(rings, spacing_m)
    points = np.concatenate([points, _between(starts, stops, spacing_m)])
    for _ in range(ROUNDS):
        mesh = Delaunay(points)
        triangles = np.asarray(mesh.simplices, dtype=np.int64)
        missing = pieces[~_are_edges(pieces, triangles, len(points))]
        if not len(missing):
            break
        new = len(points) + np.arange(len(missing))
        kept = pieces[_are_edges(pieces, triangles, len(points))]
        pieces = np.concatenate(
            [kept, np.stack([missing[:, 0], new], axis=1), np.stack([new, missing[:, 1]], axis=1)]
        )
        points = np.concatenate([points, points[missing].mean(axis=1)])
    else:
        raise SceneError("floor plan: its outlines cross or touch each other")
    corners = points[triangles]
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    triangles[area < 0] = triangles[area < 0][:, ::-1]
    keep = (np.abs(area) > 1e-9) & inside(starts, stops, corners.mean(axis=1))
    used, compact = np.unique(triangles[keep], return_inverse=True)
    return points[used], compact.reshape(-1, 3).astype(np.int64)


def inside(starts: FloatArray, stops: FloatArray, points: FloatArray) -> NDArray[np.bool_]:
    """Whether (n, 2) points lie inside by the even-odd rule of all (k, 2) edges together."""
    crossings = np.zeros(len(points), dtype=int)
    for (x0, y0), (x1, y1) in zip(starts, stops, strict=True):
        if y0 != y1:
            spans = (points[:, 1] >= min(y0, y1)) & (points[:, 1] < max(y0, y1))
            crossings += spans & (points[:, 0] < x0 + (points[:, 1] - y0) * (x1 - x0) / (y1 - y0))
    return crossings % 2 == 1


def distance_to(starts: FloatArray, stops: FloatArray, points: FloatArray) -> FloatArray:
    """(n,) distance of points from the nearest of (k, 2) line segments, metres."""
    nearest = np.full(len(points), np.inf)
    for a, b in zip(starts, stops, strict=True):
        along = np.clip((points - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-18), 0.0, 1.0)
        nearest = np.minimum(nearest, np.hypot(*(points - a - along[:, None] * (b - a)).T))
    return nearest


def _outline(rings: list[FloatArray], spacing_m: float) -> tuple[FloatArray, IntArray]:
    points, pieces, count = [], [], 0
    for ring in rings:
        own = []
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            n = max(1, int(np.ceil(np.hypot(*(b - a)) / spacing_m)))
            own.append(a + np.arange(n)[:, None] / n * (b - a))
        loop = np.concatenate(own)
        index = count + np.arange(len(loop))
        pieces.append(np.stack([index, np.roll(index, -1)], axis=1))
        points.append(loop)
        count += len(loop)
    return np.concatenate(points), np.concatenate(pieces)


def _between(starts: FloatArray, stops: FloatArray, spacing_m: float) -> FloatArray:
    """Grid points inside, away from the outline so that they spoil none of its pieces."""
    low, high = starts.min(axis=0), starts.max(axis=0)
    x, y = (
        np.arange(np.ceil(a / spacing_m), np.floor(b / spacing_m) + 1) for a, b in zip(low, high, strict=True)
    )
    grid = spacing_m * np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    grid = grid[inside(starts, stops, grid)]
    return grid[distance_to(starts, stops, grid) > 0.5 * spacing_m]


def _are_edges(pieces: IntArray, triangles: IntArray, count: int) -> NDArray[np.bool_]:
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    key = np.sort(edges, axis=1) @ (count, 1)
    return np.isin(np.sort(pieces, axis=1) @ (count, 1), key)
