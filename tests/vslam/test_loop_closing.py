"""Whole drives: a simulated building whose truth is known, one that repeats itself, and the real log."""

import numpy as np
import pytest

from bench.metrics import landmarks, trajectory
from bench.replay import true_landmarks
from bench.sequences.dlr import load
from tests.vslam.simulated_building import simulate
from vslam.errors import VslamError
from vslam.frame import Observations, Odometry
from vslam.slam import Slam, SlamSettings, run_slam

CONSTELLATION = SlamSettings(association="constellation", observation="cartesian")

# A loop of corridors, once more round, then home the other way.
TOUR = [(0, 0), (16, 0), (16, 10), (0, 10), (0, 0), (16, 0), (16, 10), (8, 10), (0, 10), (0, 0)]


def without_ids(steps):
    return [(u, Observations(o.points, o.covariances, np.full(len(o), -1))) for u, o in steps]


def scores(building, result):
    seen = [o.ids for _, o in building.steps]
    return landmarks.evaluate(result.landmarks, result.matches, seen, building.discs)


def rmse(poses, truth):
    return trajectory.evaluate(poses, truth).rmse_m


def test_closes_the_loops_of_a_building():
    building = simulate(11, TOUR)
    steps = without_ids(building.steps)
    result, gated = run_slam(steps, CONSTELLATION), run_slam(steps, SlamSettings(observation="cartesian"))
    ours, icnn = scores(building, result), scores(building, gated)
    assert ours.association_precision > 0.99 and ours.association_recall > 0.98
    assert ours.landmarks_duplicated <= 1 < 20 < icnn.landmarks_duplicated
    assert ours.landmarks_mapped >= 0.97 * len(building.discs)
    # As near to the truth as a smoother that was told which disc is which.
    told = run_slam(building.steps, SlamSettings("graph", "annotated", "cartesian"))
    assert result.smoothed is not None and told.smoothed is not None
    smoothed, best = (rmse(r.smoothed.poses, building.truth) for r in (result, told))
    assert smoothed < best + 0.05
    # A map in the result, numbered as first mentioned, with covariances that are ones.
    first = np.unique(np.concatenate(result.matches), return_index=True)[1][1:]
    assert (np.diff(first) > 0).all() and len(first) == len(result.landmarks)
    assert np.linalg.eigvalsh(result.landmark_covariances).min() > 0
    assert np.linalg.eigvalsh(result.covariances[1:]).min() > 0


def test_a_building_that_repeats_itself_is_not_paired_one_period_off():
    """Rows of discs at equal distances: more than one alignment fits, and what is merged is right
    all the same."""
    along = np.arange(0.0, 16.0, 1.0)
    row = [np.column_stack([along, np.full(16, y + side)]) for y in (0.0, 10.0) for side in (-1.0, 1.0)]
    across = np.arange(1.0, 10.0, 1.0)
    row += [np.column_stack([np.full(9, x + side), across]) for x in (0.0, 16.0) for side in (-1.0, 1.0)]
    building = simulate(4, TOUR, discs=np.unique(np.concatenate(row).round(3), axis=0))
    result = run_slam(without_ids(building.steps), CONSTELLATION)
    assert scores(building, result).association_precision > 0.99


def test_the_same_drive_gives_the_same_bytes_and_an_empty_one_nothing():
    steps = without_ids(simulate(1, TOUR).steps[:150])
    one, other = (run_slam(steps, CONSTELLATION) for _ in range(2))
    assert (
        one.poses.tobytes() == other.poses.tobytes() and one.landmarks.tobytes() == other.landmarks.tobytes()
    )
    none = run_slam([], CONSTELLATION)
    assert none.poses.shape == (0, 3) and none.landmarks.shape == (0, 2) and none.matches == ()


def test_a_drive_that_sees_nothing_is_its_odometry():
    steps = [(u, Observations.none()) for u, _ in simulate(1, TOUR).steps[:80]]
    result = run_slam(steps, CONSTELLATION)
    assert result.smoothed is not None and len(result.landmarks) == 0
    np.testing.assert_allclose(result.smoothed.poses, result.poses, atol=1e-6)


def test_bad_input_names_the_step_and_a_single_picture_is_refused():
    steps = without_ids(simulate(1, TOUR).steps[:8])
    steps[5] = (Odometry(np.full(3, np.nan), np.eye(3)), steps[5][1])
    with pytest.raises(VslamError, match=r"SLAM step 5: .*finite"):
        run_slam(steps, CONSTELLATION)
    with pytest.raises(VslamError, match="needs the whole drive"):
        Slam(CONSTELLATION).step(*steps[0])


def test_the_first_loops_of_the_real_log(dlr_folder):
    """The first 1,320 steps, 200 m: gating alone leaves 20 duplicates there; the study `dlr` replays
    the rest."""
    log = load(dlr_folder)
    count = 1320
    result = run_slam(without_ids(log.steps[:count]), CONSTELLATION)
    marks = landmarks.evaluate(
        result.landmarks, result.matches, true_landmarks(log)[:count], log.landmark_positions, unlabelled=True
    )
    assert marks.association_precision > 0.98 and marks.association_recall > 0.98
    assert marks.landmarks_duplicated <= 10
    assert result.smoothed is not None
    assert rmse(result.smoothed.poses, log.truth[1 : count + 1]) < 1.0
