"""The factor graph against a least-squares solution that knows nothing of GTSAM."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from tests.vslam.drives import circle, run
from vslam.errors import VslamError
from vslam.frame import Observations
from vslam.geometry import wrap_angle
from vslam.motion import move
from vslam.observation import observation_models
from vslam.slam import SlamSettings, run_slam
from vslam.slam_backend import Smoother


def tangent(motion, delta):
    """log(delta⁻¹ motion) of SE(2), turned back into the increment's axes: GTSAM's error of a motion."""
    angle = motion[2] - delta[2]
    c, s = np.cos(delta[2]), np.sin(delta[2])
    turn = np.array([[c, -s], [s, c]])
    half = 0.5 * angle
    a = half / np.tan(half) if abs(half) > 1e-9 else 1.0
    way = np.array([[a, half], [-half, a]]) @ (turn.T @ (motion[:2] - delta[:2]))
    return np.append(turn @ way, angle)


def maximum_likelihood(drive, model, start):
    """All poses and landmarks that minimise the sum of squared Mahalanobis distances (SciPy)."""
    n, ids = len(drive), sorted({int(i) for _, o in drive for i in o.ids})

    def residuals(x):
        poses = np.vstack([np.zeros(3), x[: 3 * n].reshape(n, 3)])
        landmarks = x[3 * n :].reshape(-1, 2)
        parts = []
        for k, (u, o) in enumerate(drive):
            c, s = np.cos(poses[k, 2]), np.sin(poses[k, 2])
            dx, dy = poses[k + 1, :2] - poses[k, :2]
            motion = np.array([c * dx + s * dy, c * dy - s * dx, poses[k + 1, 2] - poses[k, 2]])
            parts.append(np.linalg.solve(np.linalg.cholesky(u.covariance), tangent(motion, u.delta)))
            z, S = model.measure(o)
            rows = [ids.index(int(i)) for i in o.ids]
            Z = model.innovation(z, model.h(poses[k + 1], landmarks[rows]))
            parts += [np.linalg.solve(np.linalg.cholesky(one), e) for one, e in zip(S, Z, strict=True)]
        return np.concatenate(parts)

    return least_squares(residuals, start, xtol=1e-14, ftol=1e-14, gtol=1e-12).x, ids


@pytest.mark.parametrize("form", ["cartesian", "range_bearing"])
def test_the_smoothed_track_is_the_maximum_likelihood(form):
    drive, truth, world = circle(np.random.default_rng(3), steps=25, landmarks=12)
    model = observation_models.get(form)()
    ids = sorted({int(i) for _, o in drive for i in o.ids})
    x, ids = maximum_likelihood(drive, model, np.concatenate([truth.ravel(), world[ids].ravel()]))
    graph = run("graph", model, drive)
    assert isinstance(graph, Smoother)
    smoothed = graph.smooth()
    order = list(dict.fromkeys(int(i) for _, o in drive for i in o.ids))  # numbered at first sight
    np.testing.assert_allclose(smoothed.poses, x[:75].reshape(25, 3), atol=1e-5)
    expected = x[75:].reshape(-1, 2)[[ids.index(i) for i in order]]
    np.testing.assert_allclose(smoothed.landmarks, expected, atol=1e-5)


def test_a_robust_loss_forgives_false_observations():
    """Against the track that the same graph finds without them."""
    drive, *_ = circle(np.random.default_rng(3), steps=60, landmarks=12)
    spoiled = list(drive)
    for k in range(10, 60, 8):
        u, o = spoiled[k]
        if len(o):
            points = o.points.copy()
            points[0] += [1.0, -1.0]
            spoiled[k] = (u, Observations(points, o.covariances, o.ids))
    moved = {}
    for robust in ("none", "huber", "cauchy"):
        settings = SlamSettings("graph", "annotated", "cartesian", parameters={"robust": robust})
        clean, dirty = (run_slam(d, settings).smoothed.poses for d in (drive, spoiled))
        moved[robust] = np.hypot(*(clean - dirty)[:, :2].T).mean()
    assert moved["cauchy"] < moved["huber"] < 0.5 * moved["none"], moved


def test_headings_count_turns():
    drive, truth, _ = circle(np.random.default_rng(3), steps=140, landmarks=12)
    result = run_slam(drive, SlamSettings("graph", "annotated", "cartesian"))
    assert truth[-1, 2] > 4 * np.pi
    for poses in (result.poses, result.smoothed.poses):
        assert np.abs(poses[:, 2] - truth[:, 2]).max() < 0.3


def test_prediction_covariance_is_that_of_the_motion_model():
    drive, *_ = circle(np.random.default_rng(3), steps=10, landmarks=12)
    graph = run("graph", observation_models.get("cartesian")(), drive)
    pose = graph.pose
    graph.predict(drive[0][0])
    np.testing.assert_allclose(graph.pose, move(pose, drive[0][0].delta))
    joint = graph.joint_covariance(np.array([1]))
    np.testing.assert_allclose(joint[:3, :3], graph.pose_covariance)
    assert np.linalg.eigvalsh(joint)[0] > 0.0
    assert abs(wrap_angle(graph.pose[2] - pose[2] - drive[0][0].delta[2])) < 1e-12


def test_both_factorisations_find_the_same_estimate():
    drive, *_ = circle(np.random.default_rng(5), steps=60, landmarks=12)
    qr, cholesky = (
        run_slam(drive, SlamSettings("graph", "annotated", "cartesian", parameters={"factorisation": name}))
        for name in ("qr", "cholesky")
    )
    np.testing.assert_allclose(cholesky.poses, qr.poses, atol=1e-6)
    np.testing.assert_allclose(cholesky.covariances, qr.covariances, rtol=1e-4, atol=1e-9)


def test_an_unknown_factorisation_is_one_line():
    with pytest.raises(VslamError, match="unknown factorisation 'lu': known: qr, cholesky"):
        run_slam((), SlamSettings("graph", parameters={"factorisation": "lu"}))
