import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bench.errors import BenchError
from bench.metrics import trajectory
from bench.schema import RUN_COLUMNS

# A straight true track of four poses, and an estimate that is off by (0.3, 0.4), (0, 0), (−0.3, 0), (0, 0.4).
TRUE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
OFF = np.array([[0.3, 0.4, 0.1], [0.0, 0.0, 0.0], [-0.3, 0.0, 0.0], [0.0, 0.4, 0.0]])
ESTIMATED = TRUE + OFF


def test_golden_values():
    scores = trajectory.evaluate(ESTIMATED, TRUE)
    # Squares: x 0.09, 0, 0.09, 0; y 0.16, 0, 0, 0.16.
    assert scores.rmse_x_m == pytest.approx(np.sqrt(0.18 / 4), abs=1e-12)
    assert scores.rmse_y_m == pytest.approx(np.sqrt(0.32 / 4), abs=1e-12)
    assert scores.rmse_m == pytest.approx(np.sqrt(0.50 / 4), abs=1e-12)
    assert scores.sq_err_x_max == pytest.approx(0.09, abs=1e-12)
    assert scores.sq_err_y_max == pytest.approx(0.16, abs=1e-12)
    assert np.isnan(scores.nees)
    ranges = trajectory.squared_error_range(ESTIMATED, TRUE)
    np.testing.assert_allclose(ranges, [[0.0, 0.09], [0.0, 0.16]], atol=1e-12)


def test_the_truth_scores_perfectly():
    scores = trajectory.evaluate(TRUE, TRUE, np.tile(np.eye(3), (4, 1, 1)))
    assert all(v == pytest.approx(0.0, abs=1e-12) for k, v in vars(scores).items() if k[:3] != "rpe")


def test_names_are_those_of_the_run_table():
    assert set(vars(trajectory.evaluate(TRUE, TRUE))) <= set(RUN_COLUMNS)


tracks = st.integers(3, 30).flatmap(
    lambda n: st.integers(0, 2**32 - 1).map(lambda s: np.random.default_rng(s).uniform(-10, 10, (n, 3)))
)


@given(tracks, st.floats(-4, 4), st.floats(-50, 50), st.floats(-50, 50))
def test_alignment_undoes_any_rigid_motion(track, angle, x, y):
    c, s = np.cos(angle), np.sin(angle)
    moved = np.column_stack([track[:, :2] @ np.array([[c, s], [-s, c]]) + [x, y], track[:, 2] + angle])
    back = trajectory.align(moved, track)
    np.testing.assert_allclose(back[:, :2], track[:, :2], atol=1e-9)
    np.testing.assert_allclose(np.exp(1j * back[:, 2]), np.exp(1j * track[:, 2]), atol=1e-9)


@given(tracks, st.integers(0, 1000))
def test_alignment_is_the_best_rigid_one(track, seed):
    """SciPy's Kabsch in space, applied to points of the plane, as the independent answer."""
    noisy = track + np.random.default_rng(seed).normal(0.0, 0.5, track.shape)
    a, b = (np.pad(t[:, :2] - t[:, :2].mean(axis=0), ((0, 0), (0, 1))) for t in (noisy, track))
    turn, _ = Rotation.align_vectors(b, a)
    expected = np.sqrt(((turn.apply(a) - b) ** 2).sum(axis=1).mean())
    aligned = trajectory.evaluate(noisy, track).rmse_aligned_m
    # In space a half turn about an axis of the plane mirrors it, which may fit a few random points better.
    assert aligned >= expected - 1e-9
    if abs(turn.as_matrix()[2, 2] - 1.0) < 1e-6:
        assert aligned == pytest.approx(expected, abs=1e-6)
    assert aligned <= trajectory.position_rmse(noisy, track) + 1e-12


def test_nees_by_hand():
    covariances = np.tile(np.diag([0.04, 0.16, 0.01]), (4, 1, 1))
    per_step = trajectory.nees(ESTIMATED, TRUE, covariances)
    np.testing.assert_allclose(per_step, [0.09 / 0.04 + 1.0 + 1.0, 0.0, 0.09 / 0.04, 1.0])
    assert trajectory.evaluate(ESTIMATED, TRUE, covariances).nees == pytest.approx(per_step.mean())


def test_nees_takes_the_short_way_round():
    estimated = TRUE + np.array([0.0, 0.0, 4 * np.pi + 0.1])
    np.testing.assert_allclose(trajectory.nees(estimated, TRUE, np.tile(np.eye(3), (4, 1, 1))), 0.01)


