"""A* on a grid (eq. 3-38): f = g + h, 8-connected, costs in metres, no corner cutting."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vslam.errors import VslamError

Cell = tuple[int, int]
IntArray = NDArray[np.int64]
_DIAGONAL = np.sqrt(2.0)


@dataclass(frozen=True, eq=False)
class GridPath:
    """A shortest path.

    Attributes
    ----------
    cells : (n, 2) int64
        Row and column, start first, goal last.
    cost_m : float
        Length in metres.
    """

    cells: IntArray
    cost_m: float


@dataclass(frozen=True)
class NoPath:
    """Why there is no path, in a few words."""

    reason: str


def shortest_path(
    blocked: NDArray[np.bool_], start: Cell, goal: Cell, resolution: float
) -> GridPath | NoPath:
    """The shortest 8-connected path; a diagonal step needs both its orthogonal neighbours free.

    Parameters
    ----------
    blocked : (rows, cols) bool
        Cells that may not be entered.
    start, goal : (row, column)
    resolution : float
        Side of a cell, metres.

    Returns
    -------
    GridPath or NoPath
        NoPath when start or goal is outside the grid or blocked, or when the goal cannot be reached.

    Raises
    ------
    VslamError
        When ``blocked`` has not two axes or the resolution is not positive.
    """
    blocked = np.ascontiguousarray(blocked, dtype=np.bool_)
    if blocked.ndim != 2 or not resolution > 0.0:
        raise VslamError(
            f"A*: needs a 2-d grid and a positive resolution, not {blocked.shape} and {resolution}"
        )
    for name, (row, col) in (("start", start), ("goal", goal)):
        if not (0 <= row < blocked.shape[0] and 0 <= col < blocked.shape[1]):
            return NoPath(f"{name} ({row}, {col}) lies outside the grid")
        if blocked[row, col]:
            return NoPath(f"{name} ({row}, {col}) is blocked")
    straight, diagonal, cells = _search(blocked, start[0], start[1], goal[0], goal[1])
    if straight < 0:
        return NoPath("goal cannot be reached")
    return GridPath(cells, float((straight + diagonal * _DIAGONAL) * resolution))


@njit(cache=True)
def _octile(dr: int, dc: int) -> float:
    """Admissible and consistent h: the path length on an empty grid, in cells."""
    dr, dc = abs(dr), abs(dc)
    return max(dr, dc) + (_DIAGONAL - 1.0) * min(dr, dc)


@njit(cache=True)
def _search(blocked, r0, c0, r1, c1):  # type: ignore[no-untyped-def]  # numba infers
    """Straight and diagonal steps of the best path (−1 when there is none) and its cells."""
    rows, cols = blocked.shape
    g = np.full(rows * cols, np.inf)
    parent = np.full(rows * cols, -1, dtype=np.int64)
    closed = np.zeros(rows * cols, dtype=np.bool_)
    capacity = 1024
    keys, nodes = np.empty(capacity), np.empty(capacity, dtype=np.int64)
    start, goal = r0 * cols + c0, r1 * cols + c1
    g[start] = 0.0
    keys[0], nodes[0], size = _octile(r1 - r0, c1 - c0), start, 1
    while size > 0:
        node = nodes[0]
        size = _pop(keys, nodes, size)
        if closed[node]:  # an older, longer entry of the same cell
            continue
        closed[node] = True
        if node == goal:
            return _trace(parent, goal, cols)
        r, c = node // cols, node % cols
        for dr in range(-1, 2):
            for dc in range(-1, 2):
                nr, nc = r + dr, c + dc
                if nr < 0 or nr >= rows or nc < 0 or nc >= cols or blocked[nr, nc]:
                    continue
                step = 1.0
                if dr != 0 and dc != 0:
                    if blocked[r, nc] or blocked[nr, c]:
                        continue
                    step = _DIAGONAL
                following = nr * cols + nc
                cost = g[node] + step
                if not closed[following] and cost < g[following]:
                    g[following] = cost
                    parent[following] = node
                    if size == capacity:
                        keys = np.concatenate((keys, np.empty(capacity)))
                        nodes = np.concatenate((nodes, np.empty(capacity, dtype=np.int64)))
                        capacity *= 2
                    size = _push(keys, nodes, size, cost + _octile(r1 - nr, c1 - nc), following)
    return -1, -1, np.empty((0, 2), dtype=np.int64)


@njit(cache=True)
def _push(keys, nodes, size, key, node):  # type: ignore[no-untyped-def]
    """Add to the 4-ary heap; its new size."""
    i = size
    while i > 0:
        up = (i - 1) // 4
        if keys[up] <= key:
            break
        keys[i], nodes[i] = keys[up], nodes[up]
        i = up
    keys[i], nodes[i] = key, node
    return size + 1


@njit(cache=True)
def _pop(keys, nodes, size):  # type: ignore[no-untyped-def]
    """Drop the smallest of the 4-ary heap; its new size."""
    size -= 1
    key, node = keys[size], nodes[size]
    i = 0
    while True:
        first = 4 * i + 1
        if first >= size:
            break
        least = first
        for child in range(first + 1, min(first + 4, size)):
            if keys[child] < keys[least]:
                least = child
        if keys[least] >= key:
            break
        keys[i], nodes[i] = keys[least], nodes[least]
        i = least
    keys[i], nodes[i] = key, node
    return size


@njit(cache=True)
def _trace(parent, goal, cols):  # type: ignore[no-untyped-def]
    """Steps counted as integers, so that the cost carries no summation error."""
    length, node = 1, goal
    while parent[node] >= 0:
        node = parent[node]
        length += 1
    cells = np.empty((length, 2), dtype=np.int64)
    node, straight, diagonal = goal, 0, 0
    for i in range(length - 1, -1, -1):
        cells[i, 0], cells[i, 1] = node // cols, node % cols
        up = parent[node]
        if up >= 0:
            if up // cols != node // cols and up % cols != node % cols:
                diagonal += 1
            else:
                straight += 1
        node = up
    return straight, diagonal, cells
