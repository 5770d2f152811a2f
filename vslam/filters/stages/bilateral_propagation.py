"""Λmax of each pixel by bilateral propagation (Yang, Wang & Ahuja 2010, "Real-time specular highlight removal
using bilateral filtering", ECCV).

White light lowers the maximum chromaticity σ = max_c I_c / Σ_c I_c of a surface, so the diffuse one is the
largest σ of the surface. A joint bilateral filter carries large values into highlights, guided by what light
leaves as it is: the chromaticity that a pixel would have without any white in it.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vslam.filters.stages.specular_to_diffuse import specular_part

PASSES = 2
"""At most. One ends short of the middle of large highlights; more carry the noise of σ over whole surfaces
(spheres of known diffuse colour, tests/vslam/test_filter_separation.py)."""
SPATIAL_SHARE = 0.25  # σ_s over the shorter side of the picture; the paper's section 3.2
RANGE = 0.04  # σ_r, the paper's section 3.2
CHANGE = 0.03  # less than this no pass adds to any pixel: the propagation has ended; the paper's algorithm 1

_LOWEST = 1.0 / 3.0
_MARGIN = 2  # cells around the grid: the smoothing reaches one, linear interpolation another
_FORM = "Array(float32, 3, 'C', readonly=True)"


def propagated_chromaticity(linear: NDArray[np.float32], passes: int = PASSES) -> NDArray[np.float32]:
    """Λmax of each pixel.

    σ and the guide, λ_max = max_c λ_c with λ_c = (σ_c − σ_min) / (1 − 3 σ_min) (the paper's eq. 10 for white
    light), are read from the picture. Each pass sets σ ← max(σ, F(σ)), with F the joint bilateral filter
    under the guide λ_max (algorithm 1). The filter runs on a bilateral grid (Chen, Paris & Durand 2007) with
    cells of one standard deviation.

    Parameters
    ----------
    linear : (H, W, 3) float32
        Linear light, white-balanced.
    passes : int
        At most so many; as in the paper, the propagation also ends before a pass that would change nothing by
        more than 0.03. In noisy pictures that never happens, and the number of passes decides.

    Returns
    -------
    (H, W) float32
        1/3…1; 0 where the picture is black.
    """
    linear = np.ascontiguousarray(linear)
    sigma, guide = _chromaticities(linear)
    spread = max(SPATIAL_SHARE * min(sigma.shape), 1.0)
    for _ in range(passes):
        grid = _splat(sigma, guide, spread, RANGE)
        for axis in range(3):
            grid = _smoothed(grid, axis)
        raised, change = _raised(sigma, guide, grid, spread, RANGE)
        if change <= CHANGE:
            break
        sigma = raised
    return np.asarray(sigma, dtype=np.float32)


def with_chromaticity(linear: NDArray[np.float32], lambda_max: NDArray[np.float32]) -> NDArray[np.float32]:
    """Eq. 3-5, the paper's eq. 5, with a Λmax for each pixel.

    Parameters
    ----------
    linear : (H, W, 3) float32
    lambda_max : (H, W) float32
        A pixel whose Λmax is grey or unknown stays as it is.

    Returns
    -------
    (H, W, 3) float32
        The diffuse part, 0 … ``linear``.
    """
    diffuse: NDArray[np.float32] = _with_chromaticity(np.ascontiguousarray(linear), lambda_max)
    return diffuse


@njit(f"Tuple((float32[:, ::1], float32[:, ::1]))({_FORM})", cache=True)
def _chromaticities(linear):  # type: ignore[no-untyped-def]
    height, width = linear.shape[:2]
    sigma = np.zeros((height, width), dtype=np.float32)
    guide = np.full((height, width), _LOWEST, dtype=np.float32)
    for row in range(height):
        for column in range(width):
            red, green, blue = linear[row, column, 0], linear[row, column, 1], linear[row, column, 2]
            total = red + green + blue
            largest, smallest = max(red, green, blue), min(red, green, blue)
            if total > 0.0:
                sigma[row, column] = largest / total
            if largest > smallest:
                guide[row, column] = (largest - smallest) / (total - np.float32(3.0) * smallest)
    return sigma, guide


@njit("float32[:, :, :, ::1](float32[:, ::1], float32[:, ::1], float64, float64)", cache=True)
def _splat(sigma, guide, spread, reach):  # type: ignore[no-untyped-def]
    """Sum σ and counts into the nearest cells of (row, column, guide); black pixels say nothing."""
    height, width = sigma.shape
    rows = int((height - 1) / spread + 0.5) + 1 + 2 * _MARGIN
    columns = int((width - 1) / spread + 0.5) + 1 + 2 * _MARGIN
    grid = np.zeros(
        (rows, columns, int((1.0 - _LOWEST) / reach + 0.5) + 1 + 2 * _MARGIN, 2), dtype=np.float32
    )
    for row in range(height):
        y = int(row / spread + 0.5) + _MARGIN
        for column in range(width):
            if sigma[row, column] > 0.0:
                x = int(column / spread + 0.5) + _MARGIN
                z = int((guide[row, column] - _LOWEST) / reach + 0.5) + _MARGIN
                grid[y, x, z, 0] += sigma[row, column]
                grid[y, x, z, 1] += np.float32(1.0)
    return grid


@njit("float32[:, :, :, ::1](float32[:, :, :, ::1], int64)", cache=True)
def _smoothed(grid, axis):  # type: ignore[no-untyped-def]
    """Convolve with a Gaussian of one cell along an axis, cut after two cells."""
    weights = np.exp(-0.5 * np.arange(3) ** 2).astype(np.float32)
    out = np.zeros_like(grid)
    size = grid.shape[axis]
    for a in range(grid.shape[0]):
        for b in range(grid.shape[1]):
            for c in range(grid.shape[2]):
                place = (a, b, c)[axis]
                for step in range(-2, 3):
                    if 0 <= place + step < size:
                        weight = weights[abs(step)]
                        i = a + step if axis == 0 else a
                        j = b + step if axis == 1 else b
                        k = c + step if axis == 2 else c
                        out[a, b, c, 0] += weight * grid[i, j, k, 0]
                        out[a, b, c, 1] += weight * grid[i, j, k, 1]
    return out


@njit(
    "Tuple((float32[:, ::1], float32))"
    "(float32[:, ::1], float32[:, ::1], float32[:, :, :, ::1], float64, float64)",
    cache=True,
)
def _raised(sigma, guide, grid, spread, reach):  # type: ignore[no-untyped-def]
    """max(σ, F(σ)), with F read linearly between eight cells, and the largest change."""
    height, width = sigma.shape
    raised = sigma.copy()
    largest = np.float32(0.0)
    columns = np.empty(width, dtype=np.int64)
    shares = np.empty(width, dtype=np.float32)
    for column in range(width):
        x = column / spread + _MARGIN
        columns[column] = int(x)
        shares[column] = x - int(x)
    scale, lowest = np.float32(1.0 / reach), np.float32(_LOWEST)
    for row in range(height):
        y = row / spread + _MARGIN
        y0 = int(y)
        v = np.float32(y - y0)
        for column in range(width):
            if sigma[row, column] == 0.0:
                continue
            x0, u = columns[column], shares[column]
            z = max(guide[row, column] - lowest, np.float32(0.0)) * scale
            z0 = int(z)
            w = z - np.float32(z0)
            z0 += _MARGIN
            total, count = np.float32(0.0), np.float32(0.0)
            for dy in range(2):
                weight_y = v if dy else np.float32(1.0) - v
                for dx in range(2):
                    weight = weight_y * (u if dx else np.float32(1.0) - u)
                    near, far = grid[y0 + dy, x0 + dx, z0], grid[y0 + dy, x0 + dx, z0 + 1]
                    total += weight * (near[0] + w * (far[0] - near[0]))
                    count += weight * (near[1] + w * (far[1] - near[1]))
            if count > 0.0:
                change = total / count - sigma[row, column]
                if change > 0.0:
                    raised[row, column] += change
                    largest = max(largest, change)
    return raised, largest


@njit(f"float32[:, :, ::1]({_FORM}, float32[:, ::1])", cache=True)
def _with_chromaticity(linear, lambda_max):  # type: ignore[no-untyped-def]
    height, width = lambda_max.shape
    diffuse = np.empty((height, width, 3), dtype=np.float32)
    for row in range(height):
        for column in range(width):
            red, green, blue = linear[row, column, 0], linear[row, column, 1], linear[row, column, 2]
            specular = specular_part(red, green, blue, lambda_max[row, column])
            diffuse[row, column, 0] = red - specular
            diffuse[row, column, 1] = green - specular
            diffuse[row, column, 2] = blue - specular
    return diffuse
