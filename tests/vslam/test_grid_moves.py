"""Legal and canonical moves against their definitions, by Dijkstra in the nine cells round a cell."""

import heapq
from itertools import product

import numpy as np
import pytest

from vslam.grid_moves import CANONICAL_MOVES, COLUMN_STEPS, FIRST_DIRECTION, ROW_STEPS, legal_moves

STEPS = list(zip(ROW_STEPS.tolist(), COLUMN_STEPS.tolist(), strict=True))
CENTRE = (1, 1)


def may_go(free, cell, step):
    """A step to a free cell; a diagonal one with both orthogonal neighbours free."""
    (r, c), (dr, dc) = cell, step
    return all(
        0 <= row < free.shape[0] and 0 <= col < free.shape[1] and free[row, col]
        for row, col in ((r + dr, c + dc), (r + dr, c), (r, c + dc))
    )


def shortest_without_centre(free, start):
    """Lengths of the shortest paths from a cell to the others that do not lead over the middle one."""
    best, heap = {start: 0.0}, [(0.0, start)]
    while heap:
        length, cell = heapq.heappop(heap)
        for step in STEPS:
            near = (cell[0] + step[0], cell[1] + step[1])
            further = length + np.hypot(*step)
            if near != CENTRE and may_go(free, cell, step) and further < best.get(near, np.inf) - 1e-9:
                best[near] = further
                heapq.heappush(heap, (further, near))
    return best


def neighbourhoods():
    """All 256 of a free cell."""
    for bits in product([False, True], repeat=8):
        free = np.ones(9, dtype=bool)
        free[[0, 1, 2, 3, 5, 6, 7, 8]] = bits
        yield free.reshape(3, 3)


def test_steps_turn_by_eighths():
    angles = np.arctan2(-ROW_STEPS, COLUMN_STEPS) % (2 * np.pi)
    np.testing.assert_allclose(angles, np.arange(8) * np.pi / 4)


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (23, 31)])
def test_legal_moves_of_a_grid(shape):
    free = np.random.default_rng(3).random(shape) < 0.7
    moves = legal_moves(~free)
    assert moves.shape == (shape[0] + 2, shape[1] + 2)
    assert not moves[[0, -1]].any() and not moves[:, [0, -1]].any()
    for cell in np.argwhere(free).tolist():
        expected = sum(1 << d for d in range(8) if may_go(free, cell, STEPS[d]))
        assert moves[cell[0] + 1, cell[1] + 1] == expected


def test_what_the_rules_leave_out_has_an_earlier_path_of_no_greater_length():
    """Harabor & Grastien's definition: after a straight step a path of equal length suffices, as it turns
    earlier; after a diagonal one it must be shorter. All neighbourhoods, all ways to enter.
    """
    entered = 0
    for free in neighbourhoods():
        legal = int(legal_moves(~free)[2, 2])
        for d, (dr, dc) in enumerate(STEPS):
            parent = (1 - dr, 1 - dc)
            if not free[parent] or not may_go(free, parent, (dr, dc)):
                continue
            entered += 1
            around, expected = shortest_without_centre(free, parent), 0
            for k, step in enumerate(STEPS):
                if not legal >> k & 1:
                    continue
                over = np.hypot(dr, dc) + np.hypot(*step)
                otherwise = around.get((1 + step[0], 1 + step[1]), np.inf)
                needless = otherwise < over - 1e-9 if d % 2 else otherwise <= over + 1e-9
                expected |= (not needless) << k
            assert CANONICAL_MOVES[d, legal] == expected, (free, d)
    assert entered == 4 * 128 + 4 * 32


def test_first_directions():
    assert all(FIRST_DIRECTION[1 << d | 0x80] == d for d in range(8))
