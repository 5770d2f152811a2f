"""An 18 % grey card in the sun, from lux to digital numbers, by arithmetic of its own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import constants

from renderers.basis import relight
from renderers.camera import Pinhole
from renderers.sensor import PHOTONS_PER_LUX, Sensor, mean_electrons
from renderers.truth import record
from scenes.model import Material, Sun

SUN_LUX, REFLECTANCE = 97_000.0, 0.18


@pytest.fixture(scope="module")
def photons_per_lux():
    """Photons of 400–700 nm per lm·s of D65, from the CIE's tables and the lumen's definition."""
    import colour

    shape = colour.SpectralShape(400, 700, 1)
    spectrum = colour.SDS_ILLUMINANTS["D65"].copy().interpolate(shape).values
    luminosity = colour.SDS_LEFS["CIE 1924 Photopic Standard Observer"].copy().align(shape).values
    wavelength = np.arange(400, 701) * 1e-9
    photons = (spectrum * wavelength / (constants.h * constants.c)).sum()
    return photons / (683.002 * (spectrum * luminosity).sum())


def test_photons_per_lux_is_that_of_the_cies_tables(photons_per_lux):
    assert pytest.approx(photons_per_lux, rel=0.005) == PHOTONS_PER_LUX


def electrons_on_paper(sensor, seconds, photons_per_lux):
    """E = π T L / (4 N²), L = ρ E_sun / π; times time, area, photons per lux, quantum efficiency."""
    luminance = REFLECTANCE * SUN_LUX / np.pi
    lux = np.pi * sensor.lens_transmission * luminance / (4 * sensor.f_number**2)
    return (
        lux
        * seconds
        * (sensor.pixel_pitch_um * 1e-6) ** 2
        * photons_per_lux
        * np.array(sensor.quantum_efficiency)
    )


@pytest.mark.parametrize("f_number", [2.0, 8.0])
def test_electrons_of_the_card(photons_per_lux, f_number):
    sensor, seconds = Sensor(f_number=f_number, lens_transmission=0.85), 1 / 1000
    luminance = np.full((1, 1, 3), REFLECTANCE * SUN_LUX / np.pi, np.float32)
    found = mean_electrons(sensor, luminance, seconds)[0, 0]
    np.testing.assert_allclose(found, electrons_on_paper(sensor, seconds, photons_per_lux), rtol=0.005)


@pytest.mark.parametrize("array", ["none", "RGGB"])
@pytest.mark.parametrize("gain_db", [0.0, 6.0])
def test_card_under_a_vertical_sun_from_renderer_to_digital_numbers(
    renderer_of, scene_of, floor, downwards, photons_per_lux, array, gain_db
):
    """A Lambertian plane at normal incidence of 97 klx of D65 light, seen from 3 m straight above."""
    card = floor(2.0, Material((REFLECTANCE,) * 3, roughness=1.0, specular=0.0))
    scene = scene_of(card, sun=Sun(azimuth_deg=0.0, elevation_deg=90.0, lux=SUN_LUX, illuminant="D65"))
    basis = renderer_of(scene, Pinhole(48, 36, 40.0), downwards).render(np.zeros(3))
    intensity = {name: SUN_LUX * (name == "sun") for name in basis.layers}
    diffuse, specular = relight(basis, intensity, dict.fromkeys(basis.layers, np.ones(3)))
    assert not specular.any()
    sensor = Sensor(f_number=8.0, exposure_s=5e-4, bit_depth=12, colour_filter_array=array, gain_db=gain_db)
    shot = record(sensor, diffuse, specular, np.ones(3), np.random.default_rng(0))
    electrons = electrons_on_paper(sensor, 5e-4, photons_per_lux)
    assert electrons.max() < 0.9 * 20_000 / 10 ** (gain_db / 20)
    expected = 16 + (4095 - 16) / 20_000 * 10 ** (gain_db / 20) * electrons
    raw = shot.raw.astype(float)
    if array == "none":
        found = raw.reshape(-1, 3).mean(axis=0)
    else:
        found = [
            raw[::2, ::2].mean(),
            (raw[::2, 1::2].mean() + raw[1::2, ::2].mean()) / 2,
            raw[1::2, 1::2].mean(),
        ]
    np.testing.assert_allclose(found, expected, rtol=0.01)
