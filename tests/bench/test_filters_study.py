"""A study of filters: its levels of light, and a tiny one from the study file to the report."""

import numpy as np
import pandas as pd
import pytest

from bench import cli
from bench.another_place import in_scenes
from bench.filters_run import chosen, frames_of
from bench.kinds.filters import FiltersStudy
from bench.light_levels import at_level, in_scene
from bench.scenes_study import LightLevel
from bench.sequences.lighting import as_built
from bench.study import dump, load, parse
from scenes import library
from scenes.splits import seed_of

TINY = """
sequence: filters
name: tiny
scenes:
  - name: small-hall
levels:
  - {name: lamps, lamps: 1}
  - {name: strong, sun: 2, lamps: 4}
frames: 1
camera: {width: 160, height: 120}
engine: raycast
neutral_objects: [white box]
sensor: {exposure: 0.002}
filters: [seed]
timed_sizes: [[40, 30]]
"""


pytestmark = pytest.mark.usefixtures("small_halls")


@pytest.mark.parametrize("name", ["corridor", "warehouse"])
def test_a_level_is_in_proportion_to_the_scenes_own_light(name):
    scene = library.load(name)
    level = at_level(LightLevel(name="strong", sun=2.0, lamps=4.0), scene)
    assert level.sun_lux == 2 * scene.suns[0].lux and level.sky_lux == 2 * scene.sky.lux
    assert level.bulb_lm == 4 * np.median([bulb.lumen for bulb in scene.bulbs])
    night = at_level(LightLevel(name="night", lamps=0.25), scene)
    assert (night.sun_lux, night.sky_lux) == (0, 0) and night.bulb_lm == level.bulb_lm / 16


def test_scenes_are_those_of_the_split_unless_they_name_their_own():
    study = parse(TINY, "tiny")
    assert in_scene(study, study.scenes[0]).scene.split == "test"
    own = study.scenes[0].model_copy(update={"split": "train"})
    assert in_scene(study, own).scene.split == "train"
    validation = in_scenes(study, "office", "validation")
    assert [s.name for s in validation.scenes] == ["office"]
    there = in_scene(validation, validation.scenes[0])
    twin = library.load("office", seed=seed_of("validation", 0))
    np.testing.assert_array_equal(as_built(there).landmark_positions, twin.landmark_positions)
    assert [cell.name for cell in there.illuminations.grid()] == ["lamps", "strong"]


def test_frames_lie_evenly_inside_the_tour():
    assert frames_of(3, 6) == [0, 1, 2]
    assert frames_of(60, 6) == [5, 15, 25, 35, 45, 55]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (("{name: lamps, lamps: 1}", "{name: dark}"), "above 0"),
        (("{name: lamps, lamps: 1}", "{name: strong, lamps: 1}"), "stands twice"),
        (("[seed]", "[seeed]"), "seed"),
        (("name: small-hall", "name: tablet"), "tabletop"),
    ],
)
def test_wrong_studies_are_one_line(tmp_path, capsys, change, expected):
    (tmp_path / "tiny.yaml").write_text(TINY.replace(*change))
    assert cli.execute(["run", "--study", str(tmp_path / "tiny.yaml"), "--out", str(tmp_path / "r")]) == 2
    error = capsys.readouterr().err.splitlines()
    assert len(error) == 1 and error[0].startswith("error: ") and expected in error[0]
    assert not (tmp_path / "r").exists()


def test_the_packaged_study_compares_all_filters_on_the_test_split():
    from vslam.filters import registry

    study = load("filters")
    assert isinstance(study, FiltersStudy) and study.split == "test"
    assert {choice.name for choice in study.filters} == set(registry.names())
    assert {s.name for s in study.scenes} == {
        "corridor", "atrium", "office", "warehouse", "tabletop", "regular"
    }  # fmt: skip
    assert all(s.split is None for s in study.scenes)
    assert parse(dump(study), "again") == study


FAILING = """
import numpy as np
from vslam.filters.base import Filtered

class Wanting:
    '''Masks what is brighter than a third of white; fails where hardly anything is.'''
    name = "wanting"

    def __call__(self, image):
        mask = image.min(axis=2) > 85
        if mask.mean() < 0.02:
            raise ValueError("too dark")
        return Filtered(image.copy(), mask, mask.astype(np.float32))
"""


