"""``bench score`` against evo, against motions whose error is known, and on broken files."""

import json

import numpy as np
import pytest
from evo.core import metrics, sync
from evo.core.trajectory import PoseTrajectory3D
from scipy.spatial.transform import Rotation

from bench import cli
from bench.errors import BenchError
from bench.metrics.space_trajectory import (
    Alignment,
    SpaceTrack,
    align,
    associate,
    evaluate,
    relative_pose_errors,
)
from bench.trajectory_files import read_truth, read_tum


def wander(seed: int, n: int = 40) -> SpaceTrack:
    rng = np.random.default_rng(seed)
    rotations = Rotation.from_rotvec(np.cumsum(rng.normal(0, 0.1, (n, 3)), axis=0))
    return SpaceTrack(np.arange(n) / 10, np.cumsum(rng.normal(0, 0.2, (n, 3)), axis=0), rotations)


def shaken(track: SpaceTrack, seed: int) -> SpaceTrack:
    rng = np.random.default_rng(seed)
    n = len(track)
    turned = Rotation.from_rotvec(rng.normal(0, 0.02, (n, 3))) * track.rotations
    return SpaceTrack(track.stamps + 0.003, track.positions + rng.normal(0, 0.05, (n, 3)), turned)


def moved(track: SpaceTrack, scale: float = 1.0) -> SpaceTrack:
    turn = Rotation.from_rotvec([0.3, -0.2, 1.1])
    return SpaceTrack(
        track.stamps, scale * turn.apply(track.positions) + [1.0, -2.0, 0.5], turn * track.rotations
    )


def for_evo(track: SpaceTrack) -> PoseTrajectory3D:
    return PoseTrajectory3D(track.positions, track.rotations.as_quat(scalar_first=True), track.stamps)


@pytest.mark.parametrize("alignment", list(Alignment))
@pytest.mark.parametrize("seed", [0, 1])
def test_scores_are_evos(alignment, seed):
    truth, estimate = wander(seed), moved(shaken(wander(seed), seed + 5), scale=1.3)
    ours = evaluate(*associate(estimate, truth, 0.02), alignment, step=3)
    reference, answer = sync.associate_trajectories(for_evo(truth), for_evo(estimate), max_diff=0.02)
    if alignment is not Alignment.none:
        answer.align(reference, correct_scale=alignment is Alignment.sim3)
    ape = metrics.APE(metrics.PoseRelation.translation_part)
    ape.process_data((reference, answer))
    assert ours.ate_rmse_m == pytest.approx(ape.get_statistic(metrics.StatisticsType.rmse), rel=1e-9)
    assert ours.ate_median_m == pytest.approx(ape.get_statistic(metrics.StatisticsType.median), rel=1e-9)
    assert ours.ate_max_m == pytest.approx(ape.get_statistic(metrics.StatisticsType.max), rel=1e-9)
    for relation, value in (
        (metrics.PoseRelation.translation_part, ours.rpe_rmse_m),
        (metrics.PoseRelation.rotation_angle_deg, ours.rpe_rmse_deg),
    ):
        rpe = metrics.RPE(relation, delta=3, delta_unit=metrics.Unit.frames, all_pairs=True)
        rpe.process_data((reference, answer))
        assert value == pytest.approx(rpe.get_statistic(metrics.StatisticsType.rmse), rel=1e-6)


def test_alignment_undoes_a_known_motion():
    truth = wander(3)
    estimate = moved(truth, scale=0.5)
    found, scale = align(estimate, truth, Alignment.sim3)
    assert scale == pytest.approx(2.0, rel=1e-12)
    np.testing.assert_allclose(found.positions, truth.positions, atol=1e-12)
    assert evaluate(moved(truth), truth, Alignment.se3).ate_rmse_m == pytest.approx(0.0, abs=1e-12)
    # no motion of the whole changes how it moves from pose to pose
    np.testing.assert_allclose(relative_pose_errors(moved(truth), truth), 0.0, atol=1e-9)


def test_a_planar_path_is_not_mirrored():
    truth = wander(4)
    flat = SpaceTrack(truth.stamps, truth.positions * [1, 1, 0], truth.rotations)
    found, _ = align(moved(flat), flat, Alignment.se3)
    np.testing.assert_allclose(found.positions, flat.positions, atol=1e-12)
    np.testing.assert_allclose((found.rotations * flat.rotations.inv()).magnitude(), 0, atol=1e-7)


