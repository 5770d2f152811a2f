"""The eight moves on a grid without corner cutting, and which of them a shortest-path search has to try.

Directions are numbered 0 … 7 by eighth turns, even ones straight and odd ones diagonal, and a set of
directions is a byte with a bit for each. A diagonal step needs both its orthogonal neighbours free.

Many shortest paths differ in the order of their steps alone. A search needs to follow one of them, which
takes its diagonal steps as early as it can, and may leave out the moves by which none such continues. This
canonical ordering is Sturtevant & Rabin 2016, "Canonical orderings on grids"; its rules are the pruning rules
of jump point search (Harabor & Grastien 2011), here for moves that cut no corner (Harabor & Grastien 2012,
"The JPS pathfinding system").

It does not matter which way a cell was entered when several are equally short. Say that s can be reached best
over n and that the rules leave it out there. Then n was entered from p by a straight step and s lies
diagonally ahead, since in all other cases the rules' reason is a shorter path; and the cell m, diagonally
ahead of p and straight behind s, leads to s as well. Did the rules leave s out at m too, m would have been
entered by a straight step across, and a diagonal to s would be shorter than the two.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

ROW_STEPS = np.array([0, -1, -1, -1, 0, 1, 1, 1])
COLUMN_STEPS = np.array([1, 1, 0, -1, -1, -1, 0, 1])
ANY_DIRECTION = 8
"""In the place of a direction: out of the start, every move is canonical."""


def _first_directions() -> NDArray[np.uint8]:
    """Of each set its lowest direction (0 of the empty one)."""
    return np.array([(s & -s).bit_length() - 1 if s else 0 for s in range(256)], dtype=np.uint8)


def _canonical_moves() -> NDArray[np.uint8]:
    """[d, legal]: the moves to try from a cell that was entered by d and can be left by the legal ones.

    A diagonal step goes on in its own direction and in the two it is made of. A straight step goes on
    straight: what lies beside it was reached earlier by a diagonal. Only where that diagonal is closed, since
    the cell diagonally behind is blocked, must it turn by one or two eighths to that side.
    """
    table = np.empty((ANY_DIRECTION + 1, 256), dtype=np.uint8)
    table[ANY_DIRECTION] = np.arange(256)
    for d in range(8):
        for legal in range(256):
            tried = {d, d + 1, d - 1} if d % 2 else {d}
            for side in (1, -1) if d % 2 == 0 else ():
                if not legal >> (d + 3 * side) % 8 & 1:
                    tried |= {d + side, d + 2 * side}
            table[d, legal] = legal & sum(1 << k % 8 for k in tried)
    return table


FIRST_DIRECTION = _first_directions()
CANONICAL_MOVES = _canonical_moves()


@njit(cache=True)
def legal_moves(blocked: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Directions in which each free cell can be left, (rows + 2, cols + 2) int32: a rim of zeros around.

    Of blocked cells the value means nothing: no move leads to them.
    """
    rows, cols = blocked.shape
    free = np.zeros((rows + 2, cols + 2), dtype=np.uint8)
    for r in range(rows):
        for c in range(cols):
            free[r + 1, c + 1] = not blocked[r, c]
    moves = np.zeros((rows + 2, cols + 2), dtype=np.int32)
    for r in range(1, rows + 1):
        above, here, below, out = free[r - 1], free[r], free[r + 1], moves[r]
        for c in range(1, cols + 1):
            east, north, west, south = here[c + 1], above[c], here[c - 1], below[c]
            north_east, north_west = above[c + 1] & north & east, above[c - 1] & north & west
            south_west, south_east = below[c - 1] & south & west, below[c + 1] & south & east
            out[c] = (
                east
                | north_east << 1
                | north << 2
                | north_west << 3
                | west << 4
                | south_west << 5
                | south << 6
                | south_east << 7
            )
    return moves
