"""The numbers that independent filters reach on the real log."""

import numpy as np
import pytest

from bench.metrics import trajectory
from bench.replay import dead_reckoning, replay
from bench.schema import RUN_COLUMNS
from bench.sequences.dlr import DlrLog, load
from vslam.frame import Observations, Odometry
from vslam.slam import SlamSettings, run_slam


@pytest.fixture(scope="module")
def log(dlr_folder):
    return load(dlr_folder)


@pytest.mark.parametrize(
    ("observation", "rmse_m", "rmse_aligned_m"), [("cartesian", 1.473, 0.828), ("range_bearing", 3.55, 1.117)]
)
def test_annotated_ids_reach_the_known_error(log, observation, rmse_m, rmse_aligned_m):
    """Reference: an independent textbook EKF, one block update a step, on this very file."""
    result = replay(log, SlamSettings(association="annotated", observation=observation))
    row = result.row
    assert list(row) == list(RUN_COLUMNS)
    assert (row["scene"], row["illumination"], row["filter"], row["status"]) == (
        "dlr",
        "recorded",
        "none",
        "ok",
    )
    assert row["rmse_m"] == pytest.approx(rmse_m, abs=0.05)
    assert row["rmse_aligned_m"] == pytest.approx(rmse_aligned_m, abs=0.05)
    assert (row["landmarks_total"], row["landmarks_mapped"], row["landmarks_duplicated"]) == (576, 576, 0)
    assert row["association_precision"] == row["association_recall"] == 1.0
    # Inconsistent on loops this long, and shown: a consistent filter would have 3.
    assert row["nees"] > 10.0
    assert np.isnan([row[k] for k in ("sun_lux", "bulb_lm", "nav_success", "nav_cost_ratio")]).all()
    assert result.landmark_table.shape == (576, 5) and np.isfinite(result.landmark_table).all()
    np.testing.assert_array_equal(result.landmark_table[:, 0], log.landmark_ids)
    assert result.poses.shape == result.truth.shape == (3297, 3)


def test_first_estimate_jacobians_come_near_the_bound(log):
    """An independent FEJ filter reaches 1.080 m, 0.479 m aligned; the Cramér–Rao bound is 0.96 m."""
    row = replay(log, SlamSettings("ekf_fej", "annotated", "cartesian")).row
    assert 0.95 < row["rmse_m"] <= 1.10
    assert row["rmse_aligned_m"] == pytest.approx(0.479, abs=0.03)
    assert row["landmarks_mapped"] == 576 and row["status"] == "ok"


@pytest.mark.parametrize("name", ["riekf", "ukf", "ckf", "srckf", "information", "fastslam2", "graph"])
def test_every_back_end_begins_the_log_finite_and_positive(log, name):
    """200 steps; the whole log is the study `backends`."""
    result = run_slam(log.steps[:200], SlamSettings(name, "annotated", "cartesian"))
    assert np.isfinite(result.poses).all() and np.isfinite(result.landmarks).all()
    assert np.linalg.eigvalsh(result.covariances)[:, 0].min() > 0.0
    assert np.linalg.eigvalsh(result.landmark_covariances)[:, 0].min() > 0.0
    ekf = run_slam(log.steps[:200], SlamSettings("ekf", "annotated", "cartesian"))
    assert np.hypot(*(result.poses - ekf.poses)[:, :2].T).max() < 1.0


def test_own_association_duplicates_landmarks_and_is_further_off(log):
    """Gating alone closes none of the large loops: known, and not hidden."""
    row = replay(log, SlamSettings(association="icnn", observation="cartesian")).row
    assert row["status"] == "ok" and np.isfinite(row["rmse_m"])
    assert 1.473 < row["rmse_m"] < 29.8
    assert 100 <= row["landmarks_duplicated"] <= 250
    assert 540 <= row["landmarks_mapped"] <= 576
    assert row["association_precision"] > 0.97 and row["association_recall"] > 0.95


def test_dead_reckoning_is_thirty_metres_off(log):
    scores = trajectory.evaluate(dead_reckoning(log), log.truth[1:])
    assert scores.rmse_m == pytest.approx(29.81, abs=0.05)
    assert scores.rmse_aligned_m == pytest.approx(10.03, abs=0.05)


def test_every_covariance_of_the_track_is_finite_and_positive(log):
    result = run_slam(log.steps[:1500], SlamSettings(association="annotated", observation="range_bearing"))
    np.testing.assert_allclose(result.covariances, result.covariances.transpose(0, 2, 1), rtol=0, atol=0)
    assert np.linalg.eigvalsh(result.covariances)[:, 0].min() > 0.0
    assert np.linalg.eigvalsh(result.landmark_covariances)[:, 0].min() > 0.0


def test_a_run_that_breaks_down_is_a_row_and_no_exception():
    bad = (Odometry(np.zeros(3), -np.eye(3)), Observations.none())
    log = DlrLog((bad,), np.zeros((2, 3)), None, np.array([3]), np.zeros((1, 2)), ("pic.jpg",))
    result = replay(log, SlamSettings(), seed=4)
    assert list(result.row) == list(RUN_COLUMNS)
    assert str(result.row["status"]).startswith("failed: SLAM step 0: the odometry covariance")
    assert np.isnan(result.row["rmse_m"]) and result.row["seed"] == 4 and result.row["steps"] == 1
    assert result.poses.shape == (0, 3) and result.landmark_table.shape == (0, 5)
