"""Whether the straight way between two points of a grid is free: every cell that it passes through."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def line_of_sight(blocked, x0, y0, x1, y1):  # type: ignore[no-untyped-def]  # numba infers
    """Whether no blocked cell lies on a segment (Amanatides & Woo 1987).

    A segment through the corner that four cells share passes all four, as A* cuts no corners either.

    Parameters
    ----------
    blocked : (rows, cols) bool
    x0, y0, x1, y1 : float
        Ends in cells: the point (x, y) lies in column ⌊x⌋ and row ⌊y⌋.

    Returns
    -------
    bool; False where the segment leaves the grid.
    """
    rows, cols = blocked.shape
    col, row = int(np.floor(x0)), int(np.floor(y0))
    last_col, last_row = int(np.floor(x1)), int(np.floor(y1))
    if not (0 <= col < cols and 0 <= row < rows and 0 <= last_col < cols and 0 <= last_row < rows):
        return False
    dx, dy = x1 - x0, y1 - y0
    step_col, step_row = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    # the share of the segment at which the next grid line is met, and between two of a kind
    next_col = ((col + 1 - x0) if dx > 0 else (x0 - col)) / abs(dx) if dx != 0.0 else np.inf
    next_row = ((row + 1 - y0) if dy > 0 else (y0 - row)) / abs(dy) if dy != 0.0 else np.inf
    per_col = 1.0 / abs(dx) if dx != 0.0 else np.inf
    per_row = 1.0 / abs(dy) if dy != 0.0 else np.inf
    while True:
        if blocked[row, col]:
            return False
        if (col == last_col and row == last_row) or min(next_col, next_row) > 1.0:
            return not blocked[last_row, last_col]
        if abs(next_col - next_row) < 1e-12:
            if blocked[row, col + step_col] or blocked[row + step_row, col]:
                return False
            col, row = col + step_col, row + step_row
            next_col, next_row = next_col + per_col, next_row + per_row
        elif next_col < next_row:
            col, next_col = col + step_col, next_col + per_col
        else:
            row, next_row = row + step_row, next_row + per_row


@njit(cache=True)
def farthest_in_sight(blocked, path, first):  # type: ignore[no-untyped-def]  # numba infers
    """Index of the last vertex that can be seen from vertex ``first``; at least the next one.

    Parameters
    ----------
    blocked : (rows, cols) bool
    path : (n, 2) float64
        x and y of the vertices, in cells.
    """
    for k in range(len(path) - 1, first + 1, -1):
        if line_of_sight(blocked, path[first, 0], path[first, 1], path[k, 0], path[k, 1]):
            return k
    return first + 1


def pulled_tight(blocked: NDArray[np.bool_], path: NDArray[np.float64]) -> NDArray[np.float64]:
    """Leave out vertices of a path between which the straight way is free (Thorpe 1984; "string pulling").

    Parameters
    ----------
    blocked : (rows, cols) bool
    path : (n, 2) float64
        x and y in cells; each of its segments is free.

    Returns
    -------
    (m, 2) float64, m ≤ n: first and last vertex kept, never longer than ``path``.
    """
    kept = [0]
    while kept[-1] < len(path) - 1:
        kept.append(int(farthest_in_sight(blocked, path, kept[-1])))
    return path[kept]