def test_each_true_pose_is_used_once_and_by_the_closest():
    truth = wander(0, 3)  # 0, 0.1, 0.2 s
    stamps = np.array([0.001, 0.004, 0.12, 0.25])
    estimate = SpaceTrack(stamps, np.zeros((4, 3)), Rotation.identity(4))
    ours, true = associate(estimate, truth, 0.02)
    assert ours.stamps.tolist() == [0.001, 0.12] and true.stamps.tolist() == [0.0, 0.1]
    one = truth.at(np.array([1]))
    assert len(associate(estimate, one, 0.05)[0]) == 1


def test_no_overlap_names_both_spans():
    truth = wander(0)
    late = SpaceTrack(truth.stamps + 100, truth.positions, truth.rotations)
    with pytest.raises(BenchError, match=r"spans 100\.000 … 103\.900 s, the truth 0\.000 … 3\.900 s"):
        associate(late, truth)


def test_one_pose_has_no_relative_error():
    one = wander(0).at(np.array([0]))
    assert np.isnan(evaluate(one, one, Alignment.none).rpe_rmse_m)
    with pytest.raises(BenchError, match="stands still"):
        evaluate(one, one, Alignment.sim3)


def tum_text(track: SpaceTrack) -> str:
    rows = np.column_stack([track.stamps, track.positions, track.rotations.as_quat()])
    return "# a comment\n" + "".join(" ".join(f"{v:.9f}" for v in row) + "\n" for row in rows)


def test_both_layouts_and_plain_files_hold_the_same_truth(tmp_path):
    track = wander(7)
    (tmp_path / "tum").mkdir()
    (tmp_path / "tum" / "groundtruth.txt").write_text(tum_text(track))
    folder = tmp_path / "euroc" / "mav0" / "state_groundtruth_estimate0"
    folder.mkdir(parents=True)
    rows = zip(track.stamps, track.positions, track.rotations.as_quat(scalar_first=True), strict=True)
    lines = [f"{round(t * 1e9)},{','.join(map(repr, [*p.tolist(), *q.tolist()]))},0,0,0" for t, p, q in rows]
    (folder / "data.csv").write_text("#timestamp [ns],...\n" + "\n".join(lines))
    for place in (tmp_path / "tum", tmp_path / "euroc", tmp_path / "tum" / "groundtruth.txt"):
        found = read_truth(place)
        np.testing.assert_allclose(found.positions, track.positions, atol=1e-8)
        np.testing.assert_allclose((found.rotations * track.rotations.inv()).magnitude(), 0, atol=1e-7)
        np.testing.assert_allclose(found.stamps, track.stamps, atol=1e-9)


def test_the_command_tells_scores_and_what_is_missing(tmp_path, capsys):
    truth = wander(8)
    (tmp_path / "truth.tum").write_text(tum_text(truth))
    (tmp_path / "answer.tum").write_text(tum_text(moved(truth).at(np.arange(30))))
    options = [
        "score",
        "--trajectory",
        str(tmp_path / "answer.tum"),
        "--sequence",
        str(tmp_path / "truth.tum"),
    ]
    assert cli.execute([*options, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["paired"] == 30 and found["true_poses"] == 40
    assert found["se3"]["ate_rmse_m"] < 1e-6 < found["none"]["ate_rmse_m"]
    assert cli.execute(options) == 0
    assert "10 of 40 true ones have no estimate" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "holds no pose"),
        ("0 0 0 0 0 0 0 1\n0.1 0 0\n", "line 2: expected 8 finite numbers"),
        ("0 0 0 nan 0 0 0 1\n", "line 1: expected 8 finite numbers"),
        ("0 0 0 0 0 0 0 0\n", "its quaternion has length 0.000"),
        ("1 0 0 0 0 0 0 1\n0 0 0 0 0 0 0 1\n", "time does not increase at pose 2"),
    ],
)
def test_broken_files_are_one_line(tmp_path, capsys, text, expected):
    (tmp_path / "answer.tum").write_text(text)
    truth = tmp_path / "truth.tum"
    truth.write_text(tum_text(wander(0)))
    options = ["score", "--trajectory", str(tmp_path / "answer.tum"), "--sequence", str(truth)]
    assert cli.execute(options) == 2
    error = capsys.readouterr().err
    assert expected in error and "answer.tum" in error and error.count("\n") == 1


def test_a_sequence_without_truth_says_what_it_needs(tmp_path):
    with pytest.raises(BenchError, match=r"groundtruth\.txt"):
        read_truth(tmp_path)
    with pytest.raises(BenchError, match="cannot be read"):
        read_tum(tmp_path / "none.tum")
