"""The surfaces of a scene divided into small cells, for what is found out once and looked up by pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import sparse

from renderers.gbuffer import F32, I32, I64
from renderers.mesh import NOTHING, SceneMesh

CELL_M = 0.05
"""Side of a cell, metres, at most."""

COPLANAR = 0.9999
"""Least cosine between the normals of triangles on one plane."""

DRAWN_IN = 0.02
"""Share of the way to a triangle's middle."""

MOST_CELLS = 32
"""Along a triangle's longest side; larger triangles have no cells."""


@dataclass(frozen=True, eq=False)
class CellGrid:
    """The cells of a mesh's triangles.

    A triangle of n cells a side has n², numbered as the squares of a board: those with a corner towards the
    triangle's first vertex in its lower half, by weight of second and third vertex, the others in its upper.

    Attributes
    ----------
    side : (m,) int32
        Cells along each side of a triangle; 0 where it is too large, or curved.
    first : (m,) int32
        Number of its first cell.
    count : int
    neighbours : (m, m) sparse bool
        Which triangles share a corner's place and a plane; each is its own neighbour.
    """

    mesh: SceneMesh
    side: I32
    first: I32
    count: int
    neighbours: sparse.csr_matrix

    @staticmethod
    def of(mesh: SceneMesh, cell_m: float = CELL_M) -> CellGrid:
        """Divide a mesh's triangles."""
        corners = mesh.vertices[mesh.triangles]
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        side = np.ceil(longest / (np.sqrt(2) * cell_m)).astype(np.int32)  # of a square's halves, the diagonal
        side[(side > MOST_CELLS) | mesh.curved] = 0
        last = np.cumsum(side**2)
        first, count = (last - side**2).astype(np.int32), int(last[-1]) if len(last) else 0
        return CellGrid(mesh, side, first, count, _neighbours(mesh, side > 0))

    def cells(self, triangle: I32, barycentric: F32, normals: F32) -> I32:
        """The cells in which points lie.

        Parameters
        ----------
        triangle : (n,) int32
            `NOTHING` for none.
        barycentric : (n, 2) float32
        normals : (n, 3) float32
            Towards the side that is seen.

        Returns
        -------
        (n,) int32, `NOTHING` for those without, as for a triangle's back.
        """
        return _cells(triangle, barycentric, normals, self.mesh.normals, self.side, self.first)

    def corners(self, triangles: I64, side: I32, beyond: int = 0) -> tuple[F32, I64, I64]:
        """Where the corners of some triangles' cells are, divided into so many a side, (n,).

        A triangle's lie in rows, each a corner shorter than the one before. They are drawn in a little from
        its edges, so that they lie beside what stands there. There may be more rows ``beyond`` each edge.

        Returns
        -------
        points : (c, 3) float32
        place : (c, 2) int64
            Row and column.
        start : (n + 1,) int64
            Index of each triangle's first; the last is c.
        """
        rows = side + 3 * beyond + 1
        start = np.concatenate([[0], np.cumsum(rows * (rows + 1) // 2)]).astype(np.int64)
        points, place = np.empty((start[-1], 3), np.float32), np.empty((start[-1], 2), np.int64)
        _corners(self.mesh.vertices, self.mesh.triangles[triangles], side, beyond, start, points, place)
        return points, place, start


def _neighbours(mesh: SceneMesh, divided: NDArray[np.bool_]) -> sparse.csr_matrix:
    count, normals = len(divided), mesh.normals
    places = np.unique(mesh.vertices.round(4), axis=0, return_inverse=True)[1].reshape(-1)
    at = np.repeat(np.arange(count), 3), places[mesh.triangles.reshape(-1)]
    meets = sparse.csr_matrix((np.ones(3 * count, dtype=np.int32), at))
    pairs = sparse.coo_matrix(meets @ meets.T)
    flat = np.einsum("nk,nk->n", normals[pairs.row], normals[pairs.col]) > COPLANAR
    both = divided[pairs.row] & divided[pairs.col] & flat
    ones = np.ones(np.count_nonzero(both), dtype=bool)
    return sparse.csr_matrix((ones, (pairs.row[both], pairs.col[both])), shape=(count, count))


@njit(cache=True, nogil=True)
def _cells(triangle: I32, barycentric: F32, normals: F32, facing: F32, side: I32, first: I32) -> I32:
    cells = np.full(len(triangle), NOTHING, dtype=np.int32)
    for i in range(len(triangle)):
        t = triangle[i]
        if t < 0 or side[t] == 0:
            continue
        if normals[i, 0] * facing[t, 0] + normals[i, 1] * facing[t, 1] + normals[i, 2] * facing[t, 2] <= 0:
            continue
        n = side[t]
        a, b = max(barycentric[i, 0], np.float32(0)) * n, max(barycentric[i, 1], np.float32(0)) * n
        j = min(int(a), n - 1)
        k = min(int(b), n - 1 - j)
        if (a - j) + (b - k) > 1 and j + k < n - 1:  # past the diagonal
            j, k = n - 1 - j, n - 1 - k
        cells[i] = first[t] + j * n + k
    return cells


@njit(cache=True)
def _corners(
    vertices: F32, triangles: I32, side: I32, beyond: int, start: I64, points: F32, place: I64
) -> None:
    for t in range(len(triangles)):
        a, b, c = vertices[triangles[t, 0]], vertices[triangles[t, 1]], vertices[triangles[t, 2]]
        n, at = side[t], start[t]
        rows = n + 3 * beyond + 1
        for j in range(rows):
            for k in range(rows - j):
                v, w = _inside((j - beyond) / n), _inside((k - beyond) / n)
                points[at] = (1 - v - w) * a + v * b + w * c
                place[at, 0], place[at, 1] = j, k
                at += 1


@njit(cache=True)
def _inside(weight: float) -> float:
    return weight + DRAWN_IN * (1 / 3 - weight)