@pytest.fixture(scope="module")
def tiny_run(tmp_path_factory, cache_home):
    """A run with a filter out of the working directory; its folder and exit code."""
    folder = tmp_path_factory.mktemp("tiny")
    (folder / "plugged_wanting.py").write_text(FAILING)
    (folder / "tiny.yaml").write_text(TINY.replace("[seed]", "[seed, 'plugged_wanting:Wanting']"))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        code = cli.execute(["run", "--study", "tiny.yaml", "--out", "results", "--workers", "1"])
    return folder / "results" / "latest", code


def table(run, name):
    return pd.read_parquet(run / f"{name}.parquet").set_index(["illumination", "filter"]).sort_index()


def test_every_filter_is_scored_with_and_without_highlights(tiny_run):
    run, code = tiny_run
    lit, free = table(run, "frames"), table(run, "highlight_free")
    assert len(lit) == len(free) == 2 * 3
    assert (lit["true_share"] > 0).all() and (free["true_share"] == 0).all()
    pd.testing.assert_series_equal(lit["landmarks_visible"], free["landmarks_visible"])
    # nothing but the sensor's noise is left between picture and target without specular light
    untouched = free.xs("none", level="filter")["psnr_db"] - lit.xs("none", level="filter")["psnr_db"]
    assert (untouched > 1).all() and (free.xs("none", level="filter")["psnr_db"] > 35).all()
    assert (lit.xs("none", level="filter")["masked_share"] == 0).all()
    assert len(pd.read_parquet(run / "runs.parquet")) == 0
    failed = lit["status"].str.startswith("failed")
    assert code == (3 if failed.any() else 0)


def test_the_oracle_has_the_exact_mask_and_only_noise_outside(tiny_run):
    run, _ = tiny_run
    oracle = table(run, "oracle")
    assert (oracle[["iou", "f1", "ap"]] == 1).all(axis=None) and np.isinf(oracle["psnr_in_mask_db"]).all()
    lit = table(run, "frames").xs("none", level="filter")
    assert (oracle["psnr_db"].to_numpy() > lit["psnr_db"].to_numpy()).all()


def test_filters_are_timed_at_each_size(tiny_run):
    times = pd.read_parquet(tiny_run[0] / "times.parquet")
    assert list(zip(times["width"], times["height"], strict=True)) == [(40, 30)] * 3
    assert (times["filter_ms"][times["status"] == "ok"] > 0).all()


def test_white_and_grey_objects_are_scored_by_themselves(tiny_run):
    run, _ = tiny_run
    neutral, lit = table(run, "neutral"), table(run, "frames")
    untouched = neutral.xs("none", level="filter")
    assert (untouched["psnr_db"] > 20).all() and (untouched["masked_share"] == 0).all()
    assert (untouched["psnr_db"].to_numpy() != lit.xs("none", level="filter")["psnr_db"].to_numpy()).all()


def test_the_page_says_what_the_tables_hold(tiny_run):
    run, _ = tiny_run
    page = (run / "report.html").read_text()
    for heading in ("All filters", "Quality and time", "Do no harm", "By scene and light"):
        assert f"<h2>{heading}</h2>" in page
    stored = pd.read_csv(run / "figures" / "filters.csv").set_index(["filter", "measure"])["value"]
    lit, free = (_of_all(table(run, name)) for name in ("frames", "highlight_free"))
    assert stored["seed", "IoU"] == pytest.approx(lit.xs("seed", level="filter")["iou"].mean())
    error = (10 ** (-lit["psnr_db"] / 10)).groupby("filter").mean()
    change = -10 * np.log10(error["seed"] / error["none"])
    assert stored["seed", "frame PSNR change, dB"] == pytest.approx(change)
    masked = 100 * free.xs("seed", level="filter")["masked_share"].mean()
    assert stored["seed", "masked, % (highlight-free)"] == pytest.approx(masked)


def _of_all(rows):
    """Those of pictures that no filter failed on."""
    return rows[(rows["status"] == "ok").groupby("illumination").transform("all")]


def test_strips_show_the_picture_with_the_median_share():
    rows = [
        {"scene": s, "illumination": "lamps", "frame": 0, "filter": f, "true_share": t, "status": "ok"}
        for s, t in (("a", 0.0), ("b", 0.1), ("c", 0.2), ("d", 0.3))
        for f in ("none", "seed", "yang2010")
    ]
    rows[-4]["status"] = "failed: dark"  # yang2010 in scene c
    assert [(c.row["scene"], c.row["filter"]) for c in chosen(rows)] == [("c", "seed")]
    assert chosen([r for r in rows if r["scene"] == "a"]) == []
