"""Balls that a light is said to miss get no light at any point, and it does say so of far ones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from renderers.lights import BulbLight, SunLight, bounding_balls
from scenes.photometry import Photometry

place = st.tuples(*[st.floats(-5, 5)] * 3)
aims = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1)


@given(place, aims, st.floats(5, 120), place, st.floats(0.01, 3))
def test_no_point_of_a_missed_ball_is_lit(position, aim, outer_deg, centre, radius):
    lamp = BulbLight("lamp", 0, position, 0.05, aim, Photometry.spot(0.0, outer_deg))
    (missed,) = lamp.misses(np.array([centre]), np.array([radius]))
    rng = np.random.default_rng(1)
    offset = rng.normal(size=(400, 3))
    offset *= (radius * rng.random(400) ** (1 / 3) / np.linalg.norm(offset, axis=1))[:, None]
    points = (np.array(centre) + offset).astype(np.float32)
    towards = (np.array(position) - points).astype(np.float32)
    towards /= np.maximum(np.linalg.norm(towards, axis=1, keepdims=True), 1e-6)
    _, lux, _ = lamp.arriving(points, towards)
    assert not (missed and lux.any())


def test_a_ceiling_lamp_misses_what_is_far_or_above_and_not_what_is_below():
    lamp = BulbLight("lamp", 0, (0.0, 0.0, 2.6), 0.08, photometry=Photometry.spot(0.0, 75.0))
    balls = np.array([[0.0, 0, 0], [9.0, 0, 0], [14.0, 0, 0], [0, 0, 4.0], [3.0, 0, 2.6]])
    assert lamp.misses(balls, np.full(5, 0.5)).tolist() == [False, False, True, True, True]
    assert not BulbLight("bulb", 0, (0.0, 0.0, 2.6), 0.08).misses(balls, np.full(5, 0.5)).any()


def test_the_sun_misses_nothing_by_day_and_all_by_night():
    balls = np.zeros((2, 3)), np.ones(2)
    assert not SunLight("sun", (0.6, 0.0, 0.8)).misses(*balls).any()
    assert SunLight("sun", (0.6, 0.0, -0.8)).misses(*balls).all()


@pytest.mark.parametrize("count", [1, 7, 8, 9, 100])
def test_bounding_balls_hold_their_points(count):
    points = np.random.default_rng(2).normal(size=(count, 3)).astype(np.float32)
    centres, radii = bounding_balls(points, 8)
    assert len(radii) == -(-count // 8)
    ball = np.arange(count) // 8
    assert (np.linalg.norm(points - centres[ball], axis=1) <= radii[ball]).all()
