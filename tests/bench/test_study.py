"""Study files: what they fill in, and what they refuse in one line."""

from importlib import import_module
from pathlib import Path
from typing import get_args

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench import camera_choice
from bench.camera_choice import CameraChoice, camera
from bench.errors import BenchError
from bench.kinds.dlr import DlrStudy
from bench.kinds.rendered import RenderedStudy
from bench.sequences.rendered import calibration
from bench.study import dump, load, names, parse
from bench.study_model import models
from reports.kind import kind_of

HEAD = "sequence: rendered\nname: mine\n"


def refusal(text: str) -> str:
    with pytest.raises(BenchError) as caught:
        parse(text, "mine.yaml")
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith("mine.yaml: ")
    return message.removeprefix("mine.yaml: ")


@pytest.mark.parametrize("name", names())
def test_packaged_studies_survive_a_round_trip(name):
    study = load(name)
    assert study.name == name
    assert study.title
    assert parse(dump(study), "again") == study


def test_the_grid_is_every_sun_with_every_bulb():
    study = parse(HEAD + "illuminations: {sun_lux: [0, 97000], bulb_lm: [12.5, 800]}", "x")
    assert isinstance(study, RenderedStudy)
    night, _, noon, bright = study.illuminations.grid()
    assert [night.name, noon.name, bright.name] == ["sun0-bulb12.5", "sun97000-bulb12.5", "sun97000-bulb800"]
    assert (bright.sun_lux, bright.bulb_lm) == (97000, 800)
    # ASTM G-173: 12 klx of sky beside 97 klx of sun; and no sky at night
    assert bright.sky_lux == pytest.approx(12_000, rel=0.01)
    assert night.sky_lux == 0


CALIBRATED = """camera:
  model: pinhole
  width: 768
  height: 288
  intrinsics: {fx: 470.1, fy: 257.2, cx: 382.4, cy: 144.2}
  distortion: [-0.25, 0.11, 0, 0]
"""


def test_a_camera_by_its_calibration():
    """Renderer and robot share the numbers; a study that is written out and read again is the same."""
    study = parse(HEAD + CALIBRATED, "x")
    assert parse(dump(study), "again") == study
    assert study.camera.fov_deg is None
    seen, known = camera(study.camera), calibration(study)
    pixels = np.array([[0.0, 0.0], [767.0, 287.0], [100.5, 200.25]])
    np.testing.assert_allclose(seen.unproject(pixels), known.unproject(pixels), atol=1e-12)


def test_quick_sweeps_sun_and_bulbs():
    study = load("quick")
    assert isinstance(study, RenderedStudy)
    assert len(study.illuminations.sun_lux) >= 2
    assert len(study.illuminations.bulb_lm) >= 2


def test_dlr_replays_every_association_and_both_forms():
    study = load("dlr")
    assert isinstance(study, DlrStudy)
    assert study.associations == ("annotated", "icnn", "jcbb", "constellation")
    assert study.observations == ("cartesian", "range_bearing")


