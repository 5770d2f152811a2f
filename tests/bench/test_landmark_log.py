"""Landmark logs in both text forms, and runs written as g2o, read by GTSAM too."""

import gtsam
import numpy as np
import pandas as pd
import pytest

from bench import cli, g2o
from bench.errors import BenchError
from bench.sequences.landmark_log import load
from vslam.frame import Observations, Odometry
from vslam.geometry import to_local
from vslam.motion import move
from vslam.slam import SlamSettings, run_slam

VICTORIA_PARK = """\
ODOMETRY 0 1 0.5 0.01 0.02 0.0001 0 0 4e-06 0 4e-06
LANDMARK 1 5 11.5 -3.2 0.4 0.1 0.3
ODOMETRY 1 6 0.6 0 -0.01 0.0001 0 0 4e-06 0 4e-06
LANDMARK 6 5 10.9 -3.2 0.4 0 0.4
LANDMARK 6 9 15.2 4.6 0.4 0 0.4
"""


def written(tmp_path, text: str):
    path = tmp_path / "log.txt"
    path.write_text(text)
    return path


def test_victoria_parks_form(tmp_path):
    log = load(written(tmp_path, VICTORIA_PARK))
    assert len(log.steps) == 3 and log.reference is None  # poses 0, 1 and 6
    assert not log.steps[0][0].delta.any() and len(log.steps[0][1]) == 0
    np.testing.assert_allclose(log.steps[1][0].delta, [0.5, 0.01, 0.02])
    np.testing.assert_allclose(log.steps[1][0].covariance, np.diag([1e-4, 4e-6, 4e-6]))
    np.testing.assert_allclose(log.steps[1][1].covariances, [[[0.4, 0.1], [0.1, 0.3]]])
    assert log.steps[2][1].ids.tolist() == [5, 9] and log.landmark_ids.tolist() == [5, 9]


def drive() -> tuple[list[tuple[Odometry, Observations]], np.ndarray, np.ndarray]:
    """A square with four landmarks: steps with noise, true poses, true landmarks."""
    rng = np.random.default_rng(3)
    landmarks = np.array([[1.0, 1.0], [4.0, 1.5], [3.5, 4.0], [0.5, 3.0]])
    Q, S = np.diag([1e-4, 1e-4, 1e-5]), np.diag([4e-4, 9e-4])
    pose, poses, steps = np.zeros(3), [], []
    for k in range(40):
        delta = np.array([0.4, 0.0, np.pi / 2 if k % 10 == 9 else 0.0])
        pose = move(pose, delta)
        poses.append(pose)
        points = to_local(pose, landmarks) + rng.normal(size=(4, 2)) * np.sqrt(np.diag(S))
        noisy = delta + rng.normal(size=3) * np.sqrt(np.diag(Q))
        steps.append((Odometry(noisy, Q), Observations(points, np.array([S] * 4), np.arange(4))))
    return steps, np.array(poses), landmarks


def exported(tmp_path):
    steps, _, _ = drive()
    result = run_slam(steps, SlamSettings("ekf", "annotated", "cartesian"))
    path = tmp_path / "run.g2o"
    path.write_text(g2o.text(steps, result.matches, result.poses, result.landmarks))
    return path, steps, result


def test_a_run_comes_back_from_its_file(tmp_path):
    path, steps, result = exported(tmp_path)
    log = load(path)
    assert len(log.steps) == len(steps) + 1  # the start has a step of its own
    for (odometry, seen), (written_odometry, written_seen) in zip(steps, log.steps[1:], strict=True):
        np.testing.assert_allclose(written_odometry.delta, odometry.delta, atol=1e-10)
        np.testing.assert_allclose(written_odometry.covariance, odometry.covariance, rtol=1e-9)
        np.testing.assert_allclose(written_seen.points, seen.points, atol=1e-10)
        np.testing.assert_allclose(written_seen.covariances, seen.covariances, rtol=1e-9)
    np.testing.assert_allclose(log.reference[1:], result.poses, atol=1e-9)
    np.testing.assert_allclose(log.landmark_positions, result.landmarks, atol=1e-9)


def test_gtsam_reads_the_file_and_smooths_it(tmp_path):
    path, steps, _ = exported(tmp_path)
    graph, initial = gtsam.readG2o(str(path))
    graph.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(), gtsam.noiseModel.Isotropic.Sigma(3, 1e-6)))
    solved = gtsam.LevenbergMarquardtOptimizer(graph, initial).optimize()
    _, true, _ = drive()
    last = solved.atPose2(len(steps))
    assert np.hypot(last.x() - true[-1, 0], last.y() - true[-1, 1]) < 0.05


