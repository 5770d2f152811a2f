"""Tessellated rectangles and boxes. Fine triangles carry baked light, so no edge is longer than asked."""

from __future__ import annotations

import numpy as np

from scenes.model import FloatArray, IntArray, Material, Surface

MAX_EDGE_M = 0.4
"""Default longest cell edge: indirect light varies slowly, a cell of a third of a door's width follows it."""


def rectangle(
    corner: tuple[float, float, float],
    edge_u: tuple[float, float, float],
    edge_v: tuple[float, float, float],
    max_edge_m: float = MAX_EDGE_M,
) -> tuple[FloatArray, IntArray]:
    """A parallelogram as a grid of triangles that faces ``edge_u × edge_v``.

    Returns
    -------
    vertices : (n, 3) float64, metres
    triangles : (m, 3) int64
    """
    u, v = np.asarray(edge_u, dtype=np.float64), np.asarray(edge_v, dtype=np.float64)
    n_u = max(1, int(np.ceil(np.linalg.norm(u) / max_edge_m)))
    n_v = max(1, int(np.ceil(np.linalg.norm(v) / max_edge_m)))
    a, b = np.meshgrid(np.linspace(0, 1, n_u + 1), np.linspace(0, 1, n_v + 1), indexing="ij")
    vertices = np.asarray(corner, dtype=np.float64) + a[..., None] * u + b[..., None] * v
    index = np.arange((n_u + 1) * (n_v + 1)).reshape(n_u + 1, n_v + 1)
    p00, p10, p11, p01 = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    lower = np.stack([p00, p10, p11], axis=-1).reshape(-1, 3)
    upper = np.stack([p00, p11, p01], axis=-1).reshape(-1, 3)
    return vertices.reshape(-1, 3), np.concatenate([lower, upper])


def join(pieces: list[tuple[FloatArray, IntArray]]) -> tuple[FloatArray, IntArray]:
    """Concatenate meshes into one (vertices are not shared between pieces)."""
    offsets = np.cumsum([0] + [len(vertices) for vertices, _ in pieces[:-1]])
    vertices = np.concatenate([vertices for vertices, _ in pieces])
    triangles = np.concatenate([t + o for (_, t), o in zip(pieces, offsets, strict=True)])
    return vertices, triangles


def box(
    low: tuple[float, float, float],
    high: tuple[float, float, float],
    max_edge_m: float = MAX_EDGE_M,
    bottom: bool = False,
) -> tuple[FloatArray, IntArray]:
    """An axis-aligned box that faces outwards; without ``bottom`` it stands open on the floor."""
    x, y, z = low
    w, d, h = (high[0] - x, high[1] - y, high[2] - z)
    faces = [
        rectangle((x, y, z), (w, 0, 0), (0, 0, h), max_edge_m),  # south
        rectangle((x + w, y, z), (0, d, 0), (0, 0, h), max_edge_m),  # east
        rectangle((x + w, y + d, z), (-w, 0, 0), (0, 0, h), max_edge_m),  # north
        rectangle((x, y + d, z), (0, -d, 0), (0, 0, h), max_edge_m),  # west
        rectangle((x, y, z + h), (w, 0, 0), (0, d, 0), max_edge_m),  # top
    ]
    if bottom:
        faces.append(rectangle((x, y, z), (0, d, 0), (w, 0, 0), max_edge_m))
    return join(faces)


def checker(
    corner: tuple[float, float, float],
    edge_u: tuple[float, float, float],
    edge_v: tuple[float, float, float],
    cells: tuple[int, int],
) -> tuple[tuple[FloatArray, IntArray], tuple[FloatArray, IntArray]]:
    """A parallelogram of ``cells`` along u and v as two meshes, of its even and of its odd fields."""
    u, v = np.asarray(edge_u, dtype=np.float64), np.asarray(edge_v, dtype=np.float64)
    n_u, n_v = cells
    a, b = np.meshgrid(np.arange(n_u + 1) / n_u, np.arange(n_v + 1) / n_v, indexing="ij")
    vertices = (np.asarray(corner, dtype=np.float64) + a[..., None] * u + b[..., None] * v).reshape(-1, 3)
    index = np.arange(len(vertices)).reshape(n_u + 1, n_v + 1)
    p00, p10, p11, p01 = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    odd = np.add.outer(np.arange(n_u), np.arange(n_v)) % 2 == 1
    meshes = []
    for field in (~odd, odd):
        triangles = np.concatenate(
            [np.stack([p00, p10, p11], axis=-1)[field], np.stack([p00, p11, p01], axis=-1)[field]]
        )
        used, compact = np.unique(triangles, return_inverse=True)
        meshes.append((vertices[used], compact.reshape(-1, 3).astype(np.int64)))
    return meshes[0], meshes[1]


def surface(name: str, material: Material, *pieces: tuple[FloatArray, IntArray]) -> Surface:
    """A named surface of one material from mesh pieces."""
    vertices, triangles = join(list(pieces))
    return Surface(name, vertices, triangles, material)