def test_a_file_is_loaded_by_path(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(HEAD)
    assert load(file) == load(str(file)) == parse(HEAD, "mine.yaml")


def test_dump_fills_in_every_default():
    text = dump(parse(HEAD, "mine.yaml"))
    for key in (
        "full_well_e: 20000.0",
        "sky_per_sun: 0.124",
        "gate: 0.99",
        "robot_radius_m: 0.25",
        "seeds: 10",
    ):
        assert key in text


def test_doing_nothing_always_comes_first_and_once():
    study = parse(HEAD + "filters: [seed, {name: seed, label: other, parameters: {patch: 1}}, none]", "x")
    assert [choice.label for choice in study.filters] == ["none", "seed", "other"]
    assert [choice.name for choice in study.filters] == ["none", "seed", "seed"]
    assert [choice.name for choice in parse(HEAD, "x").filters] == ["none"]


def test_studies_are_immutable():
    with pytest.raises(ValueError, match="frozen"):
        load("quick").seed = 3


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("scene: {nmae: corridor}", "scene.nmae: unknown key: did you mean 'name'?"),
        ("sede: 1", "sede: unknown key: did you mean 'seed'"),
        (
            "filters: [{name: seed, parmeters: {}}]",
            "filters.0.parmeters: unknown key: did you mean 'parameters'?",
        ),
        ("slam: {zzz: 1}", "slam.zzz: unknown key: known: backend, association, observation, gate"),
        ("seeds: many", "seeds: should be a whole number, not 'many'"),
        ("seeds: 0", "seeds: should be greater than or equal to 1, not 0"),
        ("camera: {model: fish}", "camera.model: should be 'fisheye' or 'pinhole', not 'fish'"),
        (
            "camera: {model: pinhole, fov_deg: 180}",
            "camera: 180.0° across: the field of view of a pinhole must lie above 0° and below 180°",
        ),
        ("camera: {fov_deg: 0}", "camera.fov_deg: should be greater than 0, not 0"),
        ("camera: {fov_deg: .nan}", "camera.fov_deg: should be a finite number, not nan"),
        ("camera: {width: -320}", "camera.width: should be greater than or equal to 16, not -320"),
        (
            "camera: {distortion: [0.1]}",
            "camera: distortion of a fisheye is 0 or 4 finite numbers in OpenCV's",
        ),
        ("camera: {distortion: [.nan, 0, 0, 0]}", "camera.distortion.0: should be a finite number, not nan"),
        ("camera: {distortion: 3}", "camera.distortion: should be a list, not 3"),
        (
            "camera: {model: pinhole, fov_deg: 90, distortion: [-0.3, 0, 0, 0]}",
            "camera: camera 320 × 240: no direction has its image at (-0.5, -0.5), as this pinhole's "
            "distortion [-0.3, 0.0, 0.0, 0.0] folds inside the picture",
        ),
        ("camera: {fov_deg: 90, intrinsics: {fx: 9, fy: 9, cx: 9, cy: 9}}", "camera: give either fov_deg or"),
        (
            "camera: {intrinsics: {fx: 0, fy: 9, cx: 9, cy: 9}}",
            "camera.intrinsics.fx: should be greater than 0",
        ),
        ("camera: {intrinsics: {fx: 9, fy: 9, cx: 9}}", "camera.intrinsics.cy: is missing"),
        ("camera: fisheye", "camera: should be a mapping of keys and values, not 'fisheye'"),
        ("sensor: {exposure: fast}", "sensor.exposure: should be 'auto' or a number, not 'fast'"),
        ("sensor: {exposure: -1}", "sensor.exposure: should be 'auto' or greater than 0, not -1"),
        ("sensor: {full_well_e: .inf}", "sensor.full_well_e: should be a finite number, not inf"),
        ("sensor: {min_exposure_s: 2}", "sensor: min_exposure_s 2 exceeds max_exposure_s 0.033"),
        ("illuminations: {sun_lux: 5}", "illuminations.sun_lux: should be a list, not 5"),
        ("illuminations: {bulb_lm: []}", "illuminations.bulb_lm: "),
        ("illuminations: {bulb_lm: [8, 8]}", "illuminations: bulb_lm: 8 lm stands twice; each value may"),
        ("filters: [{name: seed, parameters: {patch: []}}]", "filters: seed: the list of patch is empty"),
        ("filters: [My Filter]", "filters.0.name: 'My Filter' should be a name of small letters"),
        ("filters: [seed, seed]", "filters: the label 'seed' stands twice"),
        ("navigation: {pairs: 1.5}", "navigation.pairs: should be a whole number, not 1.5"),
        ("name: again", "not valid YAML: line 3, column 1: the key 'name' stands twice"),
        ("title: [", "not valid YAML: line 3, column "),
        ("title: !!python/name:os.system x", "not valid YAML: line 3, column 8: could not determine"),
        ("? [a]\n: b", "not valid YAML: line 3, column 3: the key here is not plain text"),
    ],
)
def test_what_is_wrong_is_named_with_what_is_allowed(body, expected):
    assert refusal(HEAD + body).startswith(expected)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "must hold keys and values"),
        ("- a\n- b", "must hold keys and values"),
        ("name: mine", "sequence: is missing; allowed: backends or dlr or"),
        (
            "sequenz: rendered",
            "sequence: is missing (instead of 'sequenz'?); allowed: backends or dlr or",
        ),
        ("sequence: filmed", "sequence: 'filmed' is not known; allowed: backends or dlr or"),
        ("sequence: rendered", "name: is missing"),
        ("sequence: rendered\nname: Two Words", "name: should be a name of small letters, digits, - and _"),
        ("sequence: dlr\nname: d\nscene: {name: corridor}", "scene: unknown key: "),
    ],
)
def test_a_study_must_say_what_it_is(text, expected):
    assert refusal(text).startswith(expected)


def test_further_errors_are_counted():
    assert refusal(HEAD + "seeds: 0\nseed: -1\nbogus: 1").endswith("(and 2 more)")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("quik", "unknown study 'quik': did you mean 'quick'?"),
        ("zzz", "unknown study 'zzz': known: "),
        ("nowhere.yaml", "study file nowhere.yaml: not found; packaged studies are "),
        ("./", "study file .: cannot be read: "),
    ],
)
def test_a_study_that_is_not_there(name, expected):
    with pytest.raises(BenchError) as caught:
        load(name)
    assert str(caught.value).startswith(expected)


