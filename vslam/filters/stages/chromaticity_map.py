"""Λmax of each pixel: for eq. 3-5, filled into the mask from the highlight-free neighbourhood.

Normalised convolution (Knutsson & Westin 1993) of σ = max_c I_c / Σ_c I_c over position *and hue*, on the
bilateral grid of Chen, Paris & Durand 2007, with the gaps filled from coarser and coarser grids
(pull-push, Gortler et al. 1996). White light adds the same to each channel, so it leaves the differences
between channels and hence the hue of a surface as they are: pixels of one hue close to each other are
taken for one surface, whether a highlight lies on them or not.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vslam.filters.stages.specular_to_diffuse import DARKEST, GREY
from vslam.filters.stages.srgb import DECODED

# pixels; a highlight-free pixel is at least half a patch (7 at the default) from any masked one
CELL = 8
HUES = 12  # of 30°: primary, secondary and tertiary colours

SPREADS = 3.0  # standard deviations; a mask holds thousands of pixels, so a 5 % level would show as speckle

# What a grid cell sums over its pixels, T = Σ_c I_c: T (σ − 1/3), T (σ − 1/3)², T, 1
_EXCESS, _SQUARE, _TOTAL, _COUNT = 0, 1, 2, 3


def chromaticity_map(
    image: NDArray[np.uint8], mask: NDArray[np.bool_], highlight_free: NDArray[np.bool_]
) -> NDArray[np.float32]:
    """Λmax of the masked pixels.

    Each is Σ_y max_c I_c(y) / Σ_y Σ_c I_c(y) over the highlight-free pixels y of its hue around it: a
    mean of σ weighted by brightness, as the noise of σ asks for. Too dark and clipped pixels do not serve
    (as in ``picture_chromaticity``).

    A highlight lowers the σ of a surface. A pixel whose σ is not lower than this mean by ``SPREADS``
    standard deviations of σ in the same neighbourhood shows no highlight: its Λmax is NaN. Without this,
    eq. 3-5 multiplies the noise of pale walls by up to 34.

    Known limits: gloss too weak for the mask lowers σ around a highlight, so Λmax comes out low and the
    repair stops short of the diffuse colour. And where the mask covers all of a surface, Λmax comes from
    others of its hue: a pale wall is then taken for a highlight on the darker floor.

    A masked pixel that is itself grey has no hue: it may be white paint or nothing but highlight, and eq.
    3-5 cannot tell the two apart. Its Λmax is NaN too, and so is that of a pixel whose hue occurs nowhere
    among the highlight-free ones.

    Parameters
    ----------
    image : (H, W, 3) uint8
        sRGB, C-contiguous.
    mask : (H, W) bool
        The pixels to fill.
    highlight_free : (H, W) bool
        The pixels to fill from.

    Returns
    -------
    (H, W) float32
        Λmax, 1/3…1; NaN outside the mask and where it is unknown.
    """
    levels = [_splat(image, highlight_free, DECODED, GREY, DARKEST)]
    while max(levels[-1].shape[:2]) > 1:
        levels.append(_pull(levels[-1]))
    for coarse, fine in zip(levels[:0:-1], levels[-2::-1], strict=True):
        _push(coarse, fine)
    filled: NDArray[np.float32] = _slice(levels[0], image, mask, DECODED, GREY, SPREADS)
    return filled


@njit("float64(float64, float64, float64)", cache=True)
def _hue(red, green, blue):  # type: ignore[no-untyped-def]
    """Hexcone hue (Smith 1978) in bins, 0…HUES, of a colour that is not grey."""
    brightest = max(red, green, blue)
    chroma = brightest - min(red, green, blue)
    if brightest == red:
        sixth = (green - blue) / chroma
    elif brightest == green:
        sixth = 2.0 + (blue - red) / chroma
    else:
        sixth = 4.0 + (red - green) / chroma
    return (sixth % 6.0) * (HUES / 6.0)


@njit("float32[:, :, :, ::1](uint8[:, :, ::1], boolean[:, ::1], float32[::1], float64, int64)", cache=True)
def _splat(image, highlight_free, decoded, grey_limit, darkest):  # type: ignore[no-untyped-def]
    """Sum the highlight-free pixels into cells of (row, column, hue).

    Noise gives a grey surface any hue, so grey pixels are shared out evenly over the hues.
    """
    height, width = highlight_free.shape
    rows, columns = (height + CELL - 1) // CELL, (width + CELL - 1) // CELL
    grid = np.zeros((rows, columns, HUES, 4), dtype=np.float32)
    grey = np.zeros((rows, columns, 4), dtype=np.float32)
    for row in range(height):
        for column in range(width):
            if not highlight_free[row, column]:
                continue
            codes = image[row, column]
            brightest = max(codes[0], codes[1], codes[2])
            if brightest < darkest or brightest == 255:
                continue
            red, green, blue = decoded[codes[0]], decoded[codes[1]], decoded[codes[2]]
            total = red + green + blue
            cell = grey[row // CELL, column // CELL]
            if decoded[brightest] > grey_limit * total:
                cell = grid[row // CELL, column // CELL, int(_hue(red, green, blue)) % HUES]
            excess = decoded[brightest] - total / np.float32(3.0)
            cell[_EXCESS] += excess
            cell[_SQUARE] += excess * excess / total
            cell[_TOTAL] += total
            cell[_COUNT] += 1.0
    for hue in range(HUES):
        grid[:, :, hue] += grey / np.float32(HUES)
    return grid


@njit("float32[:, :, :, ::1](float32[:, :, :, ::1])", cache=True)
def _pull(fine):  # type: ignore[no-untyped-def]
    """Make the grid with cells twice as wide."""
    rows, columns = fine.shape[0], fine.shape[1]
    coarse = np.zeros(((rows + 1) // 2, (columns + 1) // 2, HUES, 4), dtype=np.float32)
    for row in range(rows):
        for column in range(columns):
            coarse[row // 2, column // 2] += fine[row, column]
    return coarse


@njit("void(float32[:, :, :, ::1], float32[:, :, :, ::1])", cache=True)
def _push(coarse, fine):  # type: ignore[no-untyped-def]
    """Add the mean pixel of the coarser cells around each cell: it decides where there is no other.

    Linear between the four nearest coarser cells (weights 9, 3, 3, 1 of 16), so that no cell border shows.
    """
    rows, columns = coarse.shape[0], coarse.shape[1]
    for row in range(fine.shape[0]):
        for column in range(fine.shape[1]):
            for dy in range(2):
                y = min(max(row // 2 + dy * (2 * (row % 2) - 1), 0), rows - 1)
                for dx in range(2):
                    x = min(max(column // 2 + dx * (2 * (column % 2) - 1), 0), columns - 1)
                    weight = (0.25 if dy else 0.75) * (0.25 if dx else 0.75)
                    for hue in range(HUES):
                        wider = coarse[y, x, hue]
                        if wider[_COUNT] > 0.0:
                            share = weight / wider[_COUNT]
                            for k in range(4):
                                fine[row, column, hue, k] += share * wider[k]


@njit(
    "float32[:, ::1](float32[:, :, :, ::1], uint8[:, :, ::1], boolean[:, ::1],"
    " float32[::1], float64, float64)",
    cache=True,
)
def _slice(grid, image, mask, decoded, grey_limit, spreads):  # type: ignore[no-untyped-def]
    """Read the grid at each masked pixel, linear between the eight cells around its row, column and hue."""
    height, width = mask.shape
    rows, columns = grid.shape[0], grid.shape[1]
    filled = np.full((height, width), np.nan, dtype=np.float32)
    for row in range(height):
        y = (row + 0.5) / CELL - 0.5
        y0 = int(np.floor(y))
        for column in range(width):
            if not mask[row, column]:
                continue
            codes = image[row, column]
            red, green, blue = decoded[codes[0]], decoded[codes[1]], decoded[codes[2]]
            total = red + green + blue
            if not max(red, green, blue) > grey_limit * total:
                continue
            x = (column + 0.5) / CELL - 0.5
            x0 = int(np.floor(x))
            z = _hue(red, green, blue) - 0.5
            z0 = int(np.floor(z))
            excess, square, total_sum = 0.0, 0.0, 0.0
            for dy in range(2):
                cell_row = min(max(y0 + dy, 0), rows - 1)
                weight_y = 1.0 - abs(y - (y0 + dy))
                for dx in range(2):
                    cell_column = min(max(x0 + dx, 0), columns - 1)
                    weight_yx = weight_y * (1.0 - abs(x - (x0 + dx)))
                    for dz in range(2):
                        weight = weight_yx * (1.0 - abs(z - (z0 + dz)))
                        cell = grid[cell_row, cell_column, (z0 + dz) % HUES]
                        excess += weight * cell[_EXCESS]
                        square += weight * cell[_SQUARE]
                        total_sum += weight * cell[_TOTAL]
            if total_sum == 0.0:
                continue
            mean = excess / total_sum
            spread = np.sqrt(max(square / total_sum - mean * mean, 0.0))
            lambda_max = 1.0 / 3.0 + mean
            if lambda_max - max(red, green, blue) / total > spreads * spread:
                filled[row, column] = lambda_max
    return filled
