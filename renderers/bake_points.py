"""Where light is baked: at the mesh's vertices, or, for dense meshes, at as many of them as can be afforded.

Indirect light varies slowly, so vertices that lie close together and face alike share the light of a few.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

F32 = NDArray[np.float32]

MOST_POINTS = 16_000
"""Beyond this the bake takes minutes on two cores; the library's scenes have fewer vertices."""

FIRST_CELL_M, GROWTH = 0.05, 1.25
FACING = 1.5
"""Cells across half of a normal's range, by which vertices that face alike are told apart."""

NEIGHBOURS = 4


@dataclass(frozen=True, eq=False)
class BakePoints:
    """The vertices that light is baked at.

    Attributes
    ----------
    chosen : (k,) int64
        Their indices among the mesh's vertices, ascending.
    spread : (n, k) sparse float32
        From values at the chosen to values at all vertices; rows add up to 1.
    """

    chosen: NDArray[np.int64]
    spread: sparse.csr_matrix


def bake_points(positions: F32, normals: F32, most: int = MOST_POINTS) -> BakePoints:
    """Choose at most ``most`` vertices: one for each cell of place and direction, as small as can be.

    Parameters
    ----------
    positions, normals : (n, 3) float32
        Normals of unit length.
    """
    n = len(positions)
    if n <= most:
        return BakePoints(np.arange(n), sparse.identity(n, dtype=np.float32, format="csr"))
    cell = FIRST_CELL_M
    while True:
        keys = np.concatenate([np.floor(positions / cell), np.round(normals * FACING)], axis=1)
        _, chosen = np.unique(keys.astype(np.int64), axis=0, return_index=True)
        if len(chosen) <= most:
            break
        cell *= GROWTH
    chosen = np.sort(chosen)
    features = np.concatenate([positions / cell, FACING * normals], axis=1)
    count = min(NEIGHBOURS, len(chosen))
    distance, near = cKDTree(features[chosen]).query(features, k=count, workers=-1)
    distance, near = np.reshape(distance, (n, count)), np.reshape(near, (n, count))
    weight = 1 / (distance**2 + 1e-3)  # a chosen vertex keeps its own light nearly
    weight /= weight.sum(axis=1, keepdims=True)
    rows = np.repeat(np.arange(n), count)
    spread = sparse.csr_matrix(
        (weight.ravel().astype(np.float32), (rows, near.ravel())), shape=(n, len(chosen)), dtype=np.float32
    )
    return BakePoints(chosen, spread)
