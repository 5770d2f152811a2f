"""The main job end to end, for real and in little: what a run leaves, that it repeats, what light does."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from bench import cli, provenance, runner
from bench.commands.run import FINISHED_WITH_FAILURES
from bench.kinds.rendered import RenderedStudy
from bench.options import RunOptions
from bench.perception import make_filter
from bench.progress import Silent
from bench.schema import FRAME_COLUMNS, RUN_COLUMNS
from bench.sequences.lighting import light_colours, load_scene
from bench.sequences.rendered import (
    RenderedSequence,
    SequenceSetup,
    calibration,
    odometry,
)
from bench.store import read
from reports import html, terminal
from vslam import pipeline
from vslam.detect import DiscDetector
from vslam.errors import VslamError
from vslam.frame import Frame
from vslam.occupancy import OccupancyGrid
from vslam.slam import Slam, SlamSettings

pytestmark = pytest.mark.usefixtures("cache_home")


@pytest.fixture(scope="module")
def run_dir(short_study: RenderedStudy, cache_home: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return runner.run(short_study, RunOptions(out=tmp_path_factory.mktemp("one")), Silent())


def test_a_run_leaves_what_the_contract_says(run_dir: Path, short_study: RenderedStudy) -> None:
    stored = read(run_dir)
    frames = len(load_scene(short_study).tour.stamps)
    assert frames == 7
    assert list(stored.frames.columns) == list(FRAME_COLUMNS)
    assert list(stored.runs.columns) == list(RUN_COLUMNS)
    assert len(stored.frames) == frames * 4 * 2  # illuminations × filters
    assert len(stored.runs) == 4 * 2 * 2  # illuminations × filters × seeds
    assert set(stored.runs["status"]) == {"ok"}
    assert set(stored.frames["engine"]) == {"raycast"}
    assert RenderedStudy.model_validate(yaml.safe_load(stored.study)) == short_study
    facts = json.loads((run_dir / "provenance.json").read_text())
    assert facts["engine"] == "raycast" and facts["seed"] == 3
    assert set(facts["seconds"]) == {"bake", "perceive", "localise", "pictures"}
    assert facts["git"] == provenance.commit()
    assert (run_dir.parent / "latest").resolve() == run_dir.resolve()
    assert len(list((run_dir / "trajectories").glob("corridor--*.tum"))) == 16
    assert not [p for p in run_dir.parent.iterdir() if ".partial" in p.name]


def test_the_report_can_be_built_from_what_a_run_left(run_dir: Path) -> None:
    page = html.build(run_dir).read_text()
    assert "corridor" in page and "seed" in page
    assert terminal.summary(run_dir) is not None


def test_the_same_study_gives_the_same_bytes_for_any_number_of_workers(
    run_dir: Path, short_study: RenderedStudy, tmp_path: Path
) -> None:
    again = runner.run(short_study, RunOptions(out=tmp_path, workers=2), Silent())
    assert (again / "runs.parquet").read_bytes() == (run_dir / "runs.parquet").read_bytes()
    for track in (run_dir / "trajectories").iterdir():
        assert (again / "trajectories" / track.name).read_bytes() == track.read_bytes()
    first, second = (read(d).frames.drop(columns="filter_ms") for d in (run_dir, again))
    pd.testing.assert_frame_equal(first, second, check_exact=True)  # all but the measured time
    for picture in (run_dir / "figures" / "strips").iterdir():
        assert (again / "figures" / "strips" / picture.name).read_bytes() == picture.read_bytes()


def test_more_light_is_more_highlight(run_dir: Path) -> None:
    """With a fixed exposure every lux adds specular light to the picture, until it clips."""
    share = read(run_dir).frames.query("filter == 'none'").groupby("illumination")["true_share"].mean()
    assert share["sun0-bulb200"] < share["sun0-bulb800"] < share["sun20000-bulb800"]
    assert share["sun0-bulb200"] < share["sun20000-bulb200"]


def test_doing_nothing_masks_nothing_and_finds_what_is_there(run_dir: Path) -> None:
    rows = read(run_dir).frames.query("filter == 'none'")
    assert (rows["masked_share"] == 0).all() and (rows["iou"].dropna() == 0).all()
    assert rows["detections_true"].sum() > 0.4 * rows["landmarks_visible"].sum()
    assert (rows["detections_true"] <= rows["landmarks_detected"]).all()


def test_the_estimated_track_stays_near_the_true_one(run_dir: Path) -> None:
    """3.3 m of way with 2.3 % odometry noise and landmarks: centimetres, not decimetres."""
    runs = read(run_dir).runs
    assert (runs["rmse_m"] < 0.1).all() and (runs["rmse_m"] > 0).all()


def test_the_five_phase_pipeline_is_what_the_run_did(
    run_dir: Path, short_study: RenderedStudy, cache_home: Path
) -> None:
    scene = load_scene(short_study)
    setup = SequenceSetup(short_study, "raycast", light_colours(short_study), 0, cache_home / "glarebench")
    sequence = RenderedSequence(setup)
    illumination = short_study.illuminations.grid()[-1]
    bases = [sequence.basis(k) for k in range(len(sequence))]
    frames = [
        Frame(k, t, sequence.record(b, illumination, k).image, sequence.measured_depth(b, k), u)
        for k, (t, b, u) in enumerate(
            zip(scene.tour.stamps, bases, odometry(short_study, scene.tour.poses, 1), strict=True)
        )
    ]
    view = calibration(short_study)
    grid = OccupancyGrid.empty(scene.bounds, 0.1)
    outcome = pipeline.run(
        frames,
        make_filter(short_study.filters[1]),
        DiscDetector(view),
        Slam(SlamSettings()),
        view,
        grid,
        goal_xy=scene.tour.poses[3, :2],
        start_pose=scene.tour.poses[0],
    )
    stem = f"corridor--{illumination.name}--seed--ekf--icnn--range_bearing--s1"
    stored = np.loadtxt(run_dir / "trajectories" / f"{stem}.tum")
    np.testing.assert_allclose(outcome.poses[:, :2], stored[:, 1:3], atol=1e-8)
    assert grid.free.sum() > 200  # 2 m² of floor at least


PLUGIN = """
import numpy as np
from vslam.filters import Filtered

