"""A study of several scenes through the whole chain: what it asks of each, and a tiny one to its report."""

import numpy as np
import pandas as pd
import pytest

from bench import cli
from bench.another_place import in_scenes
from bench.kinds.downstream import DownstreamStudy
from bench.light_levels import in_scene
from bench.study import dump, load, parse

pytestmark = pytest.mark.usefixtures("small_halls")

TINY = """
sequence: downstream
name: tiny
scenes: [small-hall, far-hall]
levels:
  - {name: lamps, lamps: 1}
  - {name: strong, sun: 2, lamps: 4}
engine: raycast
tour: {frame_interval_s: 2.5}
sensor: {max_exposure_s: 0.008}
odometry: {sigma_heading_rad_per_m: 0.05}
filters: [seed]
seeds: 2
navigation: {pairs: 4}
"""


@pytest.fixture(scope="module")
def tiny_run(tmp_path_factory, cache_home):
    """The folder of the tiny study's run."""
    folder = tmp_path_factory.mktemp("tiny")
    (folder / "tiny.yaml").write_text(TINY)
    run = ["run", "--study", str(folder / "tiny.yaml"), "--out", str(folder / "results"), "--workers", "1"]
    assert cli.execute(run) == 0
    return folder / "results" / "latest"


def test_a_scene_is_asked_all_that_the_study_says():
    study = parse(TINY, "tiny")
    there = in_scene(study, study.scenes[1])
    assert (there.scene.name, there.scene.split) == ("far-hall", "test")
    for key in ("tour", "odometry", "depth", "slam", "seeds", "navigation", "camera", "sensor", "filters"):
        assert getattr(there, key) == getattr(study, key), key
    assert [cell.name for cell in there.illuminations.grid()] == ["lamps", "strong"]


def test_every_scene_is_toured_under_every_light_with_every_filter(tiny_run):
    runs = pd.read_parquet(tiny_run / "runs.parquet")
    combinations = runs.groupby(["scene", "illumination", "filter"])["seed"].agg(list)
    assert len(combinations) == 2 * 2 * 2 and all(seeds == [0, 1] for seeds in combinations)
    assert runs.groupby("scene")["landmarks_total"].first().to_dict() == {"small-hall": 4, "far-hall": 3}
    for scene in ("small-hall", "far-hall"):
        assert (tiny_run / "trajectories" / f"truth--{scene}.tum").exists()


def rows_of(text, caption):
    """Cells of a Markdown table by group and label, each group's name standing in its first row alone."""
    found, group = {}, ""
    for line in text.split(f"## {caption}")[1].split("\n\n")[1].splitlines()[2:]:
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        group = cells[0] or group
        found[group, cells[1]] = [float(c.split()[0].strip("▲▼").replace("–", "nan")) for c in cells[2:6]]
    return found


def test_the_table_in_markdown_is_what_the_stored_rows_say(tiny_run):
    """Against sums over the stored tables: recall, precision, RMSE and plans of each scene, light, filter."""
    text = (tiny_run / "tables.md").read_text()
    frames, runs = (pd.read_parquet(tiny_run / f"{name}.parquet") for name in ("frames", "runs"))
    told = rows_of(text, "Each scene under each light")
    assert len(told) == 8
    for (scene, light, name), rows in frames.groupby(["scene", "illumination", "filter"]):
        own = runs[(runs["scene"] == scene) & (runs["illumination"] == light) & (runs["filter"] == name)]
        hits = rows["detections_true"].sum()
        assert hits > 0 or name != "none"
        expected = [
            100 * hits / rows["landmarks_visible"].sum(),
            100 * hits / (rows["landmarks_detected"].sum() or np.nan),
            own["rmse_m"].mean(),
            100 * own["nav_success"].mean(),
        ]
        label = "do nothing" if name == "none" else name
        assert told[f"{scene}, {light}", label] == pytest.approx(expected, abs=0.051, nan_ok=True), (
            scene,
            light,
            name,
        )
    together = rows_of(text, "All scenes together")
    untouched = frames[frames["filter"] == "none"]
    recall = 100 * untouched["detections_true"].sum() / untouched["landmarks_visible"].sum()
    assert together["all scenes and lights", "do nothing"][0] == pytest.approx(recall, abs=0.051)


def test_the_packaged_study_is_of_the_test_split_and_can_be_moved():
    study = load("downstream")
    assert isinstance(study, DownstreamStudy) and study.split == "test" and len(study.scenes) == 5
    assert parse(dump(study), "again") == study
    moved = in_scenes(study, "office", "validation")
    assert [s.name for s in moved.scenes] == ["office"] and moved.split == "validation"


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (("far-hall", "fair-hall"), "far-hall"),
        (("[seed]", "[seeed]"), "seed"),
        (("seeds: 2", "seeds: 0"), "seeds"),
    ],
)
def test_wrong_studies_are_one_line(tmp_path, capsys, change, expected):
    (tmp_path / "tiny.yaml").write_text(TINY.replace(*change))
    assert cli.execute(["run", "--study", str(tmp_path / "tiny.yaml"), "--out", str(tmp_path / "r")]) == 2
    error = capsys.readouterr().err.splitlines()
    assert len(error) == 1 and error[0].startswith("error: ") and expected in error[0]
    assert not (tmp_path / "r").exists()
