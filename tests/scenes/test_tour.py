"""Tours: constant speed, along the way, headings that follow it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes.errors import SceneError
from scenes.tour import drive, orbit, rounded_loop, starting_at

SQUARE = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 6.0], [0.0, 6.0]])


def length(points):
    return np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1).sum()


@settings(deadline=None)
@given(st.floats(0.05, 2.9))
def test_rounded_rectangle_has_its_length(radius):
    """Straight sides lose 2 r at each of four corners and gain a quarter circle."""
    way = rounded_loop(SQUARE, radius)
    assert length(way) == pytest.approx(32.0 - 8 * radius + 2 * np.pi * radius, abs=1e-3)
    assert np.linalg.norm(np.roll(way, -1, axis=0) - way, axis=1).max() < 0.0055


def test_arcs_have_their_radius():
    way = rounded_loop(SQUARE, 1.5)
    corner = way[(way[:, 0] < 1.5) & (way[:, 1] < 1.5)]
    np.testing.assert_allclose(np.linalg.norm(corner - [1.5, 1.5], axis=1), 1.5, atol=1e-9)


def test_loop_may_turn_right_too():
    there, back = rounded_loop(SQUARE, 1.0), rounded_loop(SQUARE[::-1], 1.0)
    assert length(there) == pytest.approx(length(back))

    def area(way):
        return np.sum(way[:, 0] * np.roll(way[:, 1], -1) - np.roll(way[:, 0], -1) * way[:, 1]) / 2

    assert area(there) == pytest.approx(60 - (4 - np.pi) * 1.0, abs=1e-3)
    assert area(back) == pytest.approx(-area(there), rel=1e-6)


def test_corner_that_is_too_tight():
    with pytest.raises(SceneError, match=r"radius 4\.0 m does not fit"):
        rounded_loop(SQUARE, 4.0)


@pytest.mark.parametrize(("speed", "interval"), [(0.93, 0.5), (0.3, 0.1), (2.0, 0.25)])
def test_speed_is_constant(speed, interval):
    tour = drive(rounded_loop(SQUARE, 2.0), 1.0, 60.0, speed, interval)
    np.testing.assert_allclose(np.diff(tour.stamps), interval)
    step = np.linalg.norm(np.diff(tour.poses[:, :2], axis=0), axis=1)
    chord = 2 * 2.0 * np.sin(speed * interval / 2 / 2.0)  # on the tightest arc
    assert step.max() <= speed * interval + 1e-9
    assert step.min() >= chord - 1e-4
    assert tour.stamps[-1] * speed == pytest.approx(60.0, abs=speed * interval)


def test_heading_follows_the_way_and_never_jumps():
    way = rounded_loop(SQUARE, 1.0)
    tour = drive(way, 0.0, 2.5 * length(way), 0.5, 0.1)
    step, heading = np.diff(tour.poses[:, :2], axis=0), tour.poses[:, 2]
    driven = np.arctan2(step[:, 1], step[:, 0])
    middle = (heading[1:] + heading[:-1]) / 2
    np.testing.assert_allclose(np.sin(driven - middle), 0.0, atol=0.02)
    assert np.abs(np.diff(heading)).max() <= 0.05 / 1.0 + 1e-2  # arc length over radius
    assert heading[-1] - heading[0] == pytest.approx(2.5 * 2 * np.pi, abs=np.pi / 2 + 0.1)


def test_one_lap_comes_back():
    way = rounded_loop(SQUARE, 1.0)
    speed = length(way) / 100
    tour = drive(way, 3.0, length(way) * 1.0001, speed, 1.0)
    np.testing.assert_allclose(tour.poses[100, :2], tour.poses[0, :2], atol=1e-6)
    assert tour.poses[100, 2] - tour.poses[0, 2] == pytest.approx(2 * np.pi, abs=1e-6)


@pytest.mark.parametrize(
    "bad", [{"speed_mps": 0.0}, {"interval_s": 0.0}, {"length_m": -1.0}, {"speed_mps": float("nan")}], ids=str
)
def test_impossible_tours(bad):
    arguments = {"start_m": 0.0, "length_m": 10.0, "speed_mps": 1.0, "interval_s": 1.0, **bad}
    with pytest.raises(SceneError, match="tour: "):
        drive(rounded_loop(SQUARE, 1.0), **arguments)


def test_orbit_looks_at_its_centre():
    tour = orbit((2.0, 3.0), 1.5, 1.25, 0.93, 0.5)
    offset = np.array([2.0, 3.0]) - tour.poses[:, :2]
    np.testing.assert_allclose(np.linalg.norm(offset, axis=1), 1.5, rtol=1e-4)
    heading = np.stack([np.cos(tour.poses[:, 2]), np.sin(tour.poses[:, 2])], axis=-1)
    assert (heading * offset).sum(axis=1) == pytest.approx(1.5, rel=1e-3)
    step = np.linalg.norm(np.diff(tour.poses[:, :2], axis=0), axis=1)
    np.testing.assert_allclose(step, 2 * 1.5 * np.sin(0.93 * 0.5 / 1.5 / 2), rtol=1e-3)
    assert np.ptp(tour.poses[:, 2]) == pytest.approx(1.25 * 2 * np.pi, abs=0.93 * 0.5 / 1.5)


def test_way_starts_where_asked():
    way = rounded_loop(SQUARE, 1.0)
    turned = starting_at(way, (5.0, 0.4))
    np.testing.assert_allclose(turned[0], [5.0, 0.0], atol=0.01)
    assert length(turned) == pytest.approx(length(way))
