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


# The open list is a ring of buckets by f (Dial 1969): no heap, pushing and popping cost a few loads. Entries
# of one bucket come out unordered, so a cell may be expanded again when its g still falls; the narrower the
# bucket, the rarer that is. f grows by two diagonals at most from a cell to the next: that bounds the ring.
_BUCKETS_PER_CELL = 32.0
_RING = 128

_BLOCKED, _EXPANDED = 1, 2


@njit(cache=True, inline="always")
def _octile(dr: int, dc: int) -> float:
    """Admissible and consistent h: the path length on an empty grid, in cells."""
    dr, dc = abs(dr), abs(dc)
    return max(dr, dc) + (_DIAGONAL - 1.0) * min(dr, dc)


@njit(cache=True)
def _search(blocked, r0, c0, r1, c1):  # type: ignore[no-untyped-def]  # numba infers
    """Straight and diagonal steps of the best path (−1 when there is none) and its cells."""
    state, cols = _padded(blocked)  # with a blocked rim, no neighbour lies outside
    start, goal = (r0 + 1) * cols + c0 + 1, (r1 + 1) * cols + c1 + 1
    row_moves = np.array([0, 0, -1, 1, -1, -1, 1, 1])
    col_moves = np.array([-1, 1, 0, 0, -1, 1, -1, 1])
    moves = row_moves * cols + col_moves
    g = np.full(len(state), np.inf)
    came_by = np.full(len(state), -1, dtype=np.int8)
    first = np.full(_RING, -1, dtype=np.int64)  # of each bucket's chain of entries
    nodes, following = np.empty(1024, dtype=np.int64), np.empty(1024, dtype=np.int64)
    g[start] = 0.0
    bucket = int(_octile(r1 - r0, c1 - c0) * _BUCKETS_PER_CELL)
    nodes[0], following[0], first[bucket % _RING] = start, -1, 0
    entries, waiting, unused = 1, 1, -1  # entries made, entries in buckets, chain of entries to use again
    # the goal's g is final once every bucket that could still lower it is empty
    while waiting > 0 and bucket <= g[goal] * _BUCKETS_PER_CELL:
        entry = first[bucket % _RING]
        if entry < 0:
            bucket += 1
            continue
        node = nodes[entry]
        first[bucket % _RING] = following[entry]
        following[entry], unused = unused, entry
        waiting -= 1
        if state[node] & _EXPANDED:  # an older, longer entry of the same cell
            continue
        state[node] |= _EXPANDED
        r, c = node // cols - 1, node % cols - 1
        for k in range(8):
            near = node + moves[k]
            if state[near] & _BLOCKED:
                continue
            cost = g[node] + 1.0
            if k >= 4:
                if (state[node + col_moves[k]] | state[near - col_moves[k]]) & _BLOCKED:
                    continue
                cost = g[node] + _DIAGONAL
            if cost < g[near]:
                g[near], came_by[near] = cost, k
                state[near] &= ~_EXPANDED
                f = cost + _octile(r1 - r - row_moves[k], c1 - c - col_moves[k])
                slot = max(int(f * _BUCKETS_PER_CELL), bucket) % _RING  # max: rounding must not lose an entry
                entry = unused
                if entry >= 0:
                    unused = following[entry]
                else:
                    if entries == len(nodes):
                        nodes = np.concatenate((nodes, np.empty(entries, dtype=np.int64)))
                        following = np.concatenate((following, np.empty(entries, dtype=np.int64)))
                    entry = entries
                    entries += 1
                nodes[entry], following[entry], first[slot] = near, first[slot], entry
                waiting += 1
    if g[goal] == np.inf:
        return -1, -1, np.empty((0, 2), dtype=np.int64)
    return _trace(came_by, moves, start, goal, cols)


@njit(cache=True)
def _padded(blocked):  # type: ignore[no-untyped-def]
    """Cell states, row by row, with a blocked rim of one cell, and how many stand in a row."""
    rows, cols = blocked.shape
    state = np.full((rows + 2, cols + 2), _BLOCKED, dtype=np.uint8)
    for r in range(rows):
        for c in range(cols):
            state[r + 1, c + 1] = _BLOCKED if blocked[r, c] else 0
    return state.ravel(), cols + 2


@njit(cache=True)
def _trace(came_by, moves, start, goal, cols):  # type: ignore[no-untyped-def]
    """Steps counted as integers, so that the cost carries no summation error."""
    node, straight, diagonal = goal, 0, 0
    while node != start:
        if came_by[node] < 4:
            straight += 1
        else:
            diagonal += 1
        node -= moves[came_by[node]]
    cells = np.empty((straight + diagonal + 1, 2), dtype=np.int64)
    node = goal
    for i in range(straight + diagonal, -1, -1):
        cells[i, 0], cells[i, 1] = node // cols - 1, node % cols - 1
        node -= moves[max(came_by[node], 0)]
    return straight, diagonal, cells