def test_a_file_that_is_no_text(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(BenchError, match="cannot be read"):
        load(Path(file))


@given(
    st.text(max_size=60)
    | st.sampled_from([HEAD + key for key in ("a: *b", "<<: 3", "3: 4", "scene: {3: 4}")])
)
def test_no_text_gives_anything_but_one_line(text):
    try:
        parse(text, "mine.yaml")
    except BenchError as error:
        assert "\n" not in str(error)


def test_a_camera_set_askew_is_the_same_to_renderer_and_robot():
    """Turned left, tilted down, rolled: OpenCV's rotations about the camera's own axes, in this order."""
    askew = {
        "forward_m": 0.3,
        "left_m": -0.2,
        "height_m": 1.4,
        "pitch_deg": 20,
        "yaw_deg": 15,
        "roll_deg": -8,
    }
    choice = CameraChoice.model_validate(askew)
    known = camera_choice.calibration(choice).T_robot_camera
    np.testing.assert_allclose(camera_choice.mount(choice).T_robot_camera, known, atol=1e-15)
    axes = np.array(
        [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
    )  # a level camera's right, down and ahead in the robot
    for axis, degrees in (([0, 1, 0], -15), ([1, 0, 0], -20), ([0, 0, 1], -8)):
        axes = axes @ cv2.Rodrigues(np.radians(degrees) * np.array(axis, dtype=float))[0]
    np.testing.assert_allclose(known[:3, :3], axes, atol=1e-12)
    assert known[:3, 3].tolist() == [0.3, -0.2, 1.4]


def test_discs_out_of_order_are_refused():
    assert "min_radius_m 0.3 must be below max_radius_m 0.2" in refusal(HEAD + "discs: {min_radius_m: 0.3}\n")


def test_a_list_where_a_parameter_takes_one_value_is_a_sweep():
    text = "filters: [seed, {name: seed, parameters: {patch: [1, 5], linear: [true, false]}}]"
    study = parse(HEAD + text, "x")
    assert {choice.label: choice.parameters for choice in study.filters} == {
        "none": {},
        "seed": {},
        "seed patch=1 linear=true": {"patch": 1, "linear": True},
        "seed patch=1 linear=false": {"patch": 1, "linear": False},
        "seed patch=5 linear=true": {"patch": 5, "linear": True},
        "seed patch=5 linear=false": {"patch": 5, "linear": False},
    }
    assert parse(dump(study), "again") == study


def test_a_filter_may_be_a_class_or_a_file():
    study = parse(HEAD + "filters: ['pack.age:MyNet', 'nets/Net v2.onnx', {name: 'a:B', label: mine}]", "x")
    assert [choice.label for choice in study.filters] == ["none", "mynet", "net-v2", "mine"]
    assert parse(dump(study), "again") == study


@pytest.mark.parametrize("kind", models())
def test_every_kind_has_a_model_a_runner_and_a_page(kind):
    """The registry finds a kind by its module; the runner and the report find theirs by the same name."""
    assert get_args(models()[kind].model_fields["sequence"].annotation) == (kind,)
    assert callable(import_module(f"bench.{kind}_run").run)
    assert kind_of(kind).summary
    assert kind in {load(name).sequence for name in names()}, "a packaged study shows it"


def test_a_share_of_the_discs_is_left_and_nothing_else_changes():
    from bench.sequences.lighting import as_built

    def built(share):
        scene = {"name": "office", "split": "train", "disc_share": share}
        return as_built(RenderedStudy.model_validate({"sequence": "rendered", "name": "few", "scene": scene}))

    full, half, few = (built(share) for share in (1.0, 0.5, 0.1))
    assert len(half.landmarks) == round(0.5 * len(full.landmarks))
    assert len(few.landmarks) == round(0.1 * len(full.landmarks))
    for scene in (half, few):
        assert [disc.id for disc in scene.landmarks] == list(range(len(scene.landmarks)))
        assert all(
            s is not None and s.name == f.name for s, f in zip(scene.surfaces, full.surfaces, strict=True)
        )
        np.testing.assert_array_equal(scene.tour.poses, full.tour.poses)
    places = [{disc.position for disc in scene.landmarks} for scene in (few, half, full)]
    assert places[0] < places[1] < places[2]
    assert built(0.1).landmarks == few.landmarks
