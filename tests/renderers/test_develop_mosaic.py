"""Clipped light behind a mosaic: white stays without colour at its edges too."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.colour_filter_array import behind_filters
from renderers.demosaicing import demosaic
from renderers.develop import _codes, _correct, develop, encode
from renderers.metering import Exposure
from renderers.sensor import Sensor

BALANCE = np.array([1.0, 1.4, 2.5])


@pytest.mark.parametrize("method", ["bilinear", "malvar", "edge-aware"])
def test_edge_of_a_clipped_lamp_is_that_of_white_on_grey(method):
    """Grey of 10 % under warm light beside numbers that all clip: balanced, a mosaic of 0.1 and 1 without
    colour. Balanced without a clip, the lamp's blue would be 2.5 and spill over its edge."""
    sensor = Sensor(bit_depth=16, colour_filter_array="RGGB", demosaicing=method)
    lit = np.arange(20) >= 9
    planes = np.where(lit[:, None], 1.0, 0.1 / BALANCE) * np.ones((16, 1, 1))
    raw = 16 + np.rint(behind_filters("RGGB", planes) * (65_535 - 16)).astype(np.uint16)
    grey = np.where(lit, 1.0, 0.1).astype(np.float32) * np.ones((16, 1), np.float32)
    expected = encode(demosaic(method, grey, "RGGB").astype(float))
    found = develop(sensor, raw, Exposure(1.0, BALANCE))
    assert np.abs(found.astype(int) - expected).max() <= 1


def test_what_overshoots_white_gains_no_colour():
    """1.2 of red would leave 0.97 of green by the Nikon's matrix; a dark pixel keeps its negative red."""
    matrix = np.float32([[1.8, -0.7, -0.1], [-0.2, 1.6, -0.4], [0.1, -0.6, 1.5]])
    planes = np.float32([[1.2, 1.0, 1.0], [1.5, 1.3, 1.1], [-0.1, 0.1, 0.1]])
    out = np.empty((3, 3), np.uint8)
    _correct(planes, matrix, _codes(), out)
    assert (out[:2] == 255).all()
    np.testing.assert_array_equal(out[2], encode(np.array([0.0, 0.14, 0.08])))


def test_table_of_codes_is_the_curve_to_a_step_of_it():
    light = np.random.default_rng(0).random(100_000)
    looked_up = _codes()[np.rint(light * 65_535).astype(int)]
    exact = encode(light)
    assert np.abs(looked_up.astype(int) - exact).max() <= 1
    assert (looked_up != exact).mean() < 0.005
