"""The sensor against the EMVA 1288 formulas and worked examples."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from renderers.errors import RendererError
from renderers.sensor import Exposure, Sensor, develop, digitise, expose, mean_electrons, meter

WHITE = np.ones(3)
FINE = Sensor(bit_depth=16, black_level_dn=1000, full_well_e=60_000.0, read_noise_e=6.0)


def flat(value, shape=(64, 64)):
    return np.full((*shape, 3), value, dtype=np.float32)


def test_worked_example_of_sunlight_on_grey():
    """97 klx on ρ = 0.5 at f/8, 1/250 s, 3.45 µm, quantum efficiency 0.5: about 49 ke⁻."""
    sensor = Sensor(pixel_pitch_um=3.45, f_number=8.0, lens_transmission=1.0, quantum_efficiency=(0.5,) * 3)
    luminance = flat(0.5 * 97_000 / np.pi, (1, 1))
    electrons = mean_electrons(sensor, luminance, Exposure(1 / 250, WHITE))
    np.testing.assert_allclose(electrons, 49_000, rtol=0.01)


def test_photons_per_lux_of_daylight():
    """∫ S λ/(h c) dλ / (683 ∫ S V dλ) over a 6504 K black body, close to D65, 400–700 nm."""
    from renderers.sensor import PHOTONS_PER_LUX

    wavelength = np.linspace(400e-9, 700e-9, 601)
    h, c, k = 6.62607015e-34, 2.99792458e8, 1.380649e-23
    spectrum = wavelength**-5 / (np.exp(h * c / (wavelength * k * 6504)) - 1)
    # V(λ) by Wyman, Sloan & Shirley 2013, single-lobe fit
    V = 0.821 * np.exp(-0.5 * ((wavelength * 1e9 - 568.8) / np.where(wavelength < 568.8e-9, 46.9, 40.5)) ** 2)
    V += 0.286 * np.exp(
        -0.5 * ((wavelength * 1e9 - 530.9) / np.where(wavelength < 530.9e-9, 16.3, 31.1)) ** 2
    )
    photons = (spectrum * wavelength / (h * c)).sum() / (683 * (spectrum * V).sum())
    assert pytest.approx(photons, rel=0.02) == PHOTONS_PER_LUX


@given(
    st.floats(1.0, 16.0), st.floats(1e-5, 1.0), st.floats(1.0, 10.0), st.floats(0.1, 1e4), st.floats(0.1, 1.0)
)
def test_electrons_follow_aperture_time_and_pixel_area(f_number, seconds, pitch, luminance, transmission):
    sensor = Sensor(pixel_pitch_um=pitch, f_number=f_number, lens_transmission=transmission)
    lux = np.pi * transmission * luminance / (4 * f_number**2)
    expected = lux * seconds * (pitch * 1e-6) ** 2 * 1.09e16 * np.array(sensor.quantum_efficiency)
    electrons = mean_electrons(sensor, flat(luminance, (1, 1)), Exposure(seconds, WHITE))
    np.testing.assert_allclose(electrons[0, 0], expected, rtol=1e-5)


LEVELS = [0.0, 0.5, 3.0, 9.0, 11.0, 40.0, 200.0, 1_000.0, 9_000.0]


def recorded(sensor, electrons):
    raw = expose(sensor, flat(electrons, (300, 300)), np.random.default_rng(5))
    return raw.astype(np.float64).ravel()


@pytest.mark.parametrize("electrons", [*LEVELS, 40_000.0])
def test_mean_and_variance_are_those_of_emva_1288(electrons):
    """μ_y = K μ_e + black, σ_y² = K² (μ_e + σ_r²) + 1/12, within 4.5 standard errors of the estimates."""
    raw = recorded(FINE, electrons)
    K, n = FINE.gain_dn_per_e, raw.size
    variance = K**2 * (electrons + FINE.read_noise_e**2) + 1 / 12
    assert raw.mean() == pytest.approx(K * electrons + FINE.black_level_dn, abs=4.5 * np.sqrt(variance / n))
    excess = K**4 * electrons / variance**2  # kurtosis of the Poisson part
    assert raw.var(ddof=1) == pytest.approx(variance, abs=4.5 * variance * np.sqrt((2 + excess) / n))


@pytest.mark.parametrize("electrons", LEVELS)
def test_coarse_adc_records_the_exact_distribution(electrons):
    """With σ below half a step 1/12 no longer holds: Poisson * normal, cut into steps, by chi-square."""
    sensor = Sensor()
    raw = recorded(sensor, electrons)
    counts = np.arange(stats.poisson.ppf(1e-9, electrons), stats.poisson.isf(1e-9, electrons) + 1)
    weight = stats.poisson.pmf(counts, electrons)
    steps = np.arange(raw.min(), raw.max() + 1)
    upper = (steps + 0.5 - sensor.black_level_dn) / sensor.gain_dn_per_e
    below = stats.norm.cdf((upper[:, None] - counts) / sensor.read_noise_e) @ weight
    expected = raw.size * np.diff(np.concatenate([[0.0], below[:-1], [1.0]]))
    observed = np.bincount((raw - steps[0]).astype(int), minlength=len(steps))
    assert chi_square_p(observed, expected) > 1e-3


def chi_square_p(observed, expected):
    """p-value; cells with fewer than five expected are joined."""
    rare = expected < 5
    observed = np.append(observed[~rare], observed[rare].sum())
    expected = np.append(expected[~rare], expected[rare].sum())
    if expected[-1] < 1:
        observed, expected = observed[:-1], expected[:-1]
    return stats.chi2((len(expected) - 1) or 1).sf(((observed - expected) ** 2 / expected).sum())


@pytest.mark.parametrize("electrons", [0.01, 0.2, 2.0, 9.99, 10.0, 12.0, 33.0, 300.0, 3_000.0])
def test_shot_noise_is_poisson(electrons):
    """Counts of a noiseless sensor with one DN per electron, by the chi-square test."""
    sensor = Sensor(bit_depth=16, black_level_dn=0, full_well_e=2**16 - 1, read_noise_e=0.0)
    counts = expose(sensor, flat(electrons, (200, 200)), np.random.default_rng(11)).ravel()
    poisson = stats.poisson(electrons)
    bins = np.arange(poisson.ppf(1e-4), poisson.ppf(1 - 1e-4) + 1)
    expected = counts.size * np.concatenate(
        [[poisson.cdf(bins[0])], poisson.pmf(bins[1:-1]), [poisson.sf(bins[-1] - 1)]]
    )
    observed = np.bincount(np.clip(counts, bins[0], bins[-1]).astype(int) - int(bins[0]), minlength=len(bins))
    assert chi_square_p(observed, expected) > 1e-3


def test_read_noise_is_normal():
    sensor = Sensor(bit_depth=16, black_level_dn=30_000, full_well_e=35_535.0, read_noise_e=200.0)
    raw = expose(sensor, flat(0.0, (120, 120)), np.random.default_rng(3)).astype(np.float64).ravel()
    scaled = (raw - 30_000) / 200.0
    assert stats.kstest(scaled, "norm").pvalue > 1e-3


def test_channels_and_pixels_are_independent():
    raw = expose(FINE, flat(1000.0, (200, 200)), np.random.default_rng(0)).astype(np.float64)
    columns = raw.reshape(-1, 3) - raw.mean()
    correlation = np.corrcoef(columns.T)
    assert np.abs(correlation - np.eye(3)).max() < 4.5 / 200
    assert abs(np.corrcoef(raw[:, :-1].ravel(), raw[:, 1:].ravel())[0, 1]) < 4.5 / 346
    assert abs(np.corrcoef(raw[:-1].ravel(), raw[1:].ravel())[0, 1]) < 4.5 / 346


def test_same_generator_same_bytes_and_another_differs():
    electrons = flat(500.0)
    one, same, other = (expose(FINE, electrons, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert one.tobytes() == same.tobytes()
    assert (one != other).mean() > 0.9


def test_generator_moves_on():
    rng = np.random.default_rng(1)
    assert (expose(FINE, flat(500.0), rng) != expose(FINE, flat(500.0), rng)).mean() > 0.9


def test_full_well_and_adc_clip():
    sensor = Sensor()
    for electrons in (sensor.full_well_e, 3 * sensor.full_well_e, 1e12, np.inf):
        assert (digitise(sensor, flat(electrons)) == 1023).all()
    bright = expose(sensor, flat(1e9), np.random.default_rng(0))
    assert (bright == 1023).all()
    assert (digitise(sensor, flat(-1e6)) == 0).all()  # deep read noise ends at 0, not at a wrapped number
    assert (digitise(sensor, flat(0.0)) == sensor.black_level_dn).all()


def test_quantisation_rounds_to_nearest():
    sensor = Sensor(bit_depth=10, black_level_dn=23, full_well_e=1000.0)  # K = 1
    electrons = np.float32([[[0.4, 0.6, 9.49], [9.51, 100.2, 100.8]]])
    np.testing.assert_array_equal(digitise(sensor, electrons) - 23, [[[0, 1, 9], [10, 100, 101]]])


class TestMeter:
    def test_reaches_its_target(self):
        sensor = Sensor(min_exposure_s=1e-7, max_exposure_s=10.0)
        ramp = np.linspace(10.0, 300.0, 64, dtype=np.float32)
        luminance = np.broadcast_to(ramp[:, None, None], (64, 64, 3))
        exposure = meter(sensor, luminance, WHITE)
        fill = mean_electrons(sensor, luminance, exposure) / sensor.full_well_e
        assert np.minimum(fill, 1).mean() == pytest.approx(0.18, rel=0.05)

    def test_bright_and_dark_scenes_meet_the_shutters_limits(self):
        sensor = Sensor()
        assert meter(sensor, flat(1e9), WHITE).seconds == pytest.approx(sensor.min_exposure_s, rel=1e-4)
        assert meter(sensor, flat(1e-6), WHITE).seconds == pytest.approx(sensor.max_exposure_s, rel=1e-4)
        assert meter(sensor, flat(0.0), WHITE).seconds == pytest.approx(sensor.max_exposure_s, rel=1e-4)

    def test_twice_the_light_half_the_time(self):
        one, other = (meter(Sensor(), flat(level), WHITE).seconds for level in (500.0, 1000.0))
        assert one / other == pytest.approx(2.0, rel=1e-4)

    def test_small_bright_lamp_does_not_darken_the_room(self):
        """Clipped metering: a lamp of 1 % of the picture counts as full well, not as its luminance."""
        luminance = flat(200.0, (40, 40))
        luminance[:4, :4] = 1e6
        one, other = meter(Sensor(), flat(200.0, (40, 40)), WHITE), meter(Sensor(), luminance, WHITE)
        assert 0.9 < other.seconds / one.seconds < 1.0

    def test_fixed_exposure_is_kept(self):
        assert meter(Sensor(exposure_s=0.003), flat(1e6), WHITE).seconds == 0.003

    @pytest.mark.parametrize("white", [(1.0, 1.0, 1.0), (1.6, 0.9, 0.4), (0.9, 1.0, 1.3)])
    def test_grey_card_is_grey(self, white):
        sensor = Sensor(bit_depth=16, black_level_dn=0)
        white = np.array(white)
        luminance = (flat(100.0) * white).astype(np.float32)
        exposure = meter(sensor, luminance, white)
        picture = develop(
            sensor, digitise(sensor, mean_electrons(sensor, luminance, exposure)), exposure
        ).astype(int)
        assert np.ptp(picture[0, 0]) <= 1
        assert (
            110 < picture[0, 0, 1] < 150
        )  # 18 % grey is 118 of 255; the weaker channels are amplified to it
        assert exposure.white_balance.min() == 1.0

    def test_clipped_pixels_stay_white(self):
        white = np.array([1.6, 0.9, 0.4])
        exposure = meter(Sensor(), flat(100.0), white)
        full = np.full((2, 2, 3), 1023, dtype=np.uint16)
        assert (develop(Sensor(), full, exposure) == 255).all()


class TestDevelop:
    def test_encodes_srgb(self):
        """Against a table from the standard's formula in another form (inverse, solved by search)."""
        sensor = Sensor(bit_depth=12, black_level_dn=0)
        raw = np.arange(4096, dtype=np.uint16).repeat(3).reshape(64, 64, 3)
        picture = develop(sensor, raw, Exposure(1.0, WHITE))
        level = np.arange(255) + 0.5  # where two neighbouring codes meet
        encoded = level / 255
        edge = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
        expected = np.searchsorted(edge, raw / 4095)
        assert np.abs(picture.astype(int) - expected).max() == 0

    def test_black_level_is_black_and_below_it_too(self):
        raw = np.full((1, 1, 3), 16, dtype=np.uint16)
        assert not develop(Sensor(), raw, Exposure(1.0, WHITE)).any()
        assert not develop(Sensor(), raw - 10, Exposure(1.0, WHITE)).any()

    def test_is_monotonic_with_any_white_balance(self):
        raw = np.arange(1024, dtype=np.uint16).repeat(3).reshape(32, 32, 3)
        picture = develop(Sensor(), raw, Exposure(1.0, np.array([1.0, 1.7, 2.4])))
        for c in range(3):
            assert (np.diff(picture[..., c].ravel().astype(int)) >= 0).all()


@pytest.mark.parametrize(
    "bad",
    [
        {"pixel_pitch_um": 0.0},
        {"f_number": np.nan},
        {"full_well_e": -1.0},
        {"quantum_efficiency": (0.5, 0.5, 1.5)},
        {"lens_transmission": 0.0},
        {"read_noise_e": -1.0},
        {"bit_depth": 4},
        {"black_level_dn": 600},
        {"min_exposure_s": 0.1, "max_exposure_s": 0.01},
        {"metering_target": 0.0},
        {"exposure_s": -1.0},
        {"exposure_s": float("nan")},
        {"read_noise_e": float("nan")},
        {"max_exposure_s": float("inf")},
    ],
    ids=str,
)
def test_impossible_sensors(bad):
    with pytest.raises(RendererError, match="sensor: "):
        Sensor(**bad)
