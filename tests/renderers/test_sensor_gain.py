"""Analogue gain: photon transfer, saturation and automatic exposure, by EMVA 1288's equations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from renderers.colour_filter_array import behind_filters
from renderers.develop import develop
from renderers.errors import RendererError
from renderers.metering import Exposure, meter, shifted
from renderers.sensor import Sensor, digitise, expose, mean_electrons, preset
from renderers.truth import record

WHITE = np.ones(3)
FOUR_TIMES = 20 * np.log10(4)


def flat(value, shape=(64, 64)):
    return np.full((*shape, 3), value, dtype=np.float32)


@pytest.mark.parametrize("gain_db", [0.0, 6.0, 12.0, 24.0])
@pytest.mark.parametrize("name", ["standard", "machine-vision"])
def test_slope_of_the_photon_transfer_is_the_amplified_gain(name, gain_db):
    """σ² against μ from an eighth to three quarters of saturation, a straight line of slope K·10^(g/20)."""
    sensor = preset(name, gain_db=gain_db, bit_depth=14, black_level_dn=600, prnu=0.0, dsnu_e=0.0)
    unamplified = (2**14 - 1 - 600) / sensor.full_well_e
    levels = np.linspace(0.125, 0.75, 6) * sensor.full_well_e / 10 ** (gain_db / 20)
    rng = np.random.default_rng(1)
    shots = [expose(sensor, flat(e, (300, 300)), rng).astype(float) for e in levels]
    slope, _ = np.polyfit([s.mean() for s in shots], [s.var() for s in shots], 1)
    assert slope == pytest.approx(unamplified * 10 ** (gain_db / 20), rel=0.015)


def test_read_noise_is_amplified_and_quantisation_is_not():
    for gain_db in (0.0, 20.0):
        sensor = Sensor(bit_depth=12, black_level_dn=512, gain_db=gain_db)
        raw = expose(sensor, flat(0.0, (300, 300)), np.random.default_rng(2)).astype(float)
        K = (4095 - 512) / 20_000 * 10 ** (gain_db / 20)
        assert raw.var() == pytest.approx((K * sensor.read_noise_e) ** 2 + 1 / 12, rel=0.02)


@given(st.floats(0.0, 48.0))
def test_amplified_electrons_fill_the_adc_earlier(gain_db):
    sensor = Sensor(bit_depth=16, black_level_dn=1000, gain_db=gain_db)
    most = 20_000 / 10 ** (gain_db / 20)
    assert (digitise(sensor, flat(1.001 * most, (2, 2))) == 65_535).all()
    half = digitise(sensor, flat(most / 2, (2, 2)))
    np.testing.assert_allclose(half, 1000 + (65_535 - 1000) / 2, atol=1)


class TestAutomaticExposure:
    def test_gain_makes_up_for_the_shutters_limit(self):
        """A scene that needs four times the longest exposure gets 12.04 dB, and its mean is the target."""
        sensor = Sensor(max_gain_db=30.0, max_exposure_s=0.01)
        per_second = sensor.electrons_per_luminance.mean() / sensor.full_well_e
        luminance = flat(0.18 / (per_second * 0.04))
        exposure = meter(sensor, luminance, WHITE)
        assert exposure.seconds == 0.01
        assert exposure.gain_db == pytest.approx(FOUR_TIMES, abs=1e-4)
        amplified = sensor.amplified(exposure.gain_db)
        raw = digitise(amplified, mean_electrons(amplified, luminance, exposure.seconds)).astype(float)
        assert ((raw - 16) / (1023 - 16)).mean() == pytest.approx(0.18, abs=1e-3)

    def test_no_more_than_allowed(self):
        assert meter(Sensor(max_gain_db=18.0), flat(0.0), WHITE).gain_db == 18.0
        assert meter(Sensor(), flat(0.0), WHITE).gain_db == 0.0
        assert meter(Sensor(gain_db=12.0, max_gain_db=6.0), flat(0.0), WHITE).gain_db == 12.0

    @pytest.mark.parametrize("metering", ["average", "centre-weighted", "highlight-priority"])
    def test_bright_scene_needs_none(self, metering):
        sensor = Sensor(metering=metering, max_gain_db=48.0)
        for level in (100.0, 1e9):
            assert meter(sensor, flat(level), WHITE).gain_db == 0.0

    def test_four_times_the_gain_a_quarter_of_the_time(self):
        plain, amplified = (
            meter(Sensor(gain_db=gain), flat(500.0), WHITE).seconds for gain in (0.0, FOUR_TIMES)
        )
        assert plain / amplified == pytest.approx(4.0, rel=1e-6)

    def test_fixed_exposure_keeps_its_gain(self):
        sensor = Sensor(exposure_s=0.001, gain_db=6.0, max_gain_db=48.0)
        assert meter(sensor, flat(0.1), WHITE).gain_db == 6.0

    def test_bracket_has_one_gain(self):
        sensor = Sensor(max_gain_db=18.0)
        metered = meter(sensor, flat(0.01), WHITE)
        assert {shifted(sensor, metered, ev).gain_db for ev in (-2, 0)} == {18.0}


def test_quarter_of_the_light_at_four_times_the_gain_is_the_same_picture_but_for_noise():
    luminance = np.random.default_rng(3).uniform(1.0, 9.0, (60, 80, 3)).astype(np.float32)
    luminance[20:30, 20:30] = 500.0  # clips
    options = {"max_exposure_s": 1e-3, "bit_depth": 12}
    dark = np.zeros_like(luminance)
    bright = record(Sensor(**options), 4 * luminance, dark, WHITE, np.random.default_rng(0))
    amplified = record(
        Sensor(**options, gain_db=FOUR_TIMES), luminance, dark, WHITE, np.random.default_rng(0)
    )
    assert bright.exposure.seconds == amplified.exposure.seconds == 1e-3
    assert np.abs(bright.full.astype(int) - amplified.full).max() <= 1
    np.testing.assert_array_equal(bright.saturated, amplified.saturated)
    assert bright.saturated.sum() == 100
    unclipped = ~bright.saturated
    noise = [np.std((r.image.astype(float) - r.full)[unclipped]) for r in (bright, amplified)]
    assert noise[1] > 1.5 * noise[0]


@pytest.mark.parametrize("array", ["none", "GBRG"])
def test_camera_takes_its_amplified_dark_current_for_black(array):
    """1200 thermal electrons leave 3824 of the 5024 that fill the ADC at 12 dB, stretched to white."""
    sensor = Sensor(bit_depth=16, gain_db=12.0, colour_filter_array=array)
    exposure = Exposure(1.0, np.array([1.3, 1.0, 1.2]), 12.0)
    light = np.random.default_rng(0).uniform(0, 2_500, (40, 50, 3)).astype(np.float32)
    light = behind_filters(array, light)
    left = 1 - 1_200 / (20_000 / 10 ** (12 / 20))
    dark = develop(sensor, digitise(sensor, light + np.float32(1_200)), exposure, dark_electrons=1_200.0)
    plain = develop(sensor, digitise(sensor, light / np.float32(left)), exposure)
    assert np.abs(dark.astype(int) - plain).max() <= 1
    assert dark.min() < 20 and dark.mean() > 100


@pytest.mark.parametrize(
    "bad", [{"gain_db": -1.0}, {"max_gain_db": 60.0}, {"gain_db": float("nan")}], ids=str
)
def test_impossible_gains(bad):
    with pytest.raises(RendererError, match="sensor: gain_db and max_gain_db must lie in 0…48 dB"):
        Sensor(**bad)
