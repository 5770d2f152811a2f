"""The ground truth of a recording: noise-free, and exactly what the definitions say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from renderers import truth
from renderers.colour_filter_array import behind_filters
from renderers.develop import develop
from renderers.metering import meter, shifted
from renderers.sensor import Sensor, digitise, mean_electrons, preset
from renderers.truth import record

WHITE = np.array([1.1, 1.0, 0.8])


@pytest.fixture(scope="module")
def signal():
    """A smooth picture with a highlight in it whose middle clips."""
    v, u = np.mgrid[0:60, 0:80]
    diffuse = (30.0 + u[..., None] * [1.0, 0.7, 0.3]).astype(np.float32)
    glow = 20_000.0 * np.exp(-((u - 40) ** 2 + (v - 30) ** 2) / 40.0)
    return diffuse, (glow[..., None] * WHITE).astype(np.float32)


CHAINS = {
    "standard": Sensor(),
    "mosaic": Sensor(colour_filter_array="GRBG"),
    "matrix": Sensor(sensitivities="nikon-5100"),
    "both, amplified": preset("webcam", sensitivities="nikon-5100", demosaicing="edge-aware", gain_db=9.0),
}

chains = pytest.mark.parametrize("sensor", CHAINS.values(), ids=CHAINS)


def take(signal, seed=0, sensor=CHAINS["standard"], **options):
    return record(sensor, *signal, WHITE, np.random.default_rng(seed), **options)


@chains
@pytest.mark.parametrize("threshold", [1, 16, 40])
def test_highlight_is_where_the_difference_reaches_the_threshold(signal, sensor, threshold):
    shot = take(signal, sensor=sensor, threshold=threshold)
    difference = shot.full.astype(int) - shot.diffuse.astype(int)
    np.testing.assert_array_equal(shot.highlight, difference.max(axis=-1) >= threshold)
    assert 0 < shot.highlight.mean() < 0.5


def test_higher_threshold_is_a_smaller_mask(signal):
    low, high = (take(signal, threshold=t).highlight for t in (8, 32))
    assert (low | ~high).all() and low.sum() > high.sum()


@chains
def test_saturated_is_where_the_signal_clips(signal, sensor):
    shot = take(signal, sensor=sensor)
    electrons = mean_electrons(sensor, signal[0] + signal[1], shot.exposure.seconds)
    most = sensor.full_well_e / 10 ** (shot.exposure.gain_db / 20)
    np.testing.assert_array_equal(shot.saturated, (electrons >= most).any(axis=-1))
    assert 0 < shot.saturated.sum() < shot.highlight.sum()
    assert (digitise(sensor, electrons)[shot.saturated].max(axis=-1) == 1023).all()
    np.testing.assert_array_equal(shot.light, shot.highlight | shot.saturated)


def test_diffuse_light_can_saturate_without_a_highlight():
    """A sunlit patch of wall that clips by its diffuse light alone is saturated, not highlight."""
    diffuse = np.full((40, 40, 3), 20.0, np.float32)
    diffuse[10:20, 10:20] = 1e5
    shot = take((diffuse, np.zeros_like(diffuse)))
    assert not shot.highlight.any()
    assert shot.saturated[10:20, 10:20].all() and shot.saturated.sum() == 100
    np.testing.assert_array_equal(shot.light, shot.saturated)


@chains
def test_no_specular_light_no_highlight(signal, sensor):
    shot = take((signal[0], np.zeros_like(signal[0])), sensor=sensor)
    assert not shot.highlight.any()
    np.testing.assert_array_equal(shot.full, shot.diffuse)


@chains
def test_truth_does_not_depend_on_the_noise(signal, sensor):
    one, other = take(signal, 1, sensor), take(signal, 2, sensor)
    for name in ("full", "diffuse", "highlight", "saturated"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert (one.image != other.image).mean() > 0.3


@pytest.mark.parametrize("name", ["old-robot", "machine-vision"])
def test_truth_is_the_ideal_sensors(signal, name):
    """Digitised and developed step by step, without the flaws that the picture has."""
    sensor = preset(name, serial_number=3)
    shot = record(sensor, *signal, WHITE, np.random.default_rng(0))
    for name, light in (("full", signal[0] + signal[1]), ("diffuse", signal[0])):
        electrons = mean_electrons(sensor, light, shot.exposure.seconds)
        raw = digitise(sensor, behind_filters(sensor.colour_filter_array, electrons))
        np.testing.assert_array_equal(getattr(shot, name), develop(sensor, raw, shot.exposure))
    flawless = replace(sensor, prnu=0.0, dsnu_e=0.0, dark_current_e_per_s=0.0, read_noise_e=0.0)
    ideal = record(flawless, *signal, WHITE, np.random.default_rng(0))
    np.testing.assert_array_equal(shot.full, ideal.full)
    assert (shot.image != ideal.image).mean() > 0.3


def test_picture_of_a_bracket_has_its_own_exposure(signal):
    brighter = meter(Sensor(), signal[0] + signal[1], WHITE)
    darker = shifted(Sensor(), brighter, -3)
    one, other = (take(signal, exposure=e) for e in (darker, brighter))
    assert one.exposure.seconds == pytest.approx(other.exposure.seconds / 8)
    assert one.saturated.sum() < other.saturated.sum()
    assert one.full.astype(int).sum() < other.full.astype(int).sum()


def test_colour_matrix_of_one_is_no_matrix(signal):
    """The way through mosaic and matrix and the short way are one chain: the same picture, step for step."""
    short = take(signal, 3)
    sensor, exposure = Sensor(), short.exposure
    long = truth._record_in_steps(
        sensor,
        signal[0],
        mean_electrons(sensor, signal[0] + signal[1], exposure.seconds),
        exposure,
        np.random.default_rng(3),
        16,
    )
    for name in ("image", "raw", "full", "diffuse", "highlight", "saturated"):
        np.testing.assert_array_equal(getattr(short, name), getattr(long, name))


@chains
def test_same_generator_same_bytes(signal, sensor):
    one, other = take(signal, 7, sensor), take(signal, 7, sensor)
    for name in ("image", "raw", "full", "diffuse", "highlight", "saturated"):
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes()


def test_noisy_picture_scatters_about_the_true_one(signal):
    raws = np.stack([take(signal, seed).raw for seed in range(64)]).astype(np.float64)
    shot = take(signal)
    clean = digitise(Sensor(), mean_electrons(Sensor(), signal[0] + signal[1], shot.exposure.seconds)).astype(
        float
    )
    linear = clean < 900
    sigma = raws.std(axis=0)[linear]
    z = (raws.mean(axis=0) - clean)[linear] / (sigma / 8 + 0.3)  # the clean value is rounded itself
    assert np.abs(z).mean() < 1.0 and np.abs(z).max() < 6


def test_exposure_is_that_of_the_lit_scene(signal):
    """The restoration target has the same settings: where no specular light falls it is the picture."""
    shot = take(signal)
    corner = np.s_[:5, :5]
    assert not signal[1][corner].max() > 1e-3
    np.testing.assert_array_equal(shot.full[corner], shot.diffuse[corner])


@chains
def test_shapes_and_types(signal, sensor):
    shot = take(signal, sensor=sensor)
    assert shot.image.shape == shot.full.shape == shot.diffuse.shape == (60, 80, 3)
    assert shot.raw.shape == ((60, 80, 3) if sensor.colour_filter_array == "none" else (60, 80))
    assert shot.image.dtype == shot.full.dtype == shot.diffuse.dtype == np.uint8
    assert shot.raw.dtype == np.uint16
    assert shot.highlight.shape == shot.saturated.shape == shot.light.shape == (60, 80)
    assert shot.highlight.dtype == shot.saturated.dtype == np.bool_
