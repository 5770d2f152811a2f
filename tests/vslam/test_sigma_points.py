"""The partitioned sigma points against sigma points over everything."""

import numpy as np
import pytest
from scipy.stats import norm

from tests.vslam.drives import Q, S, circle, run
from vslam.backends.parts import many_poses, sigma_points
from vslam.frame import Observations, Odometry
from vslam.motion import move
from vslam.observation import observation_models
from vslam.slam_backend import NEW, create

FORMS = ["cartesian", "range_bearing"]


def whole_state_ukf(state, P, f, noise, spread=3.0):
    """The unscented transform over a whole state and its noise, written out point by point."""
    n = len(state) + len(noise)
    joint = np.zeros((n, n))
    joint[: len(state), : len(state)] = np.linalg.cholesky(P)
    joint[len(state) :, len(state) :] = np.linalg.cholesky(noise)
    centre = np.concatenate([state, np.zeros(len(noise))])
    steps = np.sqrt(spread) * joint.T
    points = np.vstack([centre, centre + steps, centre - steps])
    w_m = np.full(2 * n + 1, 0.5 / spread)
    w_m[0] = 1.0 - n / spread
    w_c = w_m.copy()
    w_c[0] += 2.0  # 1 − α² + β with α = 1, β = 2
    y = np.array([f(p[: len(state)], p[len(state) :]) for p in points])
    mean = y[0] + w_m @ (y - y[0])
    off, x = y - mean, points[:, : len(state)] - state
    return mean, (w_c[:, None] * off).T @ off, (w_c[:, None] * x).T @ off


@pytest.mark.parametrize("form", FORMS)
def test_points_over_pose_and_seen_landmarks_are_points_over_everything(form):
    """Motion, measurement and founding of the UKF, with landmarks in the map that nobody sees."""
    model = observation_models.get(form)()
    drive, *_ = circle(np.random.default_rng(1), steps=6, landmarks=40, per_picture=6, Q=9 * Q, S=9 * S)
    ukf = run("ukf", model, drive)
    n = len(ukf.landmarks)
    assert n >= 6
    x, P = np.concatenate([ukf.pose, ukf.landmarks.ravel()]), ukf.covariance

    u = Odometry(np.array([0.4, 0.1, 0.3]), 9 * Q)

    def motion(state, v):
        return np.concatenate([move(state[:3], u.delta, v), state[3:]])

    ukf.predict(u)
    mean, P_moved, _ = whole_state_ukf(x, P, motion, u.covariance)
    np.testing.assert_allclose(np.concatenate([ukf.pose, ukf.landmarks.ravel()]), mean, atol=1e-12)
    np.testing.assert_allclose(ukf.covariance, P_moved, atol=1e-12)

    # only landmarks 0 and 1, which the Cholesky factor of [R, L_0, L_1, …] lists first
    seen = model.h(mean[:3], mean[3:7].reshape(2, 2)) + 0.05
    points = many_poses.place(model, np.zeros((1, 3)), seen[None])[0]
    o = Observations(points, np.tile(4 * S, (2, 1, 1)), np.array([0, 1]))
    z, R = model.measure(o)

    def measurement(state, v):
        return model.h(state[:3], state[3:7].reshape(2, 2)).ravel() + v

    noise = np.zeros((4, 4))
    noise[:2, :2], noise[2:, 2:] = R
    expected, S_Z, P_xz = whole_state_ukf(mean, P_moved, measurement, noise)
    K = P_xz @ np.linalg.inv(S_Z)
    ukf.update(o, np.array([0, 1]))
    after = mean + K @ model.innovation(z, expected.reshape(2, 2)).ravel()
    P_after = P_moved - K @ S_Z @ K.T
    np.testing.assert_allclose(np.concatenate([ukf.pose, ukf.landmarks.ravel()]), after, atol=1e-10)
    np.testing.assert_allclose(ukf.covariance, P_after, atol=1e-10)

    new = Observations(np.array([[2.0, 1.0]]), 9 * S[None], np.array([99]))
    z, R = model.measure(new)
    ukf.update(new, np.array([NEW]))
    mean, P_all, _ = whole_state_ukf(
        after, P_after, lambda s, v: np.concatenate([s, model.g(s[:3], (z[0] + v)[None])[0]]), R[0]
    )
    np.testing.assert_allclose(np.concatenate([ukf.pose, ukf.landmarks.ravel()]), mean, atol=1e-10)
    np.testing.assert_allclose(ukf.covariance, P_all, atol=1e-10)


