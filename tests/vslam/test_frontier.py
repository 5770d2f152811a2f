"""Frontiers of a grid small enough to see them."""

from __future__ import annotations

import numpy as np

from vslam.frontier import frontier_cells, frontiers

MAP = """
?????????
?#######?
?#.....#?
?#..#..??
?#..#...?
?########
"""
#          column 7 of row 4 and the end of row 3 look into the unknown


def parsed(text: str) -> tuple[np.ndarray, np.ndarray]:
    cells = np.array([list(line) for line in text.split()])
    return cells == ".", cells == "?"


def test_frontiers_by_hand() -> None:
    free, unknown = parsed(MAP)
    assert np.argwhere(frontier_cells(free, unknown)).tolist() == [[3, 6], [4, 7]]
    (group,) = frontiers(free, unknown)
    assert group.tolist() == [[3, 6], [4, 7]]  # they touch by a corner


def test_two_openings_are_two_frontiers_and_small_ones_are_left_out() -> None:
    free, unknown = np.ones((3, 9), bool), np.zeros((3, 9), bool)
    unknown[:, 0], unknown[1, 8] = True, True
    free &= ~unknown
    assert [len(g) for g in frontiers(free, unknown)] == [3, 3]  # (0, 8), (1, 7), (2, 8) touch
    assert frontiers(free, unknown)[0].tolist() == [[0, 1], [1, 1], [2, 1]]
    assert frontiers(free, unknown, min_cells=4) == []


def test_a_known_or_an_unknown_map_has_none() -> None:
    free = np.ones((4, 4), bool)
    assert frontiers(free, ~free) == []
    assert frontiers(~free, free) == []
