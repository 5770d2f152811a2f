"""The follower on ways whose geometry is known: a straight, a corner, a U-turn, an arc."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.follower import FollowerSettings, PathFollower

DT = 0.1


def driven(
    path: object, pose: tuple[float, float, float], steps: int = 600
) -> tuple[NDArray[np.float64], float]:
    """Exact unicycle motion under the follower's commands; the poses, and seconds until arrival."""
    follower, state, own = PathFollower(path), np.array(pose, dtype=float), FollowerSettings()  # type: ignore[arg-type]
    poses = [state.copy()]
    for k in range(steps):
        if follower.arrived(state):
            return np.array(poses), k * DT
        command = follower.command(state)
        assert 0.0 <= command.speed_mps <= own.speed_mps + 1e-12
        assert abs(command.turn_radps) <= own.turn_radps + 1e-12
        for _ in range(10):
            h = DT / 10
            middle = state[2] + command.turn_radps * h / 2
            state = state + h * np.array(
                [command.speed_mps * np.cos(middle), command.speed_mps * np.sin(middle), command.turn_radps]
            )
            poses.append(state.copy())
    raise AssertionError(f"never arrived, ended at {state}")


def off(poses: NDArray[np.float64], path: object) -> NDArray[np.float64]:
    """Distance of each pose to a polyline."""
    vertices = np.asarray(path, dtype=float)
    best = np.full(len(poses), np.inf)
    for a, b in pairwise(vertices):
        leg = b - a
        t = np.clip((poses[:, :2] - a) @ leg / (leg @ leg), 0, 1)
        best = np.minimum(best, np.linalg.norm(poses[:, :2] - a - t[:, None] * leg, axis=1))
    return best


def test_a_straight_is_driven_at_full_speed_and_kept() -> None:
    path = [[0, 0], [10, 0]]
    poses, seconds = driven(path, (0, 0, 0))
    assert off(poses, path).max() < 1e-9
    assert np.linalg.norm(poses[-1, :2] - [10, 0]) <= FollowerSettings().arrival_m
    assert 10 / 0.93 < seconds < 10 / 0.93 + 2.0  # the last 0.6 m fall off exponentially, τ = 0.65 s


def test_an_offset_from_a_straight_decays_without_crossing_far() -> None:
    path = [[0, 0], [10, 0]]
    poses, _ = driven(path, (0, 0.3, 0))
    later = poses[poses[:, 0] > 3.0]
    assert np.abs(later[:, 1]).max() < 0.03
    assert poses[:, 1].min() > -0.05


def test_a_right_angle_is_turned_on_the_spot() -> None:
    path = [[0, 0], [4, 0], [4, 4]]
    poses, _ = driven(path, (0, 0, 0))
    assert off(poses, path).max() < 0.1
    assert np.linalg.norm(poses - [4, 0, np.pi / 4], axis=1).min() < 0.15  # half turned, in it


def test_a_u_turn_stays_on_its_two_legs() -> None:
    path = [[0, 0], [3, 0], [3, 0.4], [0, 0.4]]
    poses, _ = driven(path, (0, 0, 0))
    assert off(poses, path).max() < 0.1
    back_again = [[0, 0], [3, 0], [0, 0]]
    poses, _ = driven(back_again, (0, 0, 0))
    assert off(poses, back_again).max() < 0.1
    assert poses[:, 0].max() > 3 - FollowerSettings().arrival_m - 1e-9  # the tip is not left out


def test_an_arc_is_cut_by_less_than_the_carrots_sagitta() -> None:
    """The chord of length L in a circle of radius r lies L²/8r inside it at the most."""
    angle = np.linspace(-np.pi / 2, np.pi, 200)
    path = 1.5 * np.stack([np.cos(angle), np.sin(angle)], axis=1) + [0, 1.5]
    poses, _ = driven(path, (0, 0, 0))
    assert off(poses, path).max() < 0.6**2 / (8 * 1.5) + 0.02


def test_a_goal_behind_is_turned_to_first() -> None:
    poses, _ = driven([[0, 0], [-3, 0]], (0, 0, 0))
    turned = int(np.argmax(np.abs(poses[:, 2]) > np.pi - 0.2))
    assert np.linalg.norm(poses[:turned, :2], axis=1).max() < 1e-9


def test_being_there_already_is_arrival() -> None:
    assert PathFollower([[1.0, 1.0]]).arrived(np.array([1.02, 1.0, 2.0]))


@pytest.mark.parametrize("path", [np.zeros((0, 2)), [[0, np.nan], [1, 1]], [0.0, 1.0]])
def test_no_way_is_one_line(path: object) -> None:
    with pytest.raises(VslamError, match="follower: needs a finite"):
        PathFollower(path)  # type: ignore[arg-type]
