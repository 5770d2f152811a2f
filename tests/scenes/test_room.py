"""Walls with openings, checkers, and the distance from furniture: areas and distances by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenes.clearance import clearance
from scenes.geometry import box, checker, join, rectangle, surface
from scenes.model import Material
from scenes.room import Opening, Room, panes, windows

GREY = Material((0.5, 0.5, 0.5), 1.0)
ROOM = Room(6.0, 4.0, 3.0)
INWARDS = {
    "south": [0, 1, 0],
    "east": [-1, 0, 0],
    "north": [0, -1, 0],
    "west": [1, 0, 0],
    "ceiling": [0, 0, -1],
}


def areas(piece):
    """Area vector of each triangle, (n, 3)."""
    corner = piece[0][piece[1]]
    return np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) / 2


@pytest.mark.parametrize("side", INWARDS)
def test_wall_less_its_openings(side):
    """Face areas add up to wall less openings, facing inwards; reveals face each other and cancel out."""
    holes = [Opening(0.5, 1.7, 0.4, 2.0, 0.2), Opening(2.2, 3.0, 1.0, 2.5, 0.2)]
    whole, pierced = (areas(join(ROOM.wall(side, o))) for o in ((), holes))
    inwards = np.array(INWARDS[side], dtype=float)
    np.testing.assert_allclose(whole.sum(axis=0), np.linalg.norm(whole, axis=1).sum() * inwards, atol=1e-9)
    gap = 1.2 * 1.6 + 0.8 * 1.5
    np.testing.assert_allclose(pierced.sum(axis=0), whole.sum(axis=0) - gap * inwards, atol=1e-9)
    sides = np.linalg.norm(pierced, axis=1).sum() - (pierced @ inwards).sum()
    assert sides == pytest.approx(0.2 * 2 * (1.2 + 1.6 + 0.8 + 1.5))


@pytest.mark.parametrize(("side", "left"), [("north", 0), ("east", 4), ("south", 6), ("west", 0)])
def test_left_is_left_as_seen_from_inside(side, left):
    """The first tenth of a wall: facing north the left is west, facing east it is north, and so on."""
    vertices, _ = ROOM.panel(side, Opening(0.0, 0.1, 0.0, 1.0, 0.0))
    along = vertices[:, 0 if side in ("north", "south") else 1]
    assert np.abs(along - left).max() <= 0.1 + 1e-9
    assert set(vertices[:, 2]) == {0.0, 1 / 3, 2 / 3, 1.0}


@pytest.mark.parametrize("side", INWARDS)
def test_panel_fills_its_opening(side):
    opening = Opening(0.5, 1.4, 0.0, 2.0, 0.0)
    filled = areas(join([*ROOM.wall(side, [opening]), ROOM.panel(side, opening)]))
    np.testing.assert_allclose(filled.sum(axis=0), areas(join(ROOM.wall(side))).sum(axis=0), atol=1e-9)


def test_panes_and_windows():
    many = windows(10.0, 4, 1.5, 1.0, 2.0)
    assert [o.left for o in many] == pytest.approx([0.5, 3.0, 5.5, 8.0])
    glass = panes(Opening(0.0, 2.0, 0.0, 1.0), 3, 2, 0.1)
    assert sum((o.right - o.left) * (o.high - o.low) for o in glass) == pytest.approx(1.8 * 0.9)
    assert len(glass) == 6 and max(o.right for o in glass) == pytest.approx(2.0)


@given(st.integers(1, 9), st.integers(1, 9))
def test_checker_shares_out_the_floor(n_u, n_v):
    """Neighbours differ: a field is even where its column and row add up to an even number."""
    if n_u * n_v < 2:
        return
    even, odd = checker((1, 2, 0), (n_u, 0, 0), (0, n_v, 0), (n_u, n_v))
    for parity, piece in enumerate((even, odd)):
        field = np.floor(piece[0][piece[1]].mean(axis=1)[:, :2] - [1, 2]).astype(int)
        assert (field.sum(axis=1) % 2 == parity).all()
        assert len(np.unique(field, axis=0)) == (n_u * n_v + 1 - parity) // 2
        np.testing.assert_allclose(areas(piece).sum(axis=0), [0, 0, len(field) / 2], atol=1e-9)
        assert len(np.unique(piece[0], axis=0)) == len(piece[0])


def test_clearance_by_hand():
    """Beside a box, off its corner, under a table top, under a lamp, and on the bare floor."""
    things = [
        surface("box", GREY, box((0, 0, 0), (1, 1, 0.5))),
        surface("table top", GREY, box((3, 0, 0.7), (4, 1, 0.75), bottom=True)),
        surface("lamp", GREY, box((6, 0, 2.4), (7, 1, 2.6), bottom=True)),
        surface("floor", GREY, rectangle((-9, -9, 0), (20, 0, 0), (0, 20, 0))),
    ]
    points = np.array([[1.3, 0.5], [1.3, 1.4], [0.41, 0.43], [3.57, 0.52], [6.5, 0.5], [-0.6, -0.8]])
    np.testing.assert_allclose(clearance(points, things), [0.3, 0.5, 0.0, 0.0, 2.5, 1.0], atol=1e-9)
    assert np.isinf(clearance(points, things[3:])).all()
