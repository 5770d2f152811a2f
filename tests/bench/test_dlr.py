"""The reader of the DLR log: on a log of three steps written here, and on the real one where it is."""

import json

import numpy as np
import pytest

from bench.errors import BenchError
from bench.sequences import dlr

LOG = """\
# a comment
STEP pic.0000 0.10 -0.50 0.20 4e-4 1e-5 9e-4 2e-5 3e-5 1e-4
LANDMARK_C 0.30 -2.00 0.9 0.01 0.001 0.04 7
LANDMARK_C -0.40 -3.00 0.8 0.01 0.000 0.02 -1

STEP pic.0001 0.00 -0.10 0.00 4e-4 0 9e-4 0 0 1e-4
STEP pic.0002 0.00 -0.10 0.00 4e-4 0 9e-4 0 0 1e-4
LANDMARK_C 0.10 -1.00 0.9 0.01 0.000 0.04 3
"""
FOUR_POSES = [[0.0, 0.0, 0.0], [0.1, -0.5, 0.2], [0.1, -0.6, 0.2], [0.1, -0.7, 7.0]]


def write(folder, **changes):
    files = {
        "map.circles": LOG,
        "truth.txt": "".join(json.dumps(pose + [0.0] * 9) + "\n" for pose in FOUR_POSES),
        "batch_poses.csv": "x_m,y_m,theta_rad\n" + "".join(f"{x},{y},{t}\n" for x, y, t in FOUR_POSES),
        "batch_landmarks.csv": "id,x_m,y_m\n7,0.4,-2.5\n3,0.2,-1.7\n",
    }
    files.update({name.replace("_dot_", "."): text for name, text in changes.items()})
    for name, text in files.items():
        if text is not None:
            (folder / name).write_text(text)
    return folder


def test_axes_are_turned_to_x_forward_and_y_left(tmp_path):
    log = dlr.load(write(tmp_path))
    odometry, observations = log.steps[0]
    # −Y of the log is forward, +X is left.
    np.testing.assert_allclose(odometry.delta, [0.50, 0.10, 0.20])
    np.testing.assert_allclose(
        odometry.covariance, [[9e-4, -1e-5, -3e-5], [-1e-5, 4e-4, 2e-5], [-3e-5, 2e-5, 1e-4]], rtol=1e-12
    )
    np.testing.assert_allclose(observations.points, [[2.00, 0.30], [3.00, -0.40]])
    np.testing.assert_allclose(observations.covariances[0], [[0.04, -0.001], [-0.001, 0.01]])
    np.testing.assert_allclose(log.truth[3], [0.7, 0.1, 7.0])
    np.testing.assert_allclose(log.batch_poses, log.truth)


def test_what_belongs_to_which_step(tmp_path):
    log = dlr.load(write(tmp_path))
    assert [o.ids.tolist() for _, o in log.steps] == [[7, -1], [], [3]]
    assert log.image_names == ("pic.0000.jpg", "pic.0001.jpg", "pic.0002.jpg")
    assert log.landmark_ids.tolist() == [3, 7]
    np.testing.assert_allclose(log.landmark_positions, [[1.7, 0.2], [2.5, 0.4]])


def test_without_the_batch_solution_landmarks_stand_where_the_true_track_saw_them(tmp_path):
    log = dlr.load(write(tmp_path, batch_landmarks_dot_csv=None, batch_poses_dot_csv=None))
    assert log.batch_poses is None and log.landmark_ids.tolist() == [3, 7]
    pose, (_, seen) = log.truth[1], log.steps[0]
    c, s = np.cos(pose[2]), np.sin(pose[2])
    x, y = seen.points[0]
    np.testing.assert_allclose(log.landmark_positions[1], pose[:2] + np.array([c * x - s * y, s * x + c * y]))


def replaced(old, new):
    assert old in LOG
    return LOG.replace(old, new, 1)


STEP_2 = "STEP pic.0001 0.00 -0.10 0.00 4e-4 0 9e-4 0 0 1e-4"


