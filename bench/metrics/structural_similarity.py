"""Structural similarity of 8-bit pictures: Wang, Bovik, Sheikh & Simoncelli 2004, eq. 13.

In flat bright areas, which highlights are, E[x²] − E[x]² cancels: in float32 the index is 5e-5 off there. So
the sums are float64; a few rows at a time are in flight, and stay in the processor's cache.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

RADIUS = 5  # pixels; window 11 × 11
SIGMA = 1.5  # pixels
K1, K2 = 0.01, 0.03

_BELL = np.exp(-0.5 * (np.arange(RADIUS + 1) / SIGMA) ** 2)
_WEIGHTS = _BELL / (_BELL[0] + 2.0 * _BELL[1:].sum())  # the centre and one side


def moments(picture: NDArray[np.uint8]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean and variance in each window that lies wholly inside the picture.

    Parameters
    ----------
    picture : (H, W, 3) uint8
        At least 11 × 11 pixels.

    Returns
    -------
    two of (H − 10, 3 (W − 10)) float64
        Grey levels and their squares.
    """
    rows = _rows(picture)
    mean, variance = _moments(rows, _WEIGHTS)
    return mean, variance


def structural_similarity(
    picture: NDArray[np.uint8],
    target: NDArray[np.uint8],
    target_moments: tuple[NDArray[np.float64], NDArray[np.float64]],
    data_range: float,
) -> float:
    """Mean over windows and channels.

    Parameters
    ----------
    picture, target : (H, W, 3) uint8
        At least 11 × 11 pixels.
    target_moments : two arrays
        ``moments(target)``.
    data_range : float
        Largest minus smallest possible value.

    Returns
    -------
    float
        −1…1; 1 for equal pictures.
    """
    c1, c2 = (K1 * data_range) ** 2, (K2 * data_range) ** 2
    return float(_mean_ssim(_rows(picture), _rows(target), *target_moments, _WEIGHTS, c1, c2))


def _rows(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    # the compiled kernels take neither views nor read-only (memory-mapped) pictures: these are copied
    return np.require(picture, requirements=["C", "W"]).reshape(picture.shape[0], -1)


@njit(
    "void(uint8[:, ::1], uint8[:, ::1], int64, float64[::1], float64[::1], float64[::1], float64[::1])",
    cache=True,
    fastmath={"contract"},
)
def _down_columns(x, y, row, weights, sum_x, sum_xx, sum_xy):  # type: ignore[no-untyped-def]
    """Weighted sums of x, x² and xy over the rows around ``row``."""
    for j in range(x.shape[1]):
        a, d = np.int32(x[row, j]), np.int32(y[row, j])
        sum_x[j] = weights[0] * a
        sum_xx[j] = weights[0] * np.int32(a * a)
        sum_xy[j] = weights[0] * np.int32(a * d)
    for k in range(1, RADIUS + 1):
        weight = weights[k]
        x_up, x_down, y_up, y_down = x[row - k], x[row + k], y[row - k], y[row + k]
        for j in range(x.shape[1]):
            a, b = np.int32(x_up[j]), np.int32(x_down[j])
            sum_x[j] += weight * np.int32(a + b)
            sum_xx[j] += weight * np.int32(a * a + b * b)
            sum_xy[j] += weight * np.int32(a * np.int32(y_up[j]) + b * np.int32(y_down[j]))


@njit("void(float64[::1], float64[::1], float64[::1])", cache=True, fastmath={"contract"})
def _along_row(sums, weights, means):  # type: ignore[no-untyped-def]
    """Weighted mean over the columns around each window centre; neighbours of a channel lie 3 apart."""
    w0, w1, w2, w3, w4, w5 = weights[0], weights[1], weights[2], weights[3], weights[4], weights[5]
    for j in range(means.size):
        means[j] = (
            w0 * sums[j + 15]
            + w1 * (sums[j + 12] + sums[j + 18])
            + w2 * (sums[j + 9] + sums[j + 21])
            + w3 * (sums[j + 6] + sums[j + 24])
            + w4 * (sums[j + 3] + sums[j + 27])
            + w5 * (sums[j] + sums[j + 30])
        )


@njit("UniTuple(float64[:, ::1], 2)(uint8[:, ::1], float64[::1])", cache=True)
def _moments(x, weights):  # type: ignore[no-untyped-def]
    rows, width = x.shape[0] - 2 * RADIUS, x.shape[1] - 6 * RADIUS
    sum_x, sum_xx, unused = np.empty(x.shape[1]), np.empty(x.shape[1]), np.empty(x.shape[1])
    mean, variance = np.empty((rows, width)), np.empty((rows, width))
    for row in range(rows):
        _down_columns(x, x, row + RADIUS, weights, sum_x, sum_xx, unused)
        _along_row(sum_x, weights, mean[row])
        _along_row(sum_xx, weights, variance[row])
        variance[row] -= mean[row] * mean[row]
    return mean, variance


@njit(
    "float64(uint8[:, ::1], uint8[:, ::1], float64[:, ::1], float64[:, ::1], float64[::1], float64, float64)",
    cache=True,
)
def _mean_ssim(x, y, mean_y, variance_y, weights, c1, c2):  # type: ignore[no-untyped-def]
    rows, width = mean_y.shape
    sum_x, sum_xx, sum_xy = np.empty(x.shape[1]), np.empty(x.shape[1]), np.empty(x.shape[1])
    mean_x, mean_xx, mean_xy, similarity = np.empty(width), np.empty(width), np.empty(width), np.empty(width)
    total = 0.0
    for row in range(rows):
        _down_columns(x, y, row + RADIUS, weights, sum_x, sum_xx, sum_xy)
        _along_row(sum_x, weights, mean_x)
        _along_row(sum_xx, weights, mean_xx)
        _along_row(sum_xy, weights, mean_xy)
        for j in range(width):
            a, b = mean_x[j], mean_y[row, j]
            variance_x, covariance = mean_xx[j] - a * a, mean_xy[j] - a * b
            above = (2.0 * a * b + c1) * (2.0 * covariance + c2)
            below = (a * a + b * b + c1) * (variance_x + variance_y[row, j] + c2)
            similarity[j] = above / below
        total += similarity.sum()
    return total / (rows * width)
