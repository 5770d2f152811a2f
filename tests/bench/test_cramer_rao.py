"""The bound against a batch information matrix, and against what estimators reach."""

import numpy as np
import pytest

from bench.drive_choice import LoopDrive
from bench.metrics import cramer_rao
from bench.sequences.drive import recorded
from bench.sequences.simulated import round_loop
from vslam.motion import motion_jacobians
from vslam.observation import Cartesian
from vslam.slam import SlamSettings, run_slam

LOOP = LoopDrive(source="loop", length_m=8, width_m=6, laps=1, landmarks=12)


def batch_bound(drive, until):
    """P of the last pose: inverse of the information of the whole path and map up to a step."""
    ids = sorted({int(i) for _, o in drive.steps[:until] for i in o.ids})
    n = 3 * until + 2 * len(ids)
    information = np.zeros((n, n))
    poses = np.vstack([np.zeros((1, 3)), drive.truth])
    for k, (u, o) in enumerate(cramer_rao.without_noise(drive)[:until]):
        F_R, F_n = motion_jacobians(poses[k], u.delta)
        J = np.zeros((3, n))
        J[:, 3 * k : 3 * k + 3] = np.eye(3)
        if k:
            J[:, 3 * k - 3 : 3 * k] = -F_R
        information += J.T @ np.linalg.inv(F_n @ u.covariance @ F_n.T) @ J
        H_R, H_L = Cartesian().h_jacobians(poses[k + 1], drive.landmark_positions[o.ids])
        for i, S, R, L in zip(o.ids, o.covariances, H_R, H_L, strict=True):
            J = np.zeros((2, n))
            J[:, 3 * k : 3 * k + 3] = R
            at = 3 * until + 2 * ids.index(int(i))
            J[:, at : at + 2] = L
            information += J.T @ np.linalg.inv(S) @ J
    return np.linalg.inv(information)[3 * until - 3 : 3 * until, 3 * until - 3 : 3 * until]


def test_the_recursion_is_the_batch_information():
    drive = round_loop(LOOP, seed=3, run=0)
    P = cramer_rao.bound(drive)
    for until in (1, 20, len(drive.steps)):
        np.testing.assert_allclose(P[until - 1], batch_bound(drive, until), rtol=1e-6, atol=1e-12)
    expected = np.sqrt(np.mean(P[:, 0, 0] + P[:, 1, 1]))
    assert cramer_rao.position_bound(drive) == pytest.approx(expected)


def test_the_noise_that_happened_does_not_matter():
    """Two repetitions differ in what is detected; with every look a hit they have one bound."""
    sure = LOOP.model_copy(update={"sensor": LOOP.sensor.model_copy(update={"detection": 1.0})})
    one, other = (cramer_rao.position_bound(round_loop(sure, 3, run)) for run in (0, 1))
    assert one == pytest.approx(other, rel=1e-9)


def test_the_mean_over_runs_lies_at_the_bound():
    """Mild noise: the EKF is efficient, so its mean squared error is the bound's, within sampling."""
    squared, bounds = [], []
    for run in range(40):
        drive = round_loop(LOOP, 5, run)
        result = run_slam(drive.steps, SlamSettings("ekf", "annotated", "cartesian"))
        squared.append(((result.poses - drive.truth)[:, :2] ** 2).sum(axis=1).mean())
        bounds.append(cramer_rao.position_bound(drive) ** 2)
    ratio = np.mean(squared) / np.mean(bounds)
    assert abs(ratio - 1.0) < 3 * np.std(squared) / np.mean(squared) / np.sqrt(40)


def test_the_bound_of_the_dlr_log(dlr_folder):
    """An independent code gets 0.962 m on a copy of the log that lacks 72 of its 14,309 rows."""
    from bench.sequences.dlr import load

    assert cramer_rao.position_bound(recorded(load(dlr_folder))) == pytest.approx(0.962, abs=0.03)
