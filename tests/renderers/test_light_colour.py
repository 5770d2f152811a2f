"""Colour temperatures against colour-science."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.errors import RendererError
from renderers.illuminant import LUMINANCE, chromaticity, linear_srgb


@pytest.mark.parametrize("kelvin", [4000.0, 5003.0, 6504.0, 7100.0, 12_000.0, 25_000.0])
def test_daylight_is_that_of_colour_science(kelvin):
    from colour.temperature import CCT_to_xy_CIE_D

    np.testing.assert_allclose(chromaticity(kelvin), CCT_to_xy_CIE_D(kelvin), atol=1e-5)


@pytest.mark.parametrize("kelvin", [1700.0, 2200.0, 2300.0, 2856.0, 3500.0, 3999.0])
def test_black_body_is_plancks_law(kelvin):
    import colour

    spectrum = colour.sd_blackbody(kelvin, colour.SpectralShape(360, 780, 1))
    XYZ = colour.sd_to_XYZ(spectrum, illuminant=colour.sd_ones(colour.SpectralShape(360, 780, 1)))
    np.testing.assert_allclose(chromaticity(kelvin), XYZ[:2] / XYZ.sum(), atol=5e-4)


def test_illuminant_a_is_a_black_body_of_2856_kelvin():
    np.testing.assert_allclose(chromaticity(2856.0), (0.44758, 0.40745), atol=1e-3)  # CIE S 014-2
    np.testing.assert_allclose(linear_srgb("2856K"), linear_srgb("A"), atol=0.01)


def test_d65_is_daylight_of_6504_kelvin_and_lux_stay_lux():
    np.testing.assert_allclose(linear_srgb("6504 K"), linear_srgb("D65"), atol=2e-3)
    for name in ("1700K", "3000K", "9000K", "25000K"):
        assert linear_srgb(name) @ LUMINANCE == pytest.approx(1.0)


@pytest.mark.parametrize("name", ["1000K", "26000K", "0K"])
def test_colour_temperature_beyond_the_formulas(name):
    with pytest.raises(RendererError, match="must lie in 1667…25000 K"):
        linear_srgb(name)