@pytest.mark.parametrize("rule_of", [sigma_points.unscented, sigma_points.cubature])
@pytest.mark.parametrize("n", [1, 3, 6, 11, 23])
def test_moments_of_a_quadratic(rule_of, n):
    """Σ a_i s_i² of unit normals: the mean is exact to third degree; the covariance is never negative."""
    a = np.linspace(0.5, 1.5, n)
    rule = rule_of(n)
    y = (sigma_points.offsets(n, rule) ** 2 @ a)[:, None]
    moments = sigma_points.transform(y - y[0], rule)
    assert y[0, 0] + moments.offset[0] == pytest.approx(a.sum())
    assert moments.covariance[0, 0] >= 0.0
    np.testing.assert_allclose(moments.slopes, 0.0, atol=1e-12)


def test_the_unscented_rule_knows_the_fourth_moment_in_one_dimension():
    rule = sigma_points.unscented(1)
    y = np.sin(sigma_points.offsets(1, rule))
    moments = sigma_points.transform(y - y[0], rule)
    grid = np.linspace(-8, 8, 4001)
    weights = norm.pdf(grid) * (grid[1] - grid[0])
    slope = (weights * grid * np.sin(grid)).sum()  # E[s sin s] = exp(−1/2)
    assert moments.slopes[0, 0] == pytest.approx(slope, abs=0.05)


@pytest.mark.parametrize("form", FORMS)
def test_many_poses_at_once_are_one_after_the_other(form):
    model, generator = observation_models.get(form)(), np.random.default_rng(0)
    poses, landmarks = generator.uniform(-2, 2, (5, 3)), generator.uniform(3, 6, (5, 4, 2))
    z = np.stack([model.h(p, m) for p, m in zip(poses, landmarks, strict=True)])
    np.testing.assert_allclose(many_poses.measure(model, poses, landmarks), z, atol=1e-12)
    np.testing.assert_allclose(many_poses.place(model, poses, z), landmarks, atol=1e-12)
    H_R, H_L = many_poses.jacobians(model, poses, landmarks)
    for i in range(5):
        R, L = model.h_jacobians(poses[i], landmarks[i])
        np.testing.assert_allclose(H_R[i], R, atol=1e-12)
        np.testing.assert_allclose(H_L[i], L, atol=1e-12)
        _, G_z = model.g_jacobians(poses[i], z[0])
        np.testing.assert_allclose(many_poses.place_jacobians(model, poses, z[0])[i], G_z, atol=1e-12)


def test_a_root_of_a_semi_definite_matrix():
    A = np.array([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 0.0, 3.0]])
    P = A @ A.T
    np.testing.assert_allclose(sigma_points.factor(P) @ sigma_points.factor(P).T, P, atol=1e-12)
    wide = np.random.default_rng(0).standard_normal((4, 9))
    L = sigma_points.lower_triangle(wide)
    np.testing.assert_allclose(L, np.tril(L))
    np.testing.assert_allclose(L @ L.T, wide @ wide.T, atol=1e-12)


def test_a_certain_robot_can_see():
    """P_RR = 0 before any motion."""
    for name in ("ukf", "ckf", "srckf"):
        backend = create(name, observation_models.get("cartesian")(), 0, {})
        seen = Observations(np.array([[2.0, 1.0]]), S[None], np.array([0]))
        backend.update(seen, np.array([NEW]))
        np.testing.assert_allclose(backend.landmark_covariances[0], S, rtol=1e-9, atol=1e-15)
        backend.update(Observations(seen.points + 0.01, S[None], seen.ids), np.array([0]))
        np.testing.assert_allclose(backend.landmark_covariances[0], S / 2, rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(backend.landmarks[0], [2.005, 1.005], rtol=1e-9)