def test_a_turned_first_pose_is_the_frame(tmp_path):
    text = (
        "VERTEX_SE2 3 1 2 1.5707963267948966\nVERTEX_SE2 7 1 3 3.0\nVERTEX_XY 9 0 2\nFIX 3\n"
        "EDGE_SE2 3 7 1 0 1.43 100 0 0 100 0 400\nEDGE_SE2_XY 3 9 0 1 25 0 25\n"
    )
    log = load(written(tmp_path, text))
    np.testing.assert_allclose(log.reference, [[0, 0, 0], [1, 0, 3.0 - np.pi / 2]], atol=1e-12)
    np.testing.assert_allclose(log.landmark_positions, [[0, 1]], atol=1e-12)
    np.testing.assert_allclose(log.steps[0][1].covariances, [np.eye(2) * 0.04])
    np.testing.assert_allclose(log.steps[1][0].covariance, np.diag([0.01, 0.01, 0.0025]))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "holds no increment"),
        ("EDGE_SE3:QUAT 0 1 0 0\n", "line 1: unknown tag 'EDGE_SE3:QUAT'; known are VERTEX_SE2"),
        ("ODOMETRY 0 1 0.5 0 0 1 0 0 1 0\n", "line 1: expected 11 finite numbers after the tag, got 10"),
        ("ODOMETRY 0 1 0.5 0 nan 1 0 0 1 0 1\n", "line 1: expected 11 finite numbers"),
        ("ODOMETRY 0 1 0.5 0 x 1 0 0 1 0 1\n", "line 1: holds something that is no number"),
        ("ODOMETRY 0 1 0.5 0 0 1 2 0 1 0 1\n", "line 1: its covariance is not positive definite"),
        ("EDGE_SE2 0 1 0.5 0 0 0 0 0 1 0 1\n", "line 1: its information is not positive definite"),
        (VICTORIA_PARK + "ODOMETRY 1 0 0 0 0 1 0 0 1 0 1\n", "line 6: a second increment from pose 1, to 0"),
        (VICTORIA_PARK + "ODOMETRY 7 8 0 0 0 1 0 0 1 0 1\n", "form no chain"),
        ("ODOMETRY 0 1 0 0 0 1 0 0 1 0 1\nODOMETRY 1 0 0 0 0 1 0 0 1 0 1\n", "form no chain"),
        (VICTORIA_PARK + "LANDMARK 77 5 1 1 1 0 1\n", "seen from pose 77"),
    ],
)
def test_what_is_wrong_is_one_line(tmp_path, text, expected):
    with pytest.raises(BenchError) as error:
        load(written(tmp_path, text))
    assert expected in str(error.value) and "\n" not in str(error.value)


def test_a_missing_file_is_one_line(tmp_path):
    with pytest.raises(BenchError, match="cannot be read"):
        load(tmp_path / "none.g2o")


def study(tmp_path, path) -> str:
    text = (
        "sequence: backends\nname: mine\nbackends: [ekf, ekf_fej, graph]\nseeds: 1\n"
        f"drives: [{{source: file, path: {path}, name: mine}}]\n"
    )
    (tmp_path / "mine.yaml").write_text(text)
    return str(tmp_path / "mine.yaml")


@pytest.mark.parametrize("form", ["g2o", "victoria park"])
def test_a_study_runs_on_a_file(tmp_path, form):
    path, steps, _ = exported(tmp_path)
    if form == "victoria park":
        path = tmp_path / "park.txt"
        path.write_text(as_victoria_park(steps))
    options = ["--study", study(tmp_path, path), "--out", str(tmp_path / "results"), "--workers", "1"]
    assert cli.execute(["run", *options]) == 0
    runs = pd.read_parquet(tmp_path / "results" / "latest" / "runs.parquet")
    assert set(runs["backend"]) == {"ekf", "ekf_fej", "graph", "graph_smoothed"}
    assert (runs["status"] == "ok").all() and (runs["landmarks_mapped"] == 4).all()
    assert (runs["rmse_m"] < 0.05).all()  # of the log's own solution, both times
    written = sorted((tmp_path / "results" / "latest" / "g2o").glob("*.g2o"))
    assert len(written) == 4 and len(load(written[0]).steps) == len(steps) + 2


def as_victoria_park(steps) -> str:
    def upper(matrix):
        return " ".join(f"{v:.9g}" for v in matrix[np.triu_indices(len(matrix))])

    lines = []
    for k, (odometry, seen) in enumerate(steps):
        moved = " ".join(f"{v:.9g}" for v in odometry.delta)
        lines.append(f"ODOMETRY {k} {k + 1} {moved} {upper(odometry.covariance)}")
        for point, covariance, number in zip(seen.points, seen.covariances, seen.ids, strict=True):
            lines.append(
                f"LANDMARK {k + 1} {1000 + number} {point[0]:.9g} {point[1]:.9g} {upper(covariance)}"
            )
    return "\n".join(lines)


def test_a_bad_file_of_a_study_is_one_line(tmp_path, capsys):
    (tmp_path / "bad.g2o").write_text("NOTHING 1\n")
    options = ["--study", study(tmp_path, tmp_path / "bad.g2o"), "--out", str(tmp_path / "results")]
    assert cli.execute(["run", *options, "--workers", "1"]) == 2
    assert "line 1: unknown tag 'NOTHING'" in capsys.readouterr().err.splitlines()[-1]