@pytest.mark.parametrize(
    ("log", "line", "reason"),
    [
        (replaced(" 7\n", "\n"), 3, "LANDMARK_C has 7 fields, expected 8"),
        (replaced(" -1\n", " -1 5\n"), 4, "LANDMARK_C has 9 fields, expected 8"),
        (replaced(STEP_2, STEP_2 + " 1"), 6, "STEP has 12 fields, expected 11"),
        (replaced(STEP_2, STEP_2.replace("-0.10", "nan")), 6, "not finite"),
        (replaced("-3.00", "-inf"), 4, "not finite"),
        (replaced("-3.00", "three"), 4, "'three' is not a number"),
        (replaced(STEP_2, STEP_2.replace("STEP", "STOP")), 6, "unknown keyword 'STOP'"),
        (
            replaced(STEP_2, STEP_2.replace("9e-4", "-9e-4")),
            6,
            "odometry covariance is not positive semi-definite",
        ),
        (replaced("0.01 0.000 0.02", "0.01 0.100 0.02"), 4, "landmark covariance is not positive definite"),
        (replaced("0.01 0.000 0.02", "0.00 0.000 0.02"), 4, "landmark covariance is not positive definite"),
        (replaced(" 7\n", " 7.5\n"), 3, "whole number"),
        (replaced(" 7\n", " -2\n"), 3, "whole number"),
        (replaced(" 7\n", " 8\n"), 3, "not in batch_landmarks.csv"),
        (LOG.split("\n", 2)[2], 1, "before the first STEP"),
    ],
)
def test_a_malformed_row_is_named(tmp_path, log, line, reason):
    with pytest.raises(BenchError, match=rf"map\.circles, line {line}: .*{reason}") as caught:
        dlr.load(write(tmp_path, map_dot_circles=log))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("file", "text", "reason"),
    [
        ("truth.txt", "[0, 0, 0]\n", "truth.txt, line 1: the list has 3 fields, expected 12"),
        ("truth.txt", "0 0 0\n", "truth.txt, line 1: not a bracketed list"),
        ("truth.txt", '{"x": 1}\n', "truth.txt, line 1: not a bracketed list"),
        ("truth.txt", "[[0], 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]\n", "truth.txt, line 1: not a bracketed list"),
        (
            "truth.txt",
            "[0, NaN, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]\n" * 4,
            "truth.txt, line 1: a value is not finite",
        ),
        ("truth.txt", "[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]\n" * 3, "3 poses for 3 steps; expected 4"),
        ("truth.txt", "", "0 poses for 3 steps"),
        ("batch_poses.csv", "x,y\n", "batch_poses.csv, line 1: expected the header 'x_m,y_m,theta_rad'"),
        ("batch_poses.csv", "", "batch_poses.csv, line 1: expected the header"),
        (
            "batch_poses.csv",
            "x_m,y_m,theta_rad\n0,0\n",
            "batch_poses.csv, line 2: the row has 2 fields, expected 3",
        ),
        (
            "batch_landmarks.csv",
            "id,x_m,y_m\n3,0,0\n7,1,1\n7,2,2\n",
            "line 4: this landmark id occurs a second",
        ),
        ("batch_landmarks.csv", "id,x_m,y_m\n3,0,x\n", "line 2: 'x' is not a number"),
        ("batch_landmarks.csv", "id,x_m,y_m\n-1,0,0\n", "line 2: a landmark id is a whole number from 0"),
        ("batch_landmarks.csv", "id,x_m,y_m\n", "no data rows"),
        ("map.circles", "# nothing\n", "map.circles: no data rows"),
    ],
)
def test_a_malformed_file_is_named(tmp_path, file, text, reason):
    write(tmp_path)
    (tmp_path / file).write_text(text)
    with pytest.raises(BenchError, match=reason):
        dlr.load(tmp_path)


@pytest.mark.parametrize("file", ["map.circles", "truth.txt"])
def test_a_missing_file_says_what_to_do(tmp_path, file):
    write(tmp_path)
    (tmp_path / file).unlink()
    with pytest.raises(BenchError, match=rf"cannot read .*{file}: No such file .*bench fetch dlr"):
        dlr.load(tmp_path)


def test_a_binary_file_says_so(tmp_path):
    write(tmp_path)
    (tmp_path / "truth.txt").write_bytes(b"\x89PNG\r\n\xff\xd8")
    with pytest.raises(BenchError, match="not a plain text file"):
        dlr.load(tmp_path)


def test_the_real_log_holds_what_its_description_counts(dlr_folder):
    log = dlr.load(dlr_folder)
    ids = np.concatenate([o.ids for _, o in log.steps])
    assert len(log.steps) == len(log.image_names) == 3297
    assert ((ids >= 0).sum(), (ids == -1).sum(), len(np.unique(ids[ids >= 0]))) == (14309, 436, 576)
    assert sum(len(o) == 0 for _, o in log.steps) == 84
    travelled = sum(np.hypot(*u.delta[:2]) for u, _ in log.steps)
    assert travelled == pytest.approx(505.006, abs=5e-4)
    points = np.concatenate([o.points for _, o in log.steps])
    assert np.hypot(*points.T).min() > 0.9 and np.hypot(*points.T).max() < 4.4
    # All ahead of the robot: the camera looks forward.
    assert np.abs(np.degrees(np.arctan2(points[:, 1], points[:, 0]))).max() < 58.5
    assert log.image_names[42] == "dlr-spatial_cognition-e.0042.jpg"


def test_the_true_track_sees_the_landmarks_where_they_are(dlr_folder, tmp_path):
    """Mirrored axes or a heading of the wrong sign would put them metres away."""
    log = dlr.load(dlr_folder)
    for name in (dlr.LOG, dlr.TRUTH):
        (tmp_path / name).symlink_to((dlr_folder / name).resolve())
    placed = dlr.load(tmp_path)
    np.testing.assert_array_equal(placed.landmark_ids, log.landmark_ids)
    apart = np.hypot(*(placed.landmark_positions - log.landmark_positions).T)
    assert np.sqrt((apart**2).mean()) < 0.05
    assert log.batch_poses is not None
    off = (log.batch_poses - log.truth)[:, :2]
    assert np.sqrt((off**2).sum(axis=1).mean()) == pytest.approx(0.023, abs=1e-3)
