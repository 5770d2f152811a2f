import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from vslam.errors import VslamError
from vslam.frame import Observations
from vslam.geometry import to_local
from vslam.observation import Cartesian, RangeBearing, observation_models

metres = st.floats(-20.0, 20.0)
poses = st.tuples(metres, metres, st.floats(-10.0, 10.0)).map(np.array)
points = st.tuples(metres, metres).map(np.array)
models = st.sampled_from([RangeBearing(), Cartesian()])
NEAR_M = 0.3  # nearer, the bearing bends too much for finite differences to be exact


def central_differences(f, x, difference, step=1e-6):
    columns = [difference(f(x + step * e), f(x - step * e)) / (2 * step) for e in np.eye(len(x))]
    return np.stack(columns, axis=1)


@given(models, poses, points)
def test_jacobians_of_h_are_the_derivatives(model, pose, landmark):
    assume(np.hypot(*(landmark - pose[:2])) > NEAR_M)
    H_R, H_L = model.h_jacobians(pose, landmark[None])
    by_pose = central_differences(lambda R: model.h(R, landmark[None])[0], pose, model.innovation)
    by_landmark = central_differences(lambda L: model.h(pose, L[None])[0], landmark, model.innovation)
    np.testing.assert_allclose(H_R[0], by_pose, atol=1e-6)
    np.testing.assert_allclose(H_L[0], by_landmark, atol=1e-6)


@given(models, poses, points)
def test_jacobians_of_g_are_the_derivatives(model, pose, landmark):
    assume(np.hypot(*(landmark - pose[:2])) > NEAR_M)
    z = model.h(pose, landmark[None])[0]
    G_R, G_z = model.g_jacobians(pose, z[None])
    by_pose = central_differences(lambda R: model.g(R, z[None])[0], pose, np.subtract)
    by_z = central_differences(lambda m: model.g(pose, m[None])[0], z, np.subtract)
    np.testing.assert_allclose(G_R[0], by_pose, atol=1e-6)
    np.testing.assert_allclose(G_z[0], by_z, atol=1e-6)


@given(models, poses, points)
def test_g_is_the_inverse_of_h(model, pose, landmark):
    assume(np.hypot(*(landmark - pose[:2])) > 1e-3)
    np.testing.assert_allclose(model.g(pose, model.h(pose, landmark[None]))[0], landmark, atol=1e-9)


@given(models, poses, points)
def test_a_measured_point_is_the_landmark_in_the_robots_frame(model, pose, landmark):
    """`measure` and `h` describe one measurement: a perfect observation has no innovation."""
    assume(np.hypot(*(landmark - pose[:2])) > 1e-3)
    z, _ = model.measure(Observations(to_local(pose, landmark[None]), np.eye(2)[None], np.array([0])))
    np.testing.assert_allclose(model.innovation(z, model.h(pose, landmark[None])), 0.0, atol=1e-8)


def test_the_polar_covariance_is_that_of_polar_samples():
    generator = np.random.default_rng(5)
    point, S = np.array([2.0, -1.5]), np.array([[4e-4, 1e-4], [1e-4, 9e-4]])
    _, polar = RangeBearing().measure(Observations(point[None], S[None], np.array([0])))
    samples = generator.multivariate_normal(point, S, 200_000)
    sampled = np.cov(np.hypot(*samples.T), np.arctan2(samples[:, 1], samples[:, 0]))
    # Relative error of a sampled variance is √(2/n) = 0.3 %; five of them.
    np.testing.assert_allclose(
        polar[0], sampled, rtol=0.016, atol=0.016 * np.sqrt(polar[0, 0, 0] * polar[0, 1, 1])
    )


def test_a_bearing_just_across_the_back_is_a_small_innovation():
    innovation = RangeBearing().innovation(np.array([[1.0, 3.1]]), np.array([[1.0, -3.1]]))
    np.testing.assert_allclose(innovation, [[0.0, 6.2 - 2 * np.pi]])


def test_a_point_at_the_origin_has_no_bearing():
    with pytest.raises(VslamError, match="no bearing"):
        RangeBearing().measure(Observations(np.zeros((1, 2)), np.eye(2)[None], np.array([0])))


@pytest.mark.parametrize("name", observation_models.names())
def test_no_landmark_is_no_trouble(name):
    model, pose = observation_models.get(name)(), np.zeros(3)
    z, S = model.measure(Observations.none())
    assert z.shape == (0, 2) and S.shape == (0, 2, 2)
    assert model.h(pose, np.zeros((0, 2))).shape == (0, 2)
    assert model.g_jacobians(pose, z)[0].shape == (0, 2, 3)


def test_both_forms_are_registered():
    assert {"range_bearing", "cartesian"} <= set(observation_models.names())
    with pytest.raises(VslamError, match="did you mean 'cartesian'"):
        observation_models.get("cartesion")
