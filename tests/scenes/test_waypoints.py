"""Driving along way-points: speed, headings, ends."""

from __future__ import annotations

import numpy as np
import pytest

from scenes.errors import SceneError
from scenes.waypoints import TURN_RATE, follow, resampled, smoothed

SQUARE = np.array([[0, 0], [4, 0], [4, 4], [0, 4]], dtype=float)


def test_a_circle_is_driven_at_its_speed_looking_ahead():
    angle = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    circle = 3 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    tour = follow(circle, True, 1.5, speed_mps=0.9, interval_s=0.5)
    assert tour.stamps[-1] == pytest.approx(1.5 * 2 * np.pi * 3 / 0.9, abs=0.5)
    travelled = tour.stamps * 0.9 / 3
    np.testing.assert_allclose(tour.poses[:, 0], 3 * np.cos(travelled), atol=2e-3)
    np.testing.assert_allclose(tour.poses[:, 2], travelled + np.pi / 2, atol=4e-3)


def test_it_turns_on_the_spot_no_faster_than_it_can():
    """There and back again: half a turn at each end takes π / TURN_RATE."""
    way = resampled(np.array([[0, 0], [2, 0]], dtype=float), closed=False)
    there_and_back = np.concatenate([way, way[-2:0:-1]])
    tour = follow(there_and_back, True, 1.0, speed_mps=1.0, interval_s=0.01)
    assert np.abs(np.diff(tour.poses[:, 2])).max() <= TURN_RATE * 0.01 + 1e-9
    assert tour.stamps[-1] == pytest.approx(2 * 2 + 2 * np.pi / TURN_RATE, abs=0.2)


def test_smoothing_rounds_corners_and_keeps_open_ends():
    closed = smoothed(SQUARE, True, 0.3)
    assert np.linalg.norm(closed - SQUARE[1], axis=1).min() > 0.1
    opened = smoothed(SQUARE[:3], False, 0.3)
    np.testing.assert_allclose(opened[[0, -1]], SQUARE[[0, 2]], atol=1e-9)
    assert np.linalg.norm(opened - SQUARE[1], axis=1).min() > 0.1
    np.testing.assert_allclose(smoothed(SQUARE, True, 0.0), resampled(SQUARE, True))


def test_what_cannot_be_driven_is_refused():
    with pytest.raises(SceneError, match="two way-points that differ"):
        resampled(np.zeros((3, 2)), True)
    with pytest.raises(SceneError, match="must be positive"):
        follow(resampled(SQUARE, True), True, 1.0, 0.0, 0.5)
