"""A* on a grid (eq. 3-38): f = g + h, 8-connected, costs in metres, no corner cutting.

An expanded cell tries canonical moves alone (`vslam.grid_moves`), about two of eight, which leaves out paths
that differ from another one in the order of their steps and none that is shorter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.grid_moves import (
    ANY_DIRECTION,
    CANONICAL_MOVES,
    COLUMN_STEPS,
    FIRST_DIRECTION,
    ROW_STEPS,
    legal_moves,
)

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


# Lengths are whole numbers, so that equal lengths are equal whatever the order of their steps. A unit is 2⁻³⁶
# of a cell: √2 is off by 3e-12 (rounded), and grids of 2²⁶ cells in a row do not overflow.
_STRAIGHT = 1 << 36
_SLANT = round(_DIAGONAL * _STRAIGHT)
_FAR = 1 << 62

# The open list is a ring of buckets by f (Dial 1969): no heap, pushing and popping cost a few loads. Entries
# of one bucket come out unordered, so a cell may be expanded again when its g still falls; the narrower the
# bucket, the rarer that is. f grows by two diagonals at most from a cell to the next: that bounds the ring.
_BUCKET_BITS = 32  # sixteen buckets per cell
_RING = 64

# A cell's state is one number: the directions in which it can be left (`vslam.grid_moves`), the one by which
# its present g was reached (`ANY_DIRECTION` for the start), and whether it has been expanded since.
_LEGAL, _CAME_BY, _EXPANDED = 0xFF, 8, 1 << 16


@njit(cache=True, inline="always")
def _octile(dr: int, dc: int) -> int:
    """Admissible and consistent h: the path length on an empty grid."""
    dr, dc = abs(dr), abs(dc)
    return _STRAIGHT * max(dr, dc) + (_SLANT - _STRAIGHT) * min(dr, dc)


@njit(cache=True)
def _search(blocked, r0, c0, r1, c1):  # type: ignore[no-untyped-def]  # numba infers
    """Straight and diagonal steps of the best path (−1 when there is none) and its cells."""
    legal = legal_moves(blocked)
    cols = legal.shape[1]
    state = legal.ravel()
    r1, c1 = r1 + 1, c1 + 1  # within the rim
    start, goal = (r0 + 1) * cols + c0 + 1, r1 * cols + c1
    moves = ROW_STEPS * cols + COLUMN_STEPS
    lengths = np.array([_STRAIGHT, _SLANT] * 4)
    g = np.full(len(state), _FAR)
    first = np.full(_RING, -1, dtype=np.int64)  # of each bucket's chain of entries
    entries = np.empty((1024, 2), dtype=np.int64)  # cell, next entry of the chain
    bucket = _octile(r1 - r0 - 1, c1 - c0 - 1) >> _BUCKET_BITS
    g[start] = 0
    state[start] |= ANY_DIRECTION << _CAME_BY
    entries[0], first[bucket % _RING] = (start, -1), 0
    made, waiting, unused = 1, 1, -1  # entries made, entries in buckets, chain of entries to use again
    # the goal's g is final once every bucket that could still lower it is empty
    while waiting > 0 and bucket <= g[goal] >> _BUCKET_BITS:
        entry = first[bucket % _RING]
        if entry < 0:
            bucket += 1
            continue
        node, first[bucket % _RING] = entries[entry]
        entries[entry, 1], unused = unused, entry
        waiting -= 1
        known = state[node]
        if known & _EXPANDED:  # an older, longer entry of the same cell
            continue
        state[node] = known | _EXPANDED
        tried = np.int64(CANONICAL_MOVES[known >> _CAME_BY, known & _LEGAL])
        r = np.int64(np.uint32(node) // np.uint32(cols))  # half the time of a signed division
        c = node - r * cols
        while tried:
            k = np.int64(FIRST_DIRECTION[tried])
            tried &= tried - 1
            near, length = node + moves[k], g[node] + lengths[k]
            if length >= g[near]:
                continue
            g[near] = length
            state[near] = (state[near] & _LEGAL) | k << _CAME_BY
            f = length + _octile(r1 - r - ROW_STEPS[k], c1 - c - COLUMN_STEPS[k])
            slot = max(f >> _BUCKET_BITS, bucket) % _RING  # max: rounding must not lose an entry
            entry = unused
            if entry >= 0:
                unused = entries[entry, 1]
            else:
                if made == len(entries):
                    entries = np.concatenate((entries, np.empty((made, 2), dtype=np.int64)))
                entry = made
                made += 1
            entries[entry, 0], entries[entry, 1], first[slot] = near, first[slot], entry
            waiting += 1
    if g[goal] == _FAR:
        return -1, -1, np.empty((0, 2), dtype=np.int64)
    return _trace(state, moves, start, goal, cols)


@njit(cache=True)
def _trace(state, moves, start, goal, cols):  # type: ignore[no-untyped-def]
    """Walk back from the goal. Steps are counted, so that the cost carries no summation error."""
    node, straight, diagonal = goal, 0, 0
    while node != start:
        k = _came_by(state[node])
        diagonal += k % 2
        straight += 1 - k % 2
        node -= moves[k]
    cells = np.empty((straight + diagonal + 1, 2), dtype=np.int64)
    node = goal
    for i in range(straight + diagonal, -1, -1):
        cells[i, 0], cells[i, 1] = node // cols - 1, node % cols - 1
        if node != start:
            node -= moves[_came_by(state[node])]
    return straight, diagonal, cells


@njit(cache=True, inline="always")
def _came_by(state):  # type: ignore[no-untyped-def]
    """Direction by which a cell was reached."""
    return (state & (_EXPANDED - 1)) >> _CAME_BY
