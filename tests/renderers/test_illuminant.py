"""The colour of light against CIE chromaticities written out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.errors import RendererError
from renderers.illuminant import linear_srgb

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # IEC 61966-2-1


def xy_of(rgb):
    """Chromaticity of linear sRGB by the standard's own matrix."""
    matrix = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    xyz = matrix @ rgb
    return xyz[:2] / xyz.sum()


def test_d65_is_white():
    np.testing.assert_allclose(linear_srgb("D65"), 1.0, atol=1e-3)


# CIE 15:2018, 1931 observer
@pytest.mark.parametrize(
    ("name", "xy"), [("D55", (0.3324, 0.3474)), ("D75", (0.2990, 0.3149)), ("LED-B3", (0.3756, 0.3723))]
)
def test_chromaticity(name, xy):
    np.testing.assert_allclose(xy_of(linear_srgb(name)), xy, atol=1e-3)


@pytest.mark.parametrize("name", ["A", "D50", "D55", "D65", "D75", "E", "FL2", "LED-B3"])
def test_lux_stay_lux(name):
    rgb = linear_srgb(name)
    assert rgb.shape == (3,) and rgb.dtype == np.float64
    assert rgb @ LUMINANCE == pytest.approx(1.0, abs=1e-9)
    assert (rgb >= 0).all()


def test_incandescent_light_is_warm_and_the_north_sky_cold():
    red, green, blue = linear_srgb("A")
    assert red > 1.5 > green > 0.8 > 0.4 > blue
    red, green, blue = linear_srgb("D75")
    assert red < green < blue


def test_unknown_name_suggests_near_ones():
    with pytest.raises(RendererError, match=r"unknown illuminant 'D56'.*D5"):
        linear_srgb("D56")
