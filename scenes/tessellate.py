"""Large triangles split into small ones, which carry baked light; shared edges stay shared."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from scenes.model import FloatArray, IntArray, Surface

EdgeLimit = Callable[[FloatArray], FloatArray]
"""Longest edge allowed (n,), metres, at edges' midpoints (n, 3)."""

# corners 0, 1, 2 and the midpoints 3 (of 01), 4 (of 12), 5 (of 20), by which edges are split: bit 0 is 01,
# 1 is 12, 2 is 20
_PATTERNS: dict[int, tuple[tuple[int, int, int], ...]] = {
    0b001: ((0, 3, 2), (3, 1, 2)),
    0b010: ((1, 4, 0), (4, 2, 0)),
    0b100: ((2, 5, 1), (5, 0, 1)),
    0b011: ((3, 1, 4), (0, 3, 4), (0, 4, 2)),
    0b110: ((4, 2, 5), (1, 4, 5), (1, 5, 0)),
    0b101: ((5, 0, 3), (2, 5, 3), (2, 3, 1)),
    0b111: ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
}


def tessellate(surface: Surface, limit: EdgeLimit, most: int) -> Surface | None:
    """Split every edge that is longer than allowed, until none is.

    An edge is split by its own length and place alone, so the two triangles of an edge agree, also those of
    two surfaces. Normals and texture coordinates are interpolated.

    Parameters
    ----------
    limit : callable
        See `EdgeLimit`.
    most : int
        Vertices that the result may have.

    Returns
    -------
    Surface or None
        None where more vertices would be needed.
    """
    vertices = _columns(surface)
    triangles = surface.triangles
    while True:
        edges = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1)  # (m, 3, 2): 01, 12, 20
        ends = vertices[edges][..., :3]
        length = np.linalg.norm(ends[..., 1, :] - ends[..., 0, :], axis=-1)
        middle = ends.mean(axis=-2)
        long = length > limit(middle.reshape(-1, 3)).reshape(length.shape)
        if not long.any():
            return _with(surface, vertices, triangles)
        vertices, triangles = _split(vertices, triangles, np.sort(edges, axis=-1), long)
        if len(vertices) > most:
            return None


def _split(
    vertices: FloatArray, triangles: IntArray, edges: IntArray, long: np.ndarray
) -> tuple[FloatArray, IntArray]:
    key = edges[..., 0] * len(vertices) + edges[..., 1]
    chosen, first = np.unique(key[long], return_index=True)
    ends = edges[long][first]
    added = 0.5 * (vertices[ends[:, 0]] + vertices[ends[:, 1]])
    middle = len(vertices) + np.searchsorted(chosen, key).clip(max=len(chosen) - 1)
    six = np.concatenate([triangles, middle], axis=1)
    pattern = long @ np.array([1, 2, 4])
    pieces = [triangles[pattern == 0]]
    for code, corners in _PATTERNS.items():
        of_code = six[pattern == code]
        pieces += [of_code[:, list(three)] for three in corners]
    return np.concatenate([vertices, added]), np.concatenate(pieces)


def _columns(surface: Surface) -> FloatArray:
    """Position, normal (0 for none) and texture coordinates (0 for none), (n, 8)."""
    n = len(surface.vertices)
    normals = np.zeros((n, 3)) if surface.normals is None else surface.normals
    uv = np.zeros((n, 2)) if surface.uv is None else surface.uv
    return np.concatenate([surface.vertices, normals, uv], axis=1)


def _with(surface: Surface, columns: FloatArray, triangles: IntArray) -> Surface:
    normals = columns[:, 3:6]
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    unit = np.where(length > 1e-6, normals / np.maximum(length, 1e-300), (0.0, 0.0, 1.0))
    return replace(
        surface,
        vertices=columns[:, :3].copy(),
        triangles=triangles,
        normals=None if surface.normals is None else unit,
        uv=None if surface.uv is None else columns[:, 6:].copy(),
    )
