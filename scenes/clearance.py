"""How far geometry is from places on the floor, seen from above."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from scenes.model import FloatArray, Surface


def clearance(
    points: FloatArray, surfaces: Iterable[Surface], height_m: tuple[float, float] = (0.001, 2.0)
) -> FloatArray:
    """Distance from points on the floor to the nearest triangle that reaches into a height band.

    Parameters
    ----------
    points : (n, 2) float64
        Metres.
    height_m : (low, high)
        Triangles wholly below or above it are left out. The default leaves out the floor and what hangs high.

    Returns
    -------
    (n,) float64
        Metres; 0 below or above a triangle, inf where there is none.
    """
    nearest = np.full(len(points), np.inf)
    for surface in surfaces:
        corner = surface.vertices[surface.triangles]
        z = corner[..., 2]
        flat = corner[(z.max(axis=1) > height_m[0]) & (z.min(axis=1) < height_m[1])][..., :2]
        if len(flat):
            for k, point in enumerate(points):
                nearest[k] = min(nearest[k], _to_triangles(point, flat))
    return nearest


def _to_triangles(point: FloatArray, triangles: FloatArray) -> float:
    """Distance from a point to the nearest of (m, 3, 2) triangles."""
    start, stop = triangles, np.roll(triangles, -1, axis=1)
    edge, offset = stop - start, point - start
    along = (offset * edge).sum(axis=-1) / np.maximum((edge**2).sum(axis=-1), 1e-18)
    gap = offset - np.clip(along, 0.0, 1.0)[..., None] * edge
    side = edge[..., 0] * offset[..., 1] - edge[..., 1] * offset[..., 0]
    if ((side > 0).all(axis=1) | (side < 0).all(axis=1)).any():
        return 0.0
    return float(np.sqrt((gap**2).sum(axis=-1).min()))