class Flaky:
    '''Fails on bright pictures.'''
    def __call__(self, image):
        if image.mean() > 60:
            raise RuntimeError("too bright for me")
        return Filtered(image, np.zeros(image.shape[:2], bool), np.zeros(image.shape[:2], np.float32))

class Scribbler:
    '''Writes on the picture.'''
    def __call__(self, image):
        image[0] = 0
"""


def test_a_run_goes_on_where_a_filter_fails_and_says_so(
    short_study: RenderedStudy,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Through the command line and in worker processes, with plug-ins of the working directory."""
    few = {"seeds": 1, "scene": {"parameters": {"laps": 0.02}}}
    dark_and_bright = {"illuminations": {"sun_lux": [0, 20_000], "bulb_lm": [200]}}
    (tmp_path / "flaky_plugin.py").write_text(PLUGIN)
    (tmp_path / "s.yaml").write_text(
        yaml.safe_dump(short_study.model_dump(mode="json") | few | dark_and_bright)
    )
    monkeypatch.chdir(tmp_path)
    options = ["--filter", "flaky_plugin:Flaky", "--filter", "flaky_plugin:Scribbler", "--workers", "2"]
    assert cli.execute(["run", "--study", "s.yaml", *options]) == FINISHED_WITH_FAILURES
    stored = read(tmp_path / "results" / "latest")
    frames, runs = stored.frames.set_index("filter"), stored.runs.set_index("filter")
    assert set(frames.loc["none", "status"]) == {"ok"}
    assert set(frames.loc["flaky", "status"]) == {"ok", "failed: RuntimeError: too bright for me"}
    reason = "failed: ValueError: assignment destination is read-only"
    assert set(frames.loc["scribbler", "status"]) == {reason}
    failed = stored.frames[stored.frames["status"] != "ok"]
    assert failed[["iou", "psnr_db", "filter_ms"]].isna().all(axis=None)
    assert (failed["detections_true"] == 0).all() and failed["true_share"].notna().all()
    assert set(runs.loc["none", "status"]) == {"ok"}
    assert set(runs.loc["scribbler", "status"]) == {
        reason.replace(":", ": the filter failed on every picture:", 1)
    }
    text = " ".join(capsys.readouterr().out.split())
    assert f"failed: scribbler: {len(frames.loc['scribbler'])} pictures: ValueError" in text
    assert "failed: flaky: " in text and "“scribbler” failed on every picture" in text
    assert "What failed" in (tmp_path / "results" / "latest" / "report.html").read_text()


def test_a_run_that_fails_leaves_nothing_behind(short_study: RenderedStudy, tmp_path: Path) -> None:
    choices = [{"name": "none"}, {"name": "seed", "parameters": {"patch": 4}}]  # a patch without a centre
    broken = RenderedStudy.model_validate(short_study.model_dump() | {"filters": choices})
    with pytest.raises(VslamError, match="patch"):
        runner.run(broken, RunOptions(out=tmp_path), Silent())
    assert list(tmp_path.iterdir()) == []


def test_a_report_that_fails_leaves_no_run_behind(short_study: RenderedStudy, tmp_path: Path) -> None:
    def interrupted(folder: Path) -> None:
        assert (folder / "runs.parquet").is_file()
        raise KeyboardInterrupt

    log_free = RenderedStudy.model_validate(
        short_study.model_dump() | {"seeds": 1, "filters": ["none"], "scene": {"parameters": {"laps": 0.01}}}
    )
    with pytest.raises(KeyboardInterrupt):
        runner.run(log_free, RunOptions(out=tmp_path), Silent(), report=interrupted)
    assert list(tmp_path.iterdir()) == []


def test_under_automatic_exposure_brighter_bulbs_alone_still_mean_more_highlight(
    short_study: RenderedStudy, cache_home: Path
) -> None:
    """At night the short shutter leaves dim bulbs dark, so they raise fewer pixels above τ."""
    study = RenderedStudy.model_validate(
        short_study.model_dump()
        | {
            "sensor": {"exposure": "auto", "max_exposure_s": 0.008},
            "illuminations": {"sun_lux": [0], "bulb_lm": [100, 400, 1600]},
        }
    )
    setup = SequenceSetup(study, "raycast", light_colours(study), 0, cache_home / "glarebench")
    sequence = RenderedSequence(setup)
    basis = sequence.basis(0)
    shares = [sequence.record(basis, i, 0).highlight.mean() for i in study.illuminations.grid()]
    assert shares[0] < shares[1] < shares[2]
