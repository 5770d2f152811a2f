"""The Rao-Blackwellised filters: weights by hand, fair resampling, the same seed, the same run."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from tests.vslam.drives import Q, S, circle, run
from vslam.backends.parts.particles import systematic
from vslam.frame import Observations, Odometry
from vslam.observation import observation_models
from vslam.slam_backend import NEW, create


def test_weights_of_two_landmarks_by_hand():
    """Two particles at known places: w ∝ N(z₁; ẑ₁, S₁ + S) N(z₂; ẑ₂, S₂ + S)."""
    filter_ = create("fastslam1", observation_models.get("cartesian")(), 0, {"particles": 2})
    points = np.array([[2.0, 0.5], [3.0, -1.0]])
    seen = Observations(points, np.tile(S, (2, 1, 1)), np.arange(2))
    filter_.update(seen, np.array([NEW, NEW]))
    moved = np.array([[0.10, 0.02, 0.01], [0.14, -0.01, -0.02]])
    filter_._poses = moved.copy()
    z = points - [0.11, 0.0]
    expected = np.ones(2)
    for i, (x, y, theta) in enumerate(moved):
        c, s = np.cos(theta), np.sin(theta)
        R = np.array([[c, -s], [s, c]])
        for point, measured in zip(points, z, strict=True):
            mean = R.T @ (point - [x, y])
            expected[i] *= multivariate_normal.pdf(measured, mean, R.T @ S @ R + S)
    expected /= expected.sum()
    filter_._resample = lambda: None  # the weights are what is looked at
    filter_.update(Observations(z, np.tile(S, (2, 1, 1)), np.arange(2)), np.array([0, 1]))
    np.testing.assert_allclose(filter_.weights, expected, rtol=1e-10)


def test_weight_and_proposal_of_fastslam_2_by_hand():
    """One landmark, Cartesian, no heading noise: everything is Gaussian and linear."""
    filter_ = create("fastslam2", observation_models.get("cartesian")(), 0, {"particles": 3000})
    seen = Observations(np.array([[2.0, 0.5]]), S[None], np.array([0]))
    filter_.update(seen, np.array([NEW]))
    slide = np.diag([0.2**2, 0.1**2, 0.0])
    filter_.predict(Odometry(np.array([0.3, 0.0, 0.0]), slide))
    z = np.array([1.6, 0.55])
    filter_.update(Observations(z[None], S[None], np.array([0])), np.array([0]))
    S_Z = slide[:2, :2] + 2 * S
    K = -slide[:2, :2] @ np.linalg.inv(S_Z)
    mean = np.array([0.3, 0.0]) + K @ (z - [1.7, 0.5])
    P = slide[:2, :2] - K @ S_Z @ K.T
    np.testing.assert_allclose(filter_.weights, 1 / 3000)  # all particles were in one place: equal weights
    sigma = np.sqrt(P.diagonal())
    np.testing.assert_allclose(filter_._poses[:, :2].mean(axis=0), mean, atol=5 * sigma.max() / np.sqrt(3000))
    np.testing.assert_allclose(np.cov(filter_._poses[:, :2].T), P, atol=0.1 * sigma.max() ** 2)


def test_resampling_keeps_the_distribution():
    generator = np.random.default_rng(0)
    weights = generator.dirichlet(np.full(7, 0.5))
    counts = np.zeros(7)
    for start in (np.arange(2000) + 0.5) / 2000:
        chosen = systematic(weights, start)
        count = np.bincount(chosen, minlength=7)
        assert count.sum() == 7 and np.all(np.diff(chosen) >= 0)
        assert np.all((count == np.floor(7 * weights)) | (count == np.ceil(7 * weights)))
        counts += count
    np.testing.assert_allclose(counts / 2000, 7 * weights, atol=1e-3)


def test_resampling_takes_the_landmarks_along():
    filter_ = create("fastslam1", observation_models.get("cartesian")(), 3, {"particles": 3})
    seen = Observations(np.array([[2.0, 0.5]]), S[None], np.array([0]))
    filter_.predict(Odometry(np.array([0.3, 0.0, 0.1]), Q))
    filter_.update(seen, np.array([NEW]))
    poses, means = filter_._poses.copy(), filter_._means.copy()
    filter_._log_weights = np.log(np.array([1e-12, 1.0 - 2e-12, 1e-12]))
    filter_._resample()
    np.testing.assert_array_equal(filter_._poses, poses[[1, 1, 1]])
    np.testing.assert_array_equal(filter_._means, means[[1, 1, 1]])
    assert filter_.effective_size == pytest.approx(3.0)


@pytest.mark.parametrize("name", ["fastslam1", "fastslam2"])
def test_the_seed_makes_the_run(name):
    model = observation_models.get("cartesian")()
    drive, *_ = circle(np.random.default_rng(1), steps=30, landmarks=15)
    one, again, other = (run(name, model, drive, seed=s, particles=20) for s in (4, 4, 5))
    np.testing.assert_array_equal(one.pose, again.pose)
    np.testing.assert_array_equal(one.landmarks, again.landmarks)
    assert np.abs(one.pose - other.pose).max() > 1e-6


def test_motions_without_pictures_spread_the_particles():
    filter_ = create("fastslam2", observation_models.get("cartesian")(), 0, {"particles": 2000})
    for _ in range(4):
        filter_.predict(Odometry(np.array([0.3, 0.0, 0.0]), np.diag([0.02**2, 0.01**2, 0.0])))
    assert filter_.pose_covariance[0, 0] == pytest.approx(4 * 0.02**2, rel=0.15)
