"""The matrices of cameras, fitted anew from colour-science's spectra."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from renderers.colour_matrix import CAMERAS, correction, to_camera
from renderers.develop import develop
from renderers.metering import meter
from renderers.sensor import Sensor, digitise, mean_electrons
from renderers.truth import record


@pytest.fixture(scope="module")
def spectra():
    """Reflectances and observers, 400–700 nm in steps of 5 nm; XYZ and Lab as colour-science has them."""
    import colour
    from colour.quality.cfi2017 import load_TCS_CIE2017

    shape = colour.SpectralShape(400, 700, 5)
    daylight = colour.SDS_ILLUMINANTS["D65"].copy().align(shape).values
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape).values
    samples = load_TCS_CIE2017(colour.SpectralShape(380, 780, 5)).align(shape).values.T
    checker = np.stack(
        [s.copy().align(shape).values for s in colour.SDS_COLOURCHECKERS["BabelColor Average"].values()]
    )
    space = colour.RGB_COLOURSPACES["sRGB"]

    def linear_srgb(reflectance):
        rgb = (reflectance * daylight) @ observer @ space.matrix_XYZ_to_RGB.T
        return rgb / (daylight @ observer @ space.matrix_XYZ_to_RGB.T)

    def seen_by(camera, reflectance):
        filters = colour.MSDS_CAMERA_SENSITIVITIES[camera].copy().align(shape).values
        return (reflectance * daylight) @ filters / (daylight @ filters)

    def difference(one, other):
        """CIEDE2000 of linear sRGB colours."""
        white = colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"]["D65"]
        lab = [colour.XYZ_to_Lab(c @ space.matrix_RGB_to_XYZ.T, white) for c in (one, other)]
        return colour.delta_E(*lab, method="CIE 2000")

    return SimpleNamespace(
        samples=samples, checker=checker, linear_srgb=linear_srgb, seen_by=seen_by, difference=difference
    )


def white_preserving(x, y):
    """The M that minimises |x Mᵀ − y| with M·1 = 1, by Lagrange's equations for each row."""
    normal = np.zeros((4, 4))
    normal[:3, :3], normal[3, :3], normal[:3, 3] = x.T @ x, 1, 1
    return np.linalg.solve(normal, np.vstack([x.T @ y, np.ones(3)]))[:3].T


@pytest.mark.parametrize("name", list(CAMERAS))
def test_both_matrices_are_the_fits_to_the_99_samples(spectra, name):
    camera = CAMERAS[name]
    light, seen = spectra.linear_srgb(spectra.samples), spectra.seen_by(camera.source, spectra.samples)
    assert len(light) == 99
    np.testing.assert_allclose(camera.from_srgb, white_preserving(light, seen), atol=1.1e-4)
    np.testing.assert_allclose(camera.to_srgb, white_preserving(seen, light), atol=1.1e-4)


@pytest.mark.parametrize(("name", "mean", "most"), [("nikon-5100", 1.2, 3.5), ("sigma-sd-merrill", 2.3, 6.5)])
def test_colours_of_the_colour_checker_from_spectra(spectra, name, mean, most):
    """The 24 patches, none of them fitted: spectra through the filters and the correction, CIEDE2000.

    Found: 1.08 on average and 3.26 at most for the Nikon (without its matrix 6.8), 2.18 and 6.21 for the
    Sigma.
    """
    camera = CAMERAS[name]
    corrected = spectra.seen_by(camera.source, spectra.checker) @ camera.to_srgb.T
    off = spectra.difference(corrected, spectra.linear_srgb(spectra.checker))
    assert off.mean() < mean and off.max() < most


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"colour_filter_array": "RGGB"},
        {"colour_filter_array": "GBRG", "demosaicing": "edge-aware"},
        {"colour_filter_array": "BGGR", "sensitivities": "nikon-5100"},
    ],
    ids=str,
)
def test_colours_of_the_colour_checker_through_the_whole_chain(spectra, options):
    """Patches of 12 × 12 pixels, photographed and read off their 8-bit middles without noise.

    Rounding to 8 bits alone is up to 0.50 (found: 0.50 and 0.20 on average, 0.23 with the Nikon's fit there
    and back).
    """
    patches = np.clip(spectra.linear_srgb(spectra.checker), 0, 1)
    luminance = patches.reshape(4, 6, 3).repeat(12, axis=0).repeat(12, axis=1).astype(np.float32)
    sensor = Sensor(bit_depth=16, quantum_efficiency=(0.4, 0.4, 0.4), **options)
    sensor = replace(sensor, exposure_s=sensor.full_well_e / sensor.electrons_per_luminance[0])
    shot = record(sensor, luminance, np.zeros_like(luminance), np.ones(3), np.random.default_rng(0))
    code = shot.full[6::12, 6::12].reshape(-1, 3) / 255
    linear = np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)
    assert spectra.difference(linear, patches).max() < 0.55


class TestCamera:
    @pytest.mark.parametrize("name", list(CAMERAS))
    def test_grey_is_grey_both_ways(self, name):
        np.testing.assert_allclose(to_camera(name, np.full((2, 3), 0.3)), 0.3)
        np.testing.assert_allclose(correction(name) @ np.full(3, 0.3), 0.3)

    def test_srgb_is_untouched(self):
        light = np.ones((1, 1, 3), np.float32)
        assert to_camera("srgb", light) is light
        np.testing.assert_array_equal(correction("srgb"), np.eye(3))

    def test_light_is_never_negative(self):
        """Pure red lies outside of what the Nikon's blue filter sees as a linear map."""
        assert to_camera("nikon-5100", np.float32([[1, 0, 0]])).min() == 0

    @pytest.mark.parametrize("name", ["srgb", *CAMERAS])
    @pytest.mark.parametrize("array", ["none", "GRBG"])
    @pytest.mark.parametrize("white", [(1.0, 1.0, 1.0), (1.6, 0.9, 0.4), (0.9, 1.0, 1.3)])
    def test_grey_card_is_grey_under_any_light(self, name, array, white):
        sensor = Sensor(bit_depth=16, sensitivities=name, colour_filter_array=array, max_exposure_s=1.0)
        luminance = np.broadcast_to(np.float32(white) * 100, (12, 12, 3))
        shot = record(sensor, luminance, np.zeros_like(luminance), np.array(white), np.random.default_rng(0))
        assert np.ptp(shot.full.astype(int), axis=-1).max() <= 1
        assert 110 < shot.full.mean() < 150

    @pytest.mark.parametrize("name", list(CAMERAS))
    @pytest.mark.parametrize("array", ["none", "RGGB"])
    def test_clipped_pixels_stay_white(self, name, array):
        white = np.array([1.6, 0.9, 0.4])
        sensor = Sensor(sensitivities=name, colour_filter_array=array)
        luminance = np.broadcast_to(np.float32(white) * 1e6, (12, 12, 3))
        exposure = meter(sensor, luminance, white)
        electrons = mean_electrons(sensor, luminance, exposure.seconds)
        raw = digitise(sensor, electrons if array == "none" else electrons[..., 1])
        assert (raw == sensor.largest_dn).all()
        assert (develop(sensor, raw, exposure) == 255).all()
