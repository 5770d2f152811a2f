"""Demosaicing: the two colours that each photosite of a Bayer mosaic lacks, from its neighbours.

All methods take a linear mosaic whose white balance is done, so that grey is flat across the sites, and
keep what was measured. At the picture's border the mosaic is mirrored about its outermost sites.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from renderers.colour_filter_array import CELLS, sites
from renderers.errors import RendererError
from renderers.gbuffer import F32

GREEN = 1

Method = Callable[[F32, str], F32]
Rows = list[list[float]]
M = TypeVar("M", bound=Method)

_methods: dict[str, Method] = {}


def register(name: str) -> Callable[[M], M]:
    """Function decorator: make a method known under ``name``."""

    def add(method: M) -> M:
        if name in _methods:
            raise RendererError(f"demosaicing {name!r} is registered twice")
        _methods[name] = method
        return method

    return add


def methods() -> Mapping[str, Method]:
    """All methods by name."""
    return MappingProxyType(_methods)


def demosaic(method: str, mosaic: F32, array: str) -> F32:
    """Complete a mosaic to three planes.

    Parameters
    ----------
    method : str
        A name of `methods`.
    mosaic : (H, W) float32
        Linear, white balanced, about 0…1; at least 3 × 3.
    array : str
        A Bayer array of `renderers.colour_filter_array.CELLS`.

    Returns
    -------
    (H, W, 3) float32
    """
    return _methods[method](mosaic, array)


@dataclass(frozen=True, eq=False)
class Kernels:
    """Linear filters for what a site lacks.

    Attributes
    ----------
    green : (n, n) float32
        Green at red and blue sites.
    along, across : (n, n) float32
        A colour at a green site whose neighbours of that colour stand left and right, above and below.
    diagonal : (n, n) float32
        Red at blue sites, blue at red ones.
    """

    green: F32
    along: F32
    across: F32
    diagonal: F32


def _kernels(divisor: float, green: Rows, along: Rows, diagonal: Rows) -> Kernels:
    g, a, d = (np.array(k, dtype=np.float32) / np.float32(divisor) for k in (green, along, diagonal))
    return Kernels(g, a, np.ascontiguousarray(a.T), d)


BILINEAR = _kernels(
    4,
    [[0, 1, 0], [1, 0, 1], [0, 1, 0]],
    [[0, 0, 0], [2, 0, 2], [0, 0, 0]],
    [[1, 0, 1], [0, 0, 0], [1, 0, 1]],
)

MALVAR = _kernels(
    16,
    [[0, 0, -2, 0, 0], [0, 0, 4, 0, 0], [-2, 4, 8, 4, -2], [0, 0, 4, 0, 0], [0, 0, -2, 0, 0]],
    [[0, 0, 1, 0, 0], [0, -2, 0, -2, 0], [-2, 8, 10, 8, -2], [0, -2, 0, -2, 0], [0, 0, 1, 0, 0]],
    [[0, 0, -3, 0, 0], [0, 4, 0, 4, 0], [-3, 0, 12, 0, -3], [0, 4, 0, 4, 0], [0, 0, -3, 0, 0]],
)
"""Malvar, He & Cutler (2004), fig. 2, twice the numbers printed there."""


@register("bilinear")
def bilinear(mosaic: F32, array: str) -> F32:
    """The mean of the nearest sites of each colour."""
    return _filtered(BILINEAR, mosaic, array)


@register("malvar")
def malvar(mosaic: F32, array: str) -> F32:
    """Bilinear, corrected by the Laplacian of the colour measured there (Malvar, He & Cutler 2004)."""
    return _filtered(MALVAR, mosaic, array)


def _filtered(kernels: Kernels, mosaic: F32, array: str) -> F32:
    def by(kernel: F32) -> NDArray[np.float32]:
        return np.asarray(cv2.filter2D(mosaic, -1, kernel, borderType=cv2.BORDER_REFLECT_101))

    green, along, across, diagonal = (
        by(k) for k in (kernels.green, kernels.along, kernels.across, kernels.diagonal)
    )
    planes = np.empty((*mosaic.shape, 3), np.float32)
    cell = CELLS[array]
    for k, (where, channel) in enumerate(sites(array)):
        planes[(*where, channel)] = mosaic[where]
        beside, below = cell[k ^ 1], cell[k ^ 2]
        if channel == GREEN:
            planes[(*where, beside)] = along[where]
            planes[(*where, below)] = across[where]
        else:
            planes[(*where, GREEN)] = green[where]
            planes[(*where, cell[k ^ 3])] = diagonal[where]
    return planes


FOOT = 0.25
"""What is lifted above zero for OpenCV's whole numbers: noise below black, as a share of white."""


@register("edge-aware")
def edge_aware(mosaic: F32, array: str) -> F32:
    """OpenCV's: green along the weaker gradient, red and blue bilinear; in steps of 2e-5 of white."""
    steps = np.float32(65535 / (1 + FOOT))
    whole = np.clip(np.rint((mosaic + np.float32(FOOT)) * steps), 0, 65535).astype(np.uint16)
    planes = cv2.demosaicing(whole, getattr(cv2, f"COLOR_Bayer{array}2RGB_EA"))
    return np.asarray(planes.astype(np.float32) / steps - np.float32(FOOT))
