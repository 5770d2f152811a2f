"""Mosaics by the letters of their cell."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.colour_filter_array import CELLS, behind_filters


@pytest.mark.parametrize("array", ["RGGB", "BGGR", "GRBG", "GBRG"])
@pytest.mark.parametrize("shape", [(4, 6), (5, 7)])
def test_each_site_sees_the_colour_of_its_letter(array, shape):
    planes = np.random.default_rng(0).random((*shape, 3)).astype(np.float32)
    mosaic = behind_filters(array, planes)
    for v in range(shape[0]):
        for u in range(shape[1]):
            letter = array[2 * (v % 2) + u % 2]
            assert mosaic[v, u] == planes[v, u, "RGB".index(letter)]
    assert mosaic.shape == shape and mosaic.dtype == np.float32


def test_without_an_array_every_pixel_keeps_its_three_channels():
    planes = np.ones((3, 4, 3), np.float32)
    assert behind_filters("none", planes) is planes


def test_half_of_the_sites_are_green_and_stand_on_a_diagonal():
    for cell in CELLS.values():
        assert sorted(cell) == [0, 1, 1, 2]
        assert cell[0] == cell[3] == 1 or cell[1] == cell[2] == 1
