"""What a camera's own colour filters do to linear sRGB, and the matrix that undoes it.

Scenes and lights are linear sRGB, three numbers without a spectrum, so a camera's spectral sensitivities
enter as the best linear maps between the two: fitted by least squares over the 99 test colours of CIE
224:2017 under D65, 400–700 nm, each response as a share of white's, white itself exact.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

SRGB = "srgb"
"""Filters that see the sRGB primaries apart: nothing to undo."""

TwoOfThree = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]


@dataclass(frozen=True, eq=False)
class ColourMatrices:
    """The two maps of a camera; the rows of both sum to 1, so that grey stays grey.

    Attributes
    ----------
    source : str
        Where the sensitivities are from: their name in colour-science.
    from_srgb : (3, 3) float64
        Linear sRGB to the channels' responses, as shares of their response to white.
    to_srgb : (3, 3) float64
        White-balanced responses to linear sRGB, the camera's colour correction matrix.
    """

    source: str
    from_srgb: NDArray[np.float64]
    to_srgb: NDArray[np.float64]


def _rows(first_two: TwoOfThree) -> NDArray[np.float64]:
    """(3, 3): the last column makes each row's sum 1."""
    columns = np.array(first_two)
    matrix = np.column_stack([columns, 1 - columns.sum(axis=1)])
    matrix.setflags(write=False)
    return matrix


CAMERAS: Mapping[str, ColourMatrices] = MappingProxyType(
    {
        "nikon-5100": ColourMatrices(
            "Nikon 5100 (NPL)",
            _rows(((0.5754, 0.3117), (0.0445, 0.7301), (-0.0203, 0.2898))),
            _rows(((1.7848, -0.7270), (-0.1438, 1.6236), (0.0985, -0.6438))),
        ),
        "sigma-sd-merrill": ColourMatrices(  # its channels lie one below the other and overlap widely
            "Sigma SDMerill (NPL)",
            _rows(((0.4833, 0.4235), (0.2619, 0.5545), (0.1557, 0.4885))),
            _rows(((3.6830, -3.5377), (-2.2069, 5.3807), (1.4231, -5.8849))),
        ),
    }
)
"""Cameras by name; the numbers are fitted anew from colour-science by their test."""

SENSITIVITIES = (SRGB, *CAMERAS)


def to_camera(sensitivities: str, linear_srgb: NDArray[np.floating]) -> NDArray[np.floating]:
    """Linear sRGB light as a camera's channels see it, as shares of white; never negative.

    Parameters
    ----------
    sensitivities : str
        One of `SENSITIVITIES`.
    linear_srgb : (..., 3) float32 or float64
        Kept in its type.
    """
    if sensitivities == SRGB:
        return linear_srgb
    matrix = CAMERAS[sensitivities].from_srgb.astype(linear_srgb.dtype)
    return np.maximum(linear_srgb @ matrix.T, 0)


def correction(sensitivities: str) -> NDArray[np.float64]:
    """(3, 3): white-balanced camera channels to linear sRGB."""
    return np.eye(3) if sensitivities == SRGB else CAMERAS[sensitivities].to_srgb
