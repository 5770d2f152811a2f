"""Demosaicing of mosaics whose colours are known, and against the papers' formulas and OpenCV."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from renderers.colour_filter_array import CELLS, behind_filters
from renderers.demosaicing import demosaic, methods, register
from renderers.errors import RendererError

ARRAYS = sorted(CELLS)
METHODS = ["bilinear", "malvar", "edge-aware"]
STEP = {"bilinear": 1e-6, "malvar": 1e-6, "edge-aware": 4e-5}  # OpenCV's has 16 bits
INSIDE = np.s_[2:-2, 2:-2]


def test_names():
    assert sorted(methods()) == sorted(METHODS)
    with pytest.raises(RendererError, match="twice"):
        register("malvar")(lambda mosaic, array: mosaic)


@pytest.mark.parametrize("method", METHODS)
@given(
    colour=st.tuples(*[st.floats(-0.1, 1.0)] * 3),
    array=st.sampled_from(ARRAYS),
    height=st.integers(5, 8),
    width=st.integers(5, 8),
)
def test_one_colour_stays_that_colour_up_to_the_border(method, colour, array, height, width):
    planes = np.broadcast_to(np.float32(colour), (height, width, 3))
    found = demosaic(method, behind_filters(array, planes), array)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, planes, atol=STEP[method])


@pytest.mark.parametrize("method", METHODS)
@given(
    slopes=st.lists(st.floats(-0.01, 0.01), min_size=6, max_size=6),
    level=st.tuples(*[st.floats(0.3, 0.7)] * 3),
    array=st.sampled_from(ARRAYS),
)
def test_linear_ramps_are_exact_inside(method, slopes, level, array):
    """Each channel its own plane: a swapped channel, or one that is off by a pixel, shows."""
    v, u = np.mgrid[0:15, 0:18]
    along, down = np.reshape(slopes, (2, 3))
    planes = (np.float32(level) + u[..., None] * along + v[..., None] * down).astype(np.float32)
    found = demosaic(method, behind_filters(array, planes), array)
    np.testing.assert_allclose(found[INSIDE], planes[INSIDE], atol=STEP[method])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("array", ARRAYS)
def test_what_was_measured_is_kept(method, array):
    mosaic = np.random.default_rng(1).random((20, 24)).astype(np.float32)
    found = demosaic(method, mosaic, array)
    np.testing.assert_allclose(behind_filters(array, found)[INSIDE], mosaic[INSIDE], atol=STEP[method])


@pytest.mark.parametrize("array", ARRAYS)
def test_malvar_is_bilinear_plus_the_measured_colours_laplacian(array):
    """Equations 3 to 5 of the paper, with α = 1/2, β = 5/8, γ = 3/4, pixel by pixel.

    At green sites the paper's correction takes the green neighbours of its 9-point region: the four
    diagonal ones and the two along the interpolated colour at full weight, the two across at −1/2.
    """
    m = np.random.default_rng(2).random((13, 14)).astype(np.float32).astype(float)
    found = demosaic("malvar", m.astype(np.float32), array)
    simple = demosaic("bilinear", m.astype(np.float32), array)
    letter = {"R": 0, "G": 1, "B": 2}
    for v in range(2, 11):
        for u in range(2, 12):
            here = letter[array[2 * (v % 2) + u % 2]]
            beside = letter[array[2 * (v % 2) + (u + 1) % 2]]
            cross = m[v - 2, u] + m[v + 2, u] + m[v, u - 2] + m[v, u + 2]
            if here != 1:
                laplacian = m[v, u] - cross / 4
                correction = {1: laplacian / 2, 2 - here: 3 / 4 * laplacian}
            else:
                diagonal = sum(m[v + i, u + j] for i in (-1, 1) for j in (-1, 1))
                rows, columns = m[v, u - 2] + m[v, u + 2], m[v - 2, u] + m[v + 2, u]
                along = 5 / 8 * (m[v, u] - (diagonal + rows - columns / 2) / 5)
                across = 5 / 8 * (m[v, u] - (diagonal + columns - rows / 2) / 5)
                correction = {beside: along, 2 - beside: across}
            for channel, add in correction.items():
                assert found[v, u, channel] == pytest.approx(simple[v, u, channel] + add, abs=1e-5)


OPENCV = {  # OpenCV names a cell by its pixel (1, 1), and by BGR's order
    "RGGB": cv2.COLOR_BayerBG2RGB,
    "BGGR": cv2.COLOR_BayerRG2RGB,
    "GRBG": cv2.COLOR_BayerGB2RGB,
    "GBRG": cv2.COLOR_BayerGR2RGB,
}


@pytest.mark.parametrize("array", ARRAYS)
def test_bilinear_is_opencvs(array):
    mosaic = np.random.default_rng(3).integers(0, 65536, (20, 22)).astype(np.uint16)
    found = demosaic("bilinear", mosaic.astype(np.float32), array)
    np.testing.assert_allclose(
        found[INSIDE], cv2.demosaicing(mosaic, OPENCV[array])[INSIDE].astype(float), atol=1.01
    )


@pytest.mark.parametrize("array", ARRAYS)
@pytest.mark.parametrize("upright", [True, False])
def test_edge_aware_has_no_zipper_in_green_along_an_edge(array, upright):
    """A grey edge between two columns or rows: the mean across it flickers from site to site."""
    planes = np.full((16, 16, 3), 0.1, np.float32)
    planes[:, 8:] = 0.8
    planes = planes if upright else np.ascontiguousarray(planes.transpose(1, 0, 2))
    error = {
        method: np.abs(demosaic(method, behind_filters(array, planes), array) - planes)[INSIDE][..., 1].max()
        for method in METHODS
    }
    assert error["edge-aware"] < 1e-4
    assert error["bilinear"] > 0.1


def test_noise_below_black_survives():
    """No method may lift the mean of darkness by cutting its negative numbers."""
    mosaic = (0.02 * np.random.default_rng(4).standard_normal((200, 200))).astype(np.float32)
    for method in METHODS:
        planes = demosaic(method, mosaic, "RGGB")
        assert np.abs(planes.reshape(-1, 3).mean(axis=0)).max() < 4.5 * 0.02 / 100
