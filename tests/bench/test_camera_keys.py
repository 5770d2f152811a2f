"""What a study says of sensor and lens, and what comes of it in the sequence."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from bench import cli
from bench.camera_choice import OpticsChoice, camera
from bench.errors import BenchError
from bench.kinds.rendered import RenderedStudy
from bench.sensor_choice import SensorChoice
from bench.sequences.lighting import light_colours
from bench.sequences.rendered import RenderedSequence, SequenceSetup, sensor
from bench.study import parse
from renderers.basis import SceneRenderer
from renderers.camera import Mount
from renderers.colour_filter_array import ARRAYS
from renderers.colour_matrix import SENSITIVITIES
from renderers.demosaicing import methods
from renderers.irradiance import BakeQuality
from renderers.optics import Optics, basis_through_lens
from renderers.sensor import METERINGS, Sensor, preset
from renderers.sensor_presets import PRESETS

HEAD = "sequence: rendered\nname: mine\n"


def study(body: str = "") -> RenderedStudy:
    parsed = parse(HEAD + body, "mine.yaml")
    assert isinstance(parsed, RenderedStudy)
    return parsed


def refusal(body: str) -> str:
    with pytest.raises(BenchError) as caught:
        parse(HEAD + body, "mine.yaml")
    assert "\n" not in str(caught.value)
    return str(caught.value).removeprefix("mine.yaml: ")


@pytest.mark.parametrize("name", list(PRESETS))
def test_preset_gives_its_camera_with_the_sensors_own_settings(name: str) -> None:
    found = sensor(study(f"sensor: {{preset: {name}}}"))
    assert replace(found, serial_number=0) == preset(name)


def test_without_any_key_it_is_the_sensors_default() -> None:
    assert replace(sensor(study()), serial_number=0) == Sensor()


def test_a_key_stands_before_the_presets_number() -> None:
    found = sensor(
        study(
            "sensor: {preset: machine-vision, read_noise_e: 3, colour_filter_array: GBRG,"
            " demosaicing: bilinear, sensitivities: nikon-5100, gain_db: 6, max_gain_db: 24,"
            " target: 0.3, exposure: 0.004}"
        )
    )
    assert replace(found, serial_number=0) == preset(
        "machine-vision",
        read_noise_e=3.0,
        colour_filter_array="GBRG",
        demosaicing="bilinear",
        sensitivities="nikon-5100",
        gain_db=6.0,
        max_gain_db=24.0,
        metering_target=0.3,
        exposure_s=0.004,
    )


@pytest.mark.parametrize(
    ("key", "known"),
    [
        ("preset", PRESETS),
        ("colour_filter_array", ARRAYS),
        ("demosaicing", methods()),
        ("sensitivities", SENSITIVITIES),
        ("metering", METERINGS),
    ],
)
def test_a_study_allows_what_the_renderer_has(key: str, known: object) -> None:
    assert set(get_args(SensorChoice.model_fields[key].annotation)) == set(known)  # type: ignore[call-overload]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("sensor: {preset: webcm}", "sensor.preset: should be 'standard', 'machine-vision', 'webcam' or"),
        (
            "sensor: {colour_filter_array: RGBG}",
            "sensor.colour_filter_array: should be 'none', 'RGGB', 'BGGR',",
        ),
        (
            "sensor: {demosaicing: vng}",
            "sensor.demosaicing: should be 'bilinear', 'malvar' or 'edge-aware', not",
        ),
        ("sensor: {sensitivities: nikon}", "sensor.sensitivities: should be 'srgb', 'nikon-5100' or"),
        ("sensor: {gain_db: -3}", "sensor.gain_db: should be greater than or equal to 0, not -3"),
        ("sensor: {max_gain_db: 60}", "sensor.max_gain_db: should be less than or equal to 48, not 60"),
        ("sensor: {gain: 3}", "sensor.gain: unknown key: did you mean 'gain_db'"),
        (
            "sensor: {preset: machine-vision, bit_depth: 8, black_level_dn: 128}",
            "sensor: black_level_dn 128: must",
        ),
        ("camera: {optics: {glare: 1}}", "camera.optics.glare: should be less than 1, not 1"),
        ("camera: {optics: {blur: 1}}", "camera.optics.blur: unknown key: did you mean 'blur_px'"),
        ("camera: {optics: {vignetting: cos4}}", "camera.optics.vignetting: should be 'none' or 'natural'"),
    ],
)
def test_what_is_wrong_is_named_with_what_is_allowed(body: str, expected: str) -> None:
    assert refusal(body).startswith(expected)


def test_an_impossible_sensor_is_one_line_and_exit_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(HEAD + "sensor: {gain_db: 99}\n")
    assert cli.execute(["run", "--study", str(file), "--out", str(tmp_path / "results")]) == 2
    assert (
        capsys.readouterr().err
        == f"error: {file}: sensor.gain_db: should be less than or equal to 48, not 99\n"
    )
    assert not (tmp_path / "results").exists()


def sequence(body: str) -> RenderedSequence:
    small = study(f"scene: {{parameters: {{laps: 0.02}}}}\n{body}")
    return RenderedSequence(SequenceSetup(small, "raycast", light_colours(small), 1, None))


@pytest.fixture(scope="module")
def plain() -> RenderedSequence:
    """A few metres of the corridor through 80 × 60 pixels, baked coarsely."""
    made = sequence("camera: {width: 80, height: 60}")
    view, coarse = made.study.camera, BakeQuality(8, 4, -1)
    mount = Mount(view.height_m, 0.0, view.pitch_deg)
    made.renderer = SceneRenderer(made.scene, camera(view), mount, threads=1, quality=coarse)
    return made


def test_the_lens_of_the_study_stands_before_the_sensor(plain: RenderedSequence) -> None:
    keys = {"vignetting": "natural", "blur_px": 1.5, "glare": 0.05, "glare_radius_px": 6.0}
    of_the_sequence = {"motion_blur"}  # needs the robot's motion, which no lens knows
    assert set(OpticsChoice.model_fields) - of_the_sequence == {f.name for f in fields(Optics)} == set(keys)
    fitted = sequence(f"camera: {{width: 80, height: 60, optics: {keys}}}")
    fitted.renderer = plain.renderer
    behind = fitted.basis(0)
    expected = basis_through_lens(Optics(**keys), camera(plain.study.camera), plain.basis(0))  # type: ignore[arg-type]
    np.testing.assert_array_equal(behind.diffuse, expected.diffuse)
    np.testing.assert_array_equal(behind.specular, expected.specular)
    assert not np.array_equal(behind.diffuse, plain.basis(0).diffuse)


def test_a_mosaic_is_recorded_as_the_study_says(plain: RenderedSequence) -> None:
    """Its raw numbers are the three-plane sensor's at each site's own colour, but for noise."""
    light = plain.study.illuminations.grid()[-1]
    bayer = sequence("camera: {width: 80, height: 60}\nsensor: {colour_filter_array: BGGR}")
    planes, mosaic = (s.record(plain.basis(0), light, 0).raw.astype(float) for s in (plain, bayer))
    assert mosaic.shape == (60, 80)
    for (row, column), channel in {(0, 0): 2, (0, 1): 1, (1, 0): 1, (1, 1): 0}.items():
        here = np.s_[row::2, column::2]
        assert mosaic[here].mean() == pytest.approx(planes[..., channel][here].mean(), rel=5e-3)
