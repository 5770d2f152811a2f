"""Back-ends on what the detector found in rendered pictures."""

import numpy as np
import pandas as pd
import pytest

from bench import cli
from bench.progress import Silent
from bench.rendered_run import prepared
from bench.run_facts import RunFacts
from bench.sequences import toured
from bench.study import dump, parse
from bench.tour import perceive
from bench.workers import workers
from vslam.geometry import to_global

pytestmark = pytest.mark.usefixtures("small_halls")

TEXT = """
sequence: backends
name: seen
seeds: 2
engine: raycast
drives:
  - source: rendered
    name: hall
    scene: {name: small-hall}
    light: {name: sun, sun: 0.5}
    sensor: {max_exposure_s: 0.008}
    tour: {frame_interval_s: 1.0}
    odometry: {sigma_heading_rad_per_m: 0.05}
backends: [ekf, ekf_fej, riekf, ukf, ckf, srckf, information, fastslam1, fastslam2, graph]
"""


@pytest.fixture(scope="module")
def hall(cache_home):
    """What the drive of `TEXT` saw, and its scene's poses and discs."""
    study = parse(TEXT, "seen.yaml")
    (choice,) = study.rendered_drives()
    there, facts = toured.rendered(choice, study.seed), RunFacts("raycast")
    with prepared(there, "raycast", facts, Silent()) as setup, workers(1) as pool:
        frames = perceive(setup, pool, facts, Silent())
    return toured.seen(there, frames, "none")


def test_an_observation_lies_where_its_disc_is(hall):
    """In the world, from the true pose: within 10 cm of the disc whose id it has."""
    drive = toured.drive("hall", hall, 0)
    found = 0
    for (_, seen), pose in zip(drive.steps, drive.truth, strict=True):
        known = seen.ids >= 0
        places = to_global(pose, seen.points[known])
        off = np.linalg.norm(places - drive.landmark_positions[seen.ids[known]], axis=1)
        assert (off < 0.1).all()
        found += int(known.sum())
    assert found > len(drive.steps)


def test_repetitions_differ_in_odometry_alone(hall):
    first, second, again = (toured.drive("hall", hall, run) for run in (0, 1, 0))
    for a, b, c in zip(first.steps, second.steps, again.steps, strict=True):
        np.testing.assert_array_equal(a[1].points, b[1].points)
        np.testing.assert_array_equal(a[0].delta, c[0].delta)
    turns = np.array([[a[0].delta[2], b[0].delta[2]] for a, b in zip(first.steps, second.steps, strict=True)])
    assert (turns[0] == 0).all() and (turns[1:, 0] != turns[1:, 1]).all()
    assert first.truth[0] == pytest.approx([0, 0, 0])
    way = np.hypot(*np.diff(first.truth[:, :2], axis=0).T)
    assert way.sum() == pytest.approx(np.hypot(*np.diff(hall.poses[:, :2], axis=0).T).sum())


def test_every_back_end_takes_it_and_beats_its_odometry(tmp_path, cache_home, hall):
    (tmp_path / "seen.yaml").write_text(TEXT)
    run = ["run", "--study", str(tmp_path / "seen.yaml"), "--out", str(tmp_path / "out"), "--workers", "1"]
    assert cli.execute(run) == 0
    runs = pd.read_parquet(tmp_path / "out" / "latest" / "runs.parquet")
    assert set(runs["status"]) == {"ok"} and set(runs["scene"]) == {"hall"}
    assert (runs["backend"].value_counts() == 2).all() and runs["backend"].nunique() == 11
    assert (runs["landmarks_total"] == 4).all() and (runs["landmarks_mapped"] == 4).all()
    believed = [np.zeros(3)]
    for odometry, _ in toured.drive("hall", hall, 0).steps:
        x, y, heading = believed[-1]
        dx, dy, turn = odometry.delta
        c, s = np.cos(heading), np.sin(heading)
        believed.append(np.array([x + c * dx - s * dy, y + s * dx + c * dy, heading + turn]))
    truth = toured.drive("hall", hall, 0).truth
    reckoned = np.sqrt((np.hypot(*(np.array(believed[1:]) - truth)[:, :2].T) ** 2).mean())
    assert (runs.loc[runs["seed"] == 0, "rmse_m"] < reckoned).all()


def test_a_study_with_a_rendered_drive_is_read_and_written_alike():
    study = parse(TEXT, "seen.yaml")
    assert parse(dump(study), "again") == study and not study.reads_data()


@pytest.mark.parametrize(
    ("change", "expected"),
    [(("small-hall", "small-hole"), "small-hall"), (("{name: sun, sun: 0.5}", "{name: dark}"), "above 0")],
)
def test_wrong_drives_are_one_line(tmp_path, capsys, change, expected):
    (tmp_path / "seen.yaml").write_text(TEXT.replace(*change))
    assert cli.execute(["run", "--study", str(tmp_path / "seen.yaml"), "--out", str(tmp_path / "r")]) == 2
    error = capsys.readouterr().err.splitlines()
    assert len(error) == 1 and expected in error[0]
