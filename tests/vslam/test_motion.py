import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vslam.geometry import rotation, to_global, to_local, wrap_angle
from vslam.motion import motion_jacobians, move

metres = st.floats(-50.0, 50.0)
angles = st.floats(-10.0, 10.0)
poses = st.tuples(metres, metres, angles).map(np.array)
increments = st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-1.0, 1.0)).map(np.array)


def central_differences(f, x, step=1e-6):
    columns = [(f(x + step * e) - f(x - step * e)) / (2 * step) for e in np.eye(len(x))]
    return np.stack(columns, axis=1)


@given(poses, increments)
def test_jacobians_are_the_derivatives(pose, delta):
    F_R, F_n = motion_jacobians(pose, delta)
    np.testing.assert_allclose(F_R, central_differences(lambda R: move(R, delta), pose), atol=1e-7)
    np.testing.assert_allclose(
        F_n, central_differences(lambda n: move(pose, delta, n), np.zeros(3)), atol=1e-7
    )


def test_driving_a_square_ends_where_it_began_one_turn_later():
    pose = np.zeros(3)
    for _ in range(4):
        pose = move(pose, np.array([2.0, 0.0, np.pi / 2]))
    np.testing.assert_allclose(pose, [0.0, 0.0, 2 * np.pi], atol=1e-12)


def test_left_of_a_robot_that_looks_north_is_west():
    np.testing.assert_allclose(
        move(np.array([5.0, 5.0, np.pi / 2]), np.array([0.0, 1.0, 0.0]))[:2], [4.0, 5.0]
    )


@given(poses, poses)
def test_an_increment_is_the_new_pose_seen_from_the_old(old, new):
    delta = np.append(to_local(old, new[None, :2])[0], new[2] - old[2])
    np.testing.assert_allclose(move(old, delta), new, atol=1e-9)


@given(poses, metres, metres)
def test_the_two_frames_are_inverse(pose, x, y):
    point = np.array([[x, y]])
    np.testing.assert_allclose(to_global(pose, to_local(pose, point)), point, atol=1e-9)


@given(angles)
def test_wrapping_keeps_the_direction(angle):
    wrapped = wrap_angle(angle)
    assert -np.pi <= wrapped < np.pi
    np.testing.assert_allclose(rotation(float(wrapped)), rotation(angle), atol=1e-12)


@pytest.mark.parametrize(
    ("angle", "wrapped"), [(np.pi, -np.pi), (-np.pi, -np.pi), (3.5 * np.pi, -0.5 * np.pi)]
)
def test_pi_wraps_to_minus_pi(angle, wrapped):
    assert wrap_angle(angle) == pytest.approx(wrapped)
