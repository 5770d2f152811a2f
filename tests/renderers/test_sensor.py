"""The sensor against the EMVA 1288 formulas and worked examples."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from renderers.develop import develop
from renderers.errors import RendererError
from renderers.metering import Exposure, meter, shifted
from renderers.sensor import Sensor, digitise, expose, mean_electrons, preset
from renderers.sensor_presets import PRESETS
from renderers.shot_noise import _bend, count_electrons

WHITE = np.ones(3)
FINE = Sensor(bit_depth=16, black_level_dn=1000, full_well_e=60_000.0, read_noise_e=6.0)


def flat(value, shape=(64, 64)):
    return np.full((*shape, 3), value, dtype=np.float32)


def test_worked_example_of_sunlight_on_grey():
    """97 klx on ρ = 0.5 at f/8, 1/250 s, 3.45 µm, quantum efficiency 0.5: about 49 ke⁻."""
    sensor = Sensor(pixel_pitch_um=3.45, f_number=8.0, lens_transmission=1.0, quantum_efficiency=(0.5,) * 3)
    luminance = flat(0.5 * 97_000 / np.pi, (1, 1))
    electrons = mean_electrons(sensor, luminance, 1 / 250)
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
    electrons = mean_electrons(sensor, flat(luminance, (1, 1)), seconds)
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


@pytest.mark.parametrize("read_noise", [1.0, 2.0, 4.0, 8.0])
@pytest.mark.parametrize("electrons", [0.5, 8.0, 49.0, 51.0, 120.0, 5_000.0])
def test_counts_with_read_noise_have_the_exact_distribution(electrons, read_noise):
    """Kolmogorov–Smirnov against the convolution, on both sides of where the cumulants take over."""
    drawn = count_electrons(np.full(150_000, electrons, np.float32), read_noise, np.random.default_rng(2))
    counts = np.arange(stats.poisson.ppf(1e-12, electrons), stats.poisson.isf(1e-12, electrons) + 1)
    grid = np.linspace(drawn.min() - 1, drawn.max() + 1, 4_000)
    below = stats.norm.cdf((grid[:, None] - counts) / read_noise) @ stats.poisson.pmf(counts, electrons)
    assert stats.kstest(drawn.astype(float), lambda x: np.interp(x, grid, below)).pvalue > 1e-3


def test_bent_normal_numbers_are_off_by_less_than_stated():
    """The distribution function of the cumulants' series itself, without random numbers, below 1e-6."""
    z = np.linspace(-5, 5, 401)
    for read_noise, electrons in [
        (1.0, 50.0),
        (1.0, 90.0),
        (4.0, 1.0),
        (4.0, 10.0),
        (4.0, 40.0),
        (8.0, 300.0),
    ]:
        out = np.empty(len(z), np.float32)
        _bend(np.full(len(z), electrons, np.float32), z.astype(np.float32), read_noise, out)
        counts = np.arange(0, stats.poisson.isf(1e-14, electrons) + 1)
        weight = stats.poisson.pmf(counts, electrons)
        below = stats.norm.cdf((out.astype(float)[:, None] - counts) / read_noise) @ weight
        assert np.abs(below - stats.norm.cdf(z.astype(np.float32))).max() < 1.2e-6


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


