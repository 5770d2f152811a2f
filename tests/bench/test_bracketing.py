"""Exposure bracketing: each picture once for each number of stops, from the study to data set and report."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from bench.camera_choice import CameraChoice
from bench.data import cache_folder
from bench.datasets import PictureSet
from bench.datasets.verify import verify
from bench.errors import BenchError
from bench.generate import generate, resume
from bench.illumination_grid import IlluminationGrid
from bench.kinds.rendered import RenderedStudy
from bench.options import GenerateOptions
from bench.perception import Perception
from bench.progress import Silent
from bench.sensor_choice import SensorChoice
from bench.sequences.lighting import light_colours
from bench.sequences.rendered import RenderedSequence, SequenceSetup
from bench.study import parse

STOPS = (-2.0, 0.0, 1.5)
LIGHTS = ("sun20000-bulb200-ev-2", "sun20000-bulb200", "sun20000-bulb200-ev1.5")
LAYOUTS = ("tum", "euroc", "coco", "exr", "raw")

pytestmark = pytest.mark.usefixtures("cache_home")


@pytest.fixture(scope="module")
def study(short_study: RenderedStudy) -> RenderedStudy:
    """Metered, not set by hand; the scene, and so its baked light, is that of other tests."""
    light = {"sun_lux": [20_000], "bulb_lm": [200], "exposure_ev": STOPS}
    return short_study.model_copy(
        update={
            "camera": CameraChoice(width=32, height=24),
            "sensor": SensorChoice.model_validate({}),
            "illuminations": IlluminationGrid.model_validate(light),
        }
    )


@pytest.fixture(scope="module")
def bracket(study: RenderedStudy, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set of two frames in three exposures; tests read it only."""
    out = tmp_path_factory.mktemp("bracket") / "set"
    generate(study, GenerateOptions(out, frames=2, layouts=LAYOUTS), Silent())
    return out


def _content(root: Path) -> dict[str, bytes]:
    return {str(p.relative_to(root)): p.read_bytes() for p in root.rglob("*") if p.is_file()}


def _table(root: Path) -> list[dict[str, str]]:
    with (root / "frames.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_exposure_times_are_in_stops_of_two_at_one_gain(bracket):
    rows = {(row["illumination"], int(row["frame"])): row for row in _table(bracket)}
    assert len(rows) == len(STOPS) * 2
    for frame in range(2):
        metered = float(rows[LIGHTS[1], frame]["exposure_s"])
        for light, ev in zip(LIGHTS, STOPS, strict=True):
            row = rows[light, frame]
            assert float(row["exposure_ev"]) == ev
            assert float(row["exposure_s"]) == pytest.approx(metered * 2**ev, rel=1e-12)
            assert row["gain_db"] == rows[LIGHTS[1], frame]["gain_db"]


def test_every_exposure_is_a_sequence_of_its_own_in_every_layout(bracket):
    for layout in LAYOUTS:
        assert {p.name for p in (bracket / layout / "corridor").iterdir()} == set(LIGHTS)
    told = json.loads((bracket / "dataset.json").read_text())
    assert [s["illumination"]["exposure_ev"] for s in told["sequences"]] == list(STOPS)
    assert verify(bracket, Silent()).problems == ()
    import mlcroissant

    records = list(mlcroissant.Dataset(str(bracket / "croissant.json")).records("pictures"))
    assert [r["pictures/exposure_ev"] for r in records] == [ev for ev in STOPS for _ in range(2)]


def test_the_ground_truth_is_exposed_alike(bracket):
    """Linear light at the sensor grows with the time; where it clips in the longer exposure, it is at 1."""
    pictures = {p["sequence"].split("/")[1]: p for p in PictureSet(bracket, "tum") if p["frame"] == 1}
    dark, metered, bright = (pictures[light] for light in LIGHTS)
    for part in ("diffuse", "specular"):
        unclipped = metered[part] < 0.999
        np.testing.assert_allclose(dark[part][unclipped], metered[part][unclipped] / 4, atol=1e-4)
        expected = np.minimum(metered[part] * 2**1.5, 1.0)
        np.testing.assert_allclose(bright[part][unclipped], expected[unclipped], atol=1e-3)
    lit = [pictures[light]["mask"].sum() for light in LIGHTS]
    assert lit[0] < lit[1]  # fewer highlights stand out of the darker picture
    np.testing.assert_array_equal(dark["depth"], bright["depth"])


def test_what_is_metered_is_the_picture_without_a_bracket(bracket, study, tmp_path):
    alone = study.illuminations.model_copy(update={"exposure_ev": (0.0,)})
    plain = study.model_copy(update={"illuminations": alone})
    generate(plain, GenerateOptions(tmp_path / "set", frames=2, layouts=LAYOUTS), Silent())
    for path in (tmp_path / "set").rglob("0*.*"):
        assert path.read_bytes() == (bracket / path.relative_to(tmp_path / "set")).read_bytes()


def test_one_exposure_is_made_again_by_resume(bracket, study, tmp_path):
    out = tmp_path / "set"
    generate(study, GenerateOptions(out, frames=2, layouts=LAYOUTS), Silent())
    (out / f"raw/corridor/{LIGHTS[2]}").rename(tmp_path / "gone")
    assert any(LIGHTS[2] in problem for problem in verify(out, Silent()).problems)
    resume(out, 1, Silent())
    assert _content(out) == _content(bracket)


def test_a_run_scores_every_exposure(study):
    setup = SequenceSetup(study, "raycast", light_colours(study), 1, cache_folder())
    sequence = RenderedSequence(setup)
    percepts = Perception(sequence, "raycast").frame(0)
    sequence.renderer.close()
    labels = {(row["illumination"], row["exposure_ev"]) for row in percepts.rows}
    assert labels == set(zip(LIGHTS, STOPS, strict=True))
    assert {light for light, _ in percepts.percepts} == set(LIGHTS)  # each is mapped with by itself


HEAD = "sequence: rendered\nname: mine\n"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("exposure_ev: []", "exposure_ev: should hold at least one entry"),
        ("exposure_ev: [0, 0]", "exposure_ev: 0 EV stands twice"),
        ("exposure_ev: [-0.0, 0]", "exposure_ev: 0 EV stands twice"),
        ("exposure_ev: [.nan]", "exposure_ev.0: should be a finite number"),
        ("exposure_ev: [30]", "exposure_ev.0: should be less than or equal to 20, not 30"),
        ("exposure_ev: [0, 2], lamps: [all, {name: ev2, broken: 0.5}]", "'ev2' reads as an exposure"),
    ],
)
def test_refused(text, expected):
    with pytest.raises(BenchError, match=expected) as error:
        parse(f"{HEAD}illuminations: {{{text}}}\n", "mine.yaml")
    assert "\n" not in str(error.value)