def test_nees_leaves_out_what_is_certain():
    covariances = np.tile(np.eye(3), (4, 1, 1))
    covariances[0] = 0.0
    covariances[1] = np.outer([1.0, 2.0, 3.0], [1.0, 2.0, 3.0])
    assert np.isnan(trajectory.nees(ESTIMATED, TRUE, covariances)).tolist() == [True, True, False, False]
    # Small is not singular: millimetres and milliradians.
    assert np.isfinite(trajectory.nees(ESTIMATED, TRUE, np.tile(1e-9 * np.eye(3), (4, 1, 1)))).all()


def test_the_nees_band_holds_its_share():
    low, high = trajectory.nees_band(50)
    assert low < 3.0 < high
    errors = np.random.default_rng(3).standard_normal((4000, 50, 3))
    means = (errors**2).sum(axis=2).mean(axis=1)
    # 95 % ± 3 standard errors of a share of 4000.
    assert abs(((means > low) & (means < high)).mean() - 0.95) < 3 * np.sqrt(0.95 * 0.05 / 4000)


@pytest.mark.parametrize(
    ("estimated", "true", "message"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3)), "estimated track: expected poses"),
        (TRUE[:, :2], TRUE, "estimated track: expected poses"),
        (TRUE, TRUE[0], "true track: expected poses"),
        (TRUE[:3], TRUE, "3 estimated poses for 4 true ones"),
        (np.where(ESTIMATED == 2.0, np.nan, TRUE), TRUE + np.array([np.nan, 0, 0]), "is not finite"),
    ],
)
def test_malformed_tracks_raise(estimated, true, message):
    with pytest.raises(BenchError, match=message):
        trajectory.evaluate(estimated, true)


def test_malformed_covariances_and_bands_raise():
    with pytest.raises(BenchError, match=r"covariances: expected finite \(4, 3, 3\)"):
        trajectory.nees(TRUE, TRUE, np.zeros((3, 3, 3)))
    with pytest.raises(BenchError, match="NEES band"):
        trajectory.nees_band(0)


def evo_track(poses):
    """For evo, the independent implementation."""
    from evo.core.trajectory import PoseTrajectory3D

    n = len(poses)
    half = poses[:, 2] / 2
    quaternions = np.column_stack([np.cos(half), np.zeros((n, 2)), np.sin(half)])
    return PoseTrajectory3D(
        np.column_stack([poses[:, :2], np.zeros(n)]), quaternions, np.arange(n, dtype=float)
    )


@pytest.mark.parametrize("seed", [0, 1])
def test_absolute_and_relative_pose_error_are_those_of_evo(seed):
    from evo.core import metrics

    generator = np.random.default_rng(seed)
    true = np.cumsum(generator.uniform(-0.5, 1.0, (60, 3)), axis=0)
    estimated = true + np.cumsum(generator.normal(0.0, 0.05, (60, 3)), axis=0)
    ours = trajectory.evaluate(estimated, true)

    def of_evo(metric, a, b):
        metric.process_data((a, b))
        return metric.get_statistic(metrics.StatisticsType.rmse)

    reference, estimate = evo_track(true), evo_track(estimated)
    part, frames = metrics.PoseRelation, metrics.Unit.frames
    assert ours.rmse_m == pytest.approx(of_evo(metrics.APE(part.translation_part), reference, estimate))
    steps = {"delta": trajectory.RPE_STEPS, "delta_unit": frames, "all_pairs": True}
    translation = metrics.RPE(part.translation_part, **steps)
    assert ours.rpe_m == pytest.approx(of_evo(translation, reference, estimate))
    turn = metrics.RPE(part.rotation_angle_deg, **steps)
    assert ours.rpe_deg == pytest.approx(of_evo(turn, reference, estimate))
    estimate.align(reference)
    assert ours.rmse_aligned_m == pytest.approx(
        of_evo(metrics.APE(part.translation_part), reference, estimate)
    )


def test_relative_errors_by_hand():
    """A turn of 90° too far at the start shows in each motion's direction, not in later turns."""
    estimated = TRUE.copy()
    estimated[:, 2] = np.pi / 2
    estimated[:, :2] = TRUE[:, 1::-1]
    np.testing.assert_allclose(trajectory.relative_errors(estimated, TRUE, 1), 0.0, atol=1e-12)
    np.testing.assert_allclose(trajectory.relative_errors(ESTIMATED, TRUE, 3)[0, 1], 0.1)
    assert trajectory.relative_errors(TRUE, TRUE, 9).shape == (0, 2)
    with pytest.raises(BenchError, match="at least 1 step"):
        trajectory.relative_errors(TRUE, TRUE, 0)