class TestFixedPatterns:
    SENSOR = Sensor(bit_depth=16, black_level_dn=2000, full_well_e=60_000.0, prnu=0.02, dsnu_e=40.0)

    def test_stay_from_picture_to_picture_and_differ_between_cameras(self):
        """The mean of many pictures of one camera converges to the pattern; two cameras share nothing."""
        rng = np.random.default_rng(1)
        one, same, other = (
            np.mean([expose(sensor, flat(20_000.0), rng) for _ in range(20)], axis=0).ravel()
            for sensor in (self.SENSOR, self.SENSOR, replace(self.SENSOR, serial_number=9))
        )
        assert np.corrcoef(one, same)[0, 1] > 0.98
        assert abs(np.corrcoef(one, other)[0, 1]) < 4.5 / np.sqrt(one.size)

    def test_prnu_grows_with_the_signal_and_dsnu_does_not(self):
        """Spatial standard deviation √(DSNU² + (PRNU μ_e)²) of an average over 60 pictures."""
        rng, K = np.random.default_rng(2), self.SENSOR.gain_dn_per_e
        for electrons in (0.0, 5_000.0, 40_000.0):
            shots = np.stack([expose(self.SENSOR, flat(electrons), rng) for _ in range(60)]).astype(float)
            spatial = shots.mean(axis=0).var() - shots.var(axis=0, ddof=1).mean() / 60
            expected = np.hypot(self.SENSOR.dsnu_e, self.SENSOR.prnu * electrons)
            assert np.sqrt(spatial) / K == pytest.approx(expected, rel=0.04)


def test_dark_current_doubles_with_temperature():
    sensor = Sensor(dark_current_e_per_s=300.0, doubling_temperature_k=7.0, reference_temperature_c=20.0)
    assert replace(sensor, temperature_c=20.0).dark_electrons(0.5) == pytest.approx(150.0)
    assert replace(sensor, temperature_c=34.0).dark_electrons(0.5) == pytest.approx(600.0)
    assert replace(sensor, temperature_c=13.0).dark_electrons(0.5) == pytest.approx(75.0)


def test_dark_current_adds_its_mean_and_its_shot_noise():
    sensor = replace(FINE, dark_current_e_per_s=2_000.0)
    raw = expose(sensor, flat(500.0, (300, 300)), np.random.default_rng(5), seconds=2.0).astype(float)
    K, electrons = sensor.gain_dn_per_e, 4_500.0
    assert raw.mean() == pytest.approx(K * electrons + sensor.black_level_dn, rel=1e-3)
    assert raw.var() == pytest.approx(K**2 * (electrons + sensor.read_noise_e**2) + 1 / 12, rel=0.02)


def test_camera_takes_its_mean_dark_current_for_black():
    sensor = replace(FINE, dark_current_e_per_s=1_000.0)
    raw = digitise(sensor, flat(1_000.0))
    assert not develop(sensor, raw, Exposure(1.0, WHITE), dark_electrons=1_000.0).any()
    full = np.full((1, 1, 3), sensor.largest_dn, np.uint16)
    assert (develop(sensor, full, Exposure(1.0, WHITE), dark_electrons=1_000.0) == 255).all()


