"""Diffuse light from the intensity ratio of pixel clusters (Shen & Zheng 2013, "Real-time highlight removal
using intensity ratio", Applied Optics), in the fast form of Souza et al. 2018, "Real-time specular highlight
removal through pixel clustering", SIBGRAPI.

I_max − I_min, the range, is free of white light. On one surface Q = I_max / range is the same for all diffuse
pixels and larger for those with a highlight, so I_max − Q range is the specular part.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

CLUSTERS = 3  # Souza 2018
# Souza 2018: the median of the ratios is approached from their mean, in at most STEPS steps of STEP of the
# estimate, until no more than BALANCE of the pixels lie on one side
STEPS, STEP, BALANCE = 3, 0.025, 0.51

_NONE = 0  # label of a pixel outside the clusters
_FORM = "Array(float32, 3, 'C', readonly=True)"


def diffuse_by_intensity_ratio(linear: NDArray[np.float32]) -> NDArray[np.float32]:
    """Separate the diffuse part.

    1. Candidates are pixels with I_min above its mean over the picture, T.
    2. The pseudo specular-free colour I − I_min + T gives each its smallest and largest chromaticity.
    3. These form three clusters: seeded with the pixel of smallest minimum, largest maximum and largest
       minimum, then one step of k-means.
    4. Each cluster's Q is about the median of I_max / range over its pixels with a range above T.
    5. m_s = max(I_max − Q range, 0), at most I_min.

    A cluster without pixels of step 4 is grey: it has no Q and stays as it is. (Public ports give it Q = 0
    and so turn white walls black.)

    Parameters
    ----------
    linear : (H, W, 3) float32
        Linear light, white-balanced.

    Returns
    -------
    (H, W, 3) float32
        0 … ``linear``.
    """
    linear = np.ascontiguousarray(linear)
    smallest = linear.min(axis=2)
    mean = float(smallest.mean(dtype=np.float64))
    lower, upper, labels = _chromaticities(linear, smallest, mean)
    if not labels.any():
        return linear.copy()
    chromaticity = (lower, upper)
    centres = np.stack([_at(chromaticity, labels, *seed) for seed in ((lower, -1), (upper, 1), (lower, 1))])
    _assign(lower, upper, labels, centres)
    _assign(lower, upper, labels, _means(lower, upper, labels, centres))
    ratios = np.array([np.nan, *(_ratio(linear, smallest, labels, k, mean) for k in range(1, CLUSTERS + 1))])
    diffuse: NDArray[np.float32] = _without_specular(linear, smallest, labels, ratios.astype(np.float32))
    return diffuse


def _at(
    chromaticity: tuple[NDArray[np.float32], NDArray[np.float32]],
    labels: NDArray[np.uint8],
    values: NDArray[np.float32],
    sign: int,
) -> NDArray[np.float32]:
    """(2,) the chromaticities of the candidate in which ``values`` is largest (sign 1) or smallest (−1)."""
    best = np.argmax(np.where(labels != _NONE, sign * values, -np.inf))
    return np.array([part.ravel()[best] for part in chromaticity], dtype=np.float32)


@njit(
    f"Tuple((float32[:, ::1], float32[:, ::1], uint8[:, ::1]))({_FORM}, float32[:, ::1], float64)", cache=True
)
def _chromaticities(linear, smallest, mean):  # type: ignore[no-untyped-def]
    """Smallest and largest pseudo specular-free chromaticity of the candidates, which get label 1."""
    height, width = smallest.shape
    lower = np.zeros((height, width), dtype=np.float32)
    upper = np.zeros((height, width), dtype=np.float32)
    labels = np.zeros((height, width), dtype=np.uint8)
    offset = np.float32(mean)
    for row in range(height):
        for column in range(width):
            low = smallest[row, column]
            if not low > offset:
                continue
            red, green, blue = linear[row, column, 0], linear[row, column, 1], linear[row, column, 2]
            total = red + green + blue + np.float32(3.0) * (offset - low)
            lower[row, column] = offset / total
            upper[row, column] = (max(red, green, blue) - low + offset) / total
            labels[row, column] = 1
    return lower, upper, labels


@njit("void(float32[:, ::1], float32[:, ::1], uint8[:, ::1], float32[:, ::1])", cache=True)
def _assign(lower, upper, labels, centres):  # type: ignore[no-untyped-def]
    """Give each candidate the nearest centre's label, by the sum of absolute differences."""
    for row in range(labels.shape[0]):
        for column in range(labels.shape[1]):
            if labels[row, column] == _NONE:
                continue
            best = np.float32(np.inf)
            for k in range(CLUSTERS):
                distance = abs(lower[row, column] - centres[k, 0]) + abs(upper[row, column] - centres[k, 1])
                if distance < best:
                    best = distance
                    labels[row, column] = k + 1


@njit("float32[:, ::1](float32[:, ::1], float32[:, ::1], uint8[:, ::1], float32[:, ::1])", cache=True)
def _means(lower, upper, labels, centres):  # type: ignore[no-untyped-def]
    """Mean chromaticities of each cluster; an empty one keeps its seed."""
    sums = np.zeros((CLUSTERS + 1, 3), dtype=np.float64)
    for row in range(labels.shape[0]):
        for column in range(labels.shape[1]):
            entry = sums[labels[row, column]]
            entry[0] += lower[row, column]
            entry[1] += upper[row, column]
            entry[2] += 1.0
    means = centres.copy()
    for k in range(CLUSTERS):
        if sums[k + 1, 2] > 0.0:
            means[k, 0] = sums[k + 1, 0] / sums[k + 1, 2]
            means[k, 1] = sums[k + 1, 1] / sums[k + 1, 2]
    return means


@njit(f"float64({_FORM}, float32[:, ::1], uint8[:, ::1], int64, float64)", cache=True)
def _ratio(linear, smallest, labels, cluster, mean):  # type: ignore[no-untyped-def]
    """Q of a cluster; NaN without pixels of enough range."""
    ratios = np.empty(labels.size, dtype=np.float32)
    count, total = 0, 0.0
    for row in range(labels.shape[0]):
        for column in range(labels.shape[1]):
            if labels[row, column] != cluster:
                continue
            largest = max(linear[row, column, 0], linear[row, column, 1], linear[row, column, 2])
            spread = largest - smallest[row, column]
            if spread > mean:
                ratios[count] = largest / spread
                total += ratios[count]
                count += 1
    if count == 0:
        return np.nan
    estimate = total / count
    for _ in range(STEPS):
        above = 0
        for i in range(count):
            above += ratios[i] > estimate
        if count - above > BALANCE * count:
            estimate -= STEP * estimate
        elif above > BALANCE * count:
            estimate += STEP * estimate
        else:
            break
    return estimate


@njit(f"float32[:, :, ::1]({_FORM}, float32[:, ::1], uint8[:, ::1], float32[::1])", cache=True)
def _without_specular(linear, smallest, labels, ratios):  # type: ignore[no-untyped-def]
    height, width = labels.shape
    diffuse = np.empty((height, width, 3), dtype=np.float32)
    for row in range(height):
        for column in range(width):
            low, ratio = smallest[row, column], ratios[labels[row, column]]
            largest = max(linear[row, column, 0], linear[row, column, 1], linear[row, column, 2])
            specular = largest - ratio * (largest - low)
            # a comparison with NaN is false: no ratio, no change
            specular = min(specular, low) if specular > 0.0 else np.float32(0.0)
            for c in range(3):
                diffuse[row, column, c] = linear[row, column, c] - specular
    return diffuse
