"""A study of back-ends from its file to its report."""

import numpy as np
import pandas as pd
import pytest

from bench import cli
from bench.drive_choice import LoopDrive, VirtualDrive
from bench.errors import BenchError
from bench.kinds.backends import BackendsStudy
from bench.options import RunOptions
from bench.progress import Silent
from bench.runner import run
from bench.schema import RUN_COLUMNS
from bench.store import read
from bench.study import dump, load, parse
from reports import html
from vslam.errors import VslamError

TEXT = """
sequence: backends
name: small
seeds: 2
drives:
  - {source: loop, length_m: 6, width_m: 5, laps: 1, landmarks: 10}
backends: [ekf, {name: fastslam2, label: rbpf, parameters: {particles: 8}}, graph]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("results")
    return run(parse(TEXT, "small.yaml"), RunOptions(out=out), Silent(), report=html.build)


def test_rows_of_every_back_end_and_repetition(folder):
    runs = read(folder).runs
    assert list(runs.columns) == list(RUN_COLUMNS)
    assert runs["backend"].value_counts().to_dict() == dict.fromkeys(
        ["ekf", "rbpf", "graph", "graph_smoothed"], 2
    )
    assert set(runs["status"]) == {"ok"} and set(runs["scene"]) == {"loop"}
    for key in ("rmse_m", "rmse_aligned_m", "rpe_m", "rpe_deg", "landmark_rmse_m"):
        assert (runs[key] >= 0).all()
    online = runs[runs["backend"] != "graph_smoothed"]
    for key in ("nees", "bound_m", "step_ms", "memory_mb"):
        assert (online[key] > 0).all()
    assert runs.loc[runs["backend"] == "graph_smoothed", ["nees", "bound_m"]].isna().all(axis=None)
    assert (folder / "trajectories" / "truth--loop.tum").is_file()


def test_the_page_and_the_terminal_show_them(folder, capsys):
    page = (folder / "report.html").read_text()
    for text in ("graph_smoothed", "Cramér–Rao bound", "band of the NEES for 2"):
        assert text in page
    table = pd.read_csv(folder / "figures" / "backends--loop.csv")
    assert "rbpf" in set(table["back-end"])
    assert "dissertation, proposed" not in page, "only beside the dissertation's sensor"
    assert cli.execute(["report", str(folder)]) == 0
    out = capsys.readouterr().out
    assert "graph_smoothed" in out and "Cramér–Rao bound" in out


def test_the_same_seed_the_same_numbers_for_any_workers(folder, tmp_path):
    again = run(parse(TEXT, "small.yaml"), RunOptions(out=tmp_path, workers=2), Silent())
    one, other = read(folder).runs, read(again).runs
    pd.testing.assert_frame_equal(one.drop(columns="step_ms"), other.drop(columns="step_ms"))


@pytest.mark.parametrize("name", ["backends", "dissertation"])
def test_packaged_studies_compare_the_literature(name):
    study = load(name)
    assert isinstance(study, BackendsStudy)
    assert {b.name for b in study.backends} >= {
        *("ekf", "ekf_fej", "riekf", "ukf", "ckf", "srckf", "information", "fastslam1", "fastslam2", "graph")
    }
    assert parse(dump(study), "x") == study
    simulated = [d for d in study.drives if isinstance(d, LoopDrive | VirtualDrive)]
    assert simulated and all(d.odometry.protocol == "measured" for d in simulated)
    study.check()


def test_the_dissertations_sensor_is_stated():
    (drive,) = load("dissertation").drives
    sensor = drive.sensor
    assert (sensor.range_m, sensor.half_angle_deg, sensor.detection, drive.speed_mps) == (12, 75, 0.6, 0.93)
    assert 0.05 <= drive.odometry.sigma_heading_deg <= 0.1
    assert load("dissertation").seeds == 10


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("source: loop", "source: lap", "drives.0"),
        ("laps: 1", "lap: 1", "drives.0.loop.lap: unknown key: did you mean 'laps'"),
        ("laps: 1", "sensor: {range: 3}", "sensor.range: unknown key: did you mean 'range_m'"),
        ("laps: 1", "odometry: {protocol: truth}", "protocol"),
        ("backends: [ekf,", "backends: [rbpf, {name: ekf, label: rbpf},", "the label 'rbpf' stands twice"),
    ],
)
def test_wrong_keys_are_one_line(old, new, message):
    assert old in TEXT
    with pytest.raises(BenchError, match=message) as caught:
        parse(TEXT.replace(old, new), "small.yaml")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[ekf,", "[efk,", "did you mean 'ekf'"),
        ("particles: 8", "particle: 8", "back-end 'fastslam2': .*particle"),
    ],
)
def test_wrong_back_ends_cost_no_run(old, new, message):
    with pytest.raises(VslamError, match=message):
        parse(TEXT.replace(old, new), "small.yaml").check()


def test_a_run_that_breaks_down_is_a_row(tmp_path, monkeypatch):
    """An odometry that overflows in one repetition."""
    from bench.sequences import simulated

    true = simulated.true_increment

    def far(start, end):
        return true(start, end) * np.where(np.arange(3) == 0, 1e200, 1.0)

    monkeypatch.setattr(simulated, "true_increment", far)
    with np.errstate(all="ignore"):
        text = TEXT.replace("seeds: 2", "seeds: 1").replace("graph]", "ekf_fej]")
        runs = read(run(parse(text, "x"), RunOptions(out=tmp_path), Silent(), report=html.build)).runs
    assert runs["status"].str.startswith("failed: SLAM step").all()
    assert runs["rmse_m"].isna().all()