class TestPresets:
    @pytest.mark.parametrize("name", list(PRESETS))
    def test_each_is_a_possible_sensor(self, name):
        sensor = preset(name)
        assert all(getattr(sensor, key) == value for key, value in asdict(PRESETS[name]).items())

    def test_standard_is_the_default(self):
        assert preset("standard") == Sensor()

    def test_overrides(self):
        assert preset("webcam", read_noise_e=3.0).read_noise_e == 3.0

    @pytest.mark.parametrize("name, options", [("webcm", {}), ("webcam", {"readnoise_e": 2.0})])
    def test_unknown_names_suggest_near_ones(self, name, options):
        with pytest.raises(RendererError, match=r"did you mean (webcam|read_noise_e)"):
            preset(name, **options)


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
        fill = mean_electrons(sensor, luminance, exposure.seconds) / sensor.full_well_e
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

    def test_average_of_a_clipping_scene_by_bisection(self):
        """Newton's answer against the definition: the clipped mean at its exposure is the target."""
        sensor = Sensor(min_exposure_s=1e-9, max_exposure_s=10.0)
        luminance = np.random.default_rng(0).lognormal(4.0, 3.0, (80, 80, 3)).astype(np.float32)
        fill = mean_electrons(sensor, luminance, meter(sensor, luminance, WHITE).seconds)[::4, ::4]
        assert (fill > sensor.full_well_e).mean() > 0.05
        assert np.minimum(fill / sensor.full_well_e, 1).mean() == pytest.approx(0.18, rel=1e-5)

    def test_centre_weighted_cares_more_for_the_middle(self):
        """75 % of the weight on the disc: its luminance alone, four times as high, sets the time."""
        luminance = flat(100.0, (240, 320))
        v, u = np.mgrid[0:240, 0:320]
        disc = np.hypot(u - 159.5, v - 119.5) < 60
        luminance[disc] = 400.0
        average, centred = (
            meter(Sensor(metering=m), luminance, WHITE).seconds for m in ("average", "centre-weighted")
        )
        mean = 100.0 + 300.0 * disc.mean()
        assert average / centred == pytest.approx((0.75 * 400 + 0.25 * 100) / mean, rel=0.02)

    @pytest.mark.parametrize("bright", [0.002, 0.05, 0.5])
    def test_highlight_priority_lets_one_percent_clip(self, bright):
        sensor = Sensor(metering="highlight-priority", min_exposure_s=1e-9, max_exposure_s=10.0)
        luminance = np.random.default_rng(3).uniform(1.0, 50.0, (240, 320, 3)).astype(np.float32)
        luminance[np.random.default_rng(4).random((240, 320)) < bright] *= 1000.0
        electrons = mean_electrons(sensor, luminance, meter(sensor, luminance, WHITE).seconds)
        clipped = (electrons > sensor.full_well_e * 1.00001).any(axis=-1).mean()
        assert clipped == pytest.approx(0.01, abs=0.005)

    @pytest.mark.parametrize("metering", ["average", "centre-weighted", "highlight-priority"])
    def test_dark_room_takes_the_longest_time(self, metering):
        sensor = Sensor(metering=metering)
        assert meter(sensor, flat(0.0), WHITE).seconds == sensor.max_exposure_s

    def test_bracket_is_in_stops_of_two(self):
        sensor = Sensor()
        metered = meter(sensor, flat(500.0), WHITE)
        times = [shifted(sensor, metered, ev).seconds / metered.seconds for ev in (-2, 0, 1, 20)]
        np.testing.assert_allclose(times, [0.25, 1.0, 2.0, sensor.max_exposure_s / metered.seconds])

    def test_bracket_by_no_number(self):
        with pytest.raises(RendererError, match="stops"):
            shifted(Sensor(), Exposure(0.01, WHITE), float("nan"))

    def test_bracket_about_a_time_set_beyond_the_meters_limits(self):
        sensor = Sensor(exposure_s=2.0, max_exposure_s=0.1)
        metered = meter(sensor, flat(500.0), WHITE)
        assert [shifted(sensor, metered, ev).seconds for ev in (-1, 0, 1)] == [1.0, 2.0, 2.0]

    def test_fixed_exposure_is_kept(self):
        assert meter(Sensor(exposure_s=0.003), flat(1e6), WHITE).seconds == 0.003

    @pytest.mark.parametrize("white", [(1.0, 1.0, 1.0), (1.6, 0.9, 0.4), (0.9, 1.0, 1.3)])
    def test_grey_card_is_grey(self, white):
        sensor = Sensor(bit_depth=16, black_level_dn=0)
        white = np.array(white)
        luminance = (flat(100.0) * white).astype(np.float32)
        exposure = meter(sensor, luminance, white)
        picture = develop(
            sensor, digitise(sensor, mean_electrons(sensor, luminance, exposure.seconds)), exposure
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
        {"metering": "spot"},
        {"prnu": 2.0},
        {"dsnu_e": -1.0},
        {"dark_current_e_per_s": float("nan")},
        {"doubling_temperature_k": 0.0},
        {"temperature_c": 400.0},
        {"serial_number": -1},
    ],
    ids=str,
)
def test_impossible_sensors(bad):
    with pytest.raises(RendererError, match="sensor: "):
        Sensor(**bad)
