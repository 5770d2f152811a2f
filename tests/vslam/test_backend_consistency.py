"""Observability: what first-estimate Jacobians and the invariant error are for."""

import numpy as np
import pytest

from tests.vslam.drives import Numbering, Q, S
from vslam.frame import Observations, Odometry
from vslam.observation import observation_models
from vslam.slam_backend import create


def heading_variance(name, disturbed):
    """A robot stands still and sees one landmark ten times; its observations may move the estimate about."""
    generator = np.random.default_rng(0)
    backend, numbering = create(name, observation_models.get("cartesian")(), 0, {}), Numbering()
    backend.predict(Odometry(np.zeros(3), np.diag([0.3, 0.3, 0.3]) ** 2))
    variances = []
    for _ in range(10):
        noise = 0.3 * generator.standard_normal(2) if disturbed else np.zeros(2)
        seen = Observations(np.array([[3.0, 0.0]]) + noise, 0.01**2 * np.eye(2)[None], np.array([0]))
        backend.update(seen, numbering(seen.ids))
        variances.append(backend.pose_covariance[2, 2])
    return np.array(variances)


@pytest.mark.parametrize("name", ["ekf_fej", "riekf"])
def test_a_new_landmark_teaches_no_heading(name):
    """Julier & Uhlmann 2001: a landmark seen for the first time from here cannot say where one looks."""
    np.testing.assert_allclose(heading_variance(name, disturbed=True), 0.09, rtol=1e-9)


def test_the_textbook_filter_believes_it_has_learned_its_heading():
    assert heading_variance("ekf", disturbed=False)[-1] == pytest.approx(0.09, rel=1e-9)
    assert heading_variance("ekf", disturbed=True)[-1] < 0.6 * 0.09


def test_the_invariant_covariance_moves_with_the_estimate():
    """P ← M P Mᵀ by hand, for one correction with a large innovation."""
    made = {}
    for name in ("ekf", "riekf"):
        backend = create(name, observation_models.get("cartesian")(), 0, {})
        backend.predict(Odometry(np.array([1.0, 0.5, 0.2]), Q))
        seen = Observations(np.array([[2.0, 1.0], [3.0, -1.0]]), np.tile(S, (2, 1, 1)), np.array([0, 1]))
        backend.update(seen, Numbering()(seen.ids))
        backend.predict(Odometry(np.array([0.5, 0.0, 0.3]), 10 * Q))
        made[name] = backend
    ekf, riekf = made["ekf"], made["riekf"]
    before = riekf._points(riekf._X)
    np.testing.assert_allclose(ekf.covariance, riekf.covariance, atol=1e-14)
    again = Observations(np.array([[1.9, 0.2], [2.2, -1.5]]), np.tile(S, (2, 1, 1)), np.array([0, 1]))
    for backend in (ekf, riekf):
        backend.update(again, np.array([0, 1]))
    moved = riekf._points(riekf._X) - before
    M = np.eye(7)
    for row, (dx, dy) in zip((0, 3, 5), moved, strict=True):
        M[row, 2], M[row + 1, 2] = -dy, dx
    M[2, 2] = 1.0
    np.testing.assert_allclose(riekf.covariance, M @ ekf.covariance @ M.T, atol=1e-13)


def test_the_exponential_map_is_that_of_the_group():
    """Against a matrix exponential of the Lie algebra of SE(2) with two landmarks."""
    from scipy.linalg import expm

    backend = create("riekf", observation_models.get("cartesian")(), 0, {})
    seen = Observations(np.array([[2.0, 1.0], [3.0, -1.0]]), np.tile(S, (2, 1, 1)), np.array([0, 1]))
    backend.predict(Odometry(np.array([1.0, 0.5, 0.2]), Q))
    backend.update(seen, Numbering()(seen.ids))
    X = backend._points(backend._X)
    group = np.eye(5)
    c, s = np.cos(0.2), np.sin(0.2)
    group[:2, :2], group[:2, 2:] = [[c, -s], [s, c]], X.T
    e = np.array([0.3, -0.2, 0.7, 0.4, 0.1, -0.3, 0.5])  # in e, robot and landmarks
    points = np.array([e[:2], e[3:5], e[5:7]])
    xi = points - e[2] * np.column_stack([-X[:, 1], X[:, 0]])
    algebra = np.zeros((5, 5))
    algebra[:2, :2], algebra[:2, 2:] = [[0.0, -e[2]], [e[2], 0.0]], xi.T
    expected = expm(algebra) @ group
    correction = np.zeros(len(backend._X))
    correction[:7] = e
    backend._retract(correction)
    np.testing.assert_allclose(backend._points(backend._X), expected[:2, 2:].T, atol=1e-12)
    assert backend.pose[2] == pytest.approx(0.2 + 0.7)
