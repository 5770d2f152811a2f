"""Diffuse light from the intensity ratio of pixel clusters (Shen & Zheng 2013, "Real-time highlight removal
using intensity ratio", Applied Optics), in the fast form of Souza et al. 2018, "Real-time specular highlight
removal through pixel clustering", SIBGRAPI.

I_max − I_min, the range, is free of white light. On one surface Q = I_max / range is the same for all diffuse
pixels and larger for those with a highlight, so I_max − Q range is the specular part.
"""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

CLUSTERS = 3  # Souza 2018
# Souza 2018: the median of the ratios is approached from their mean, in at most STEPS steps of STEP of the
# estimate, until no more than BALANCE of the pixels lie on one side
STEPS, STEP, BALANCE = 3, 0.025, 0.51
SAME = 1e-5  # chromaticity: centres this close, by rounding, are one

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
    smallest = cv2.min(cv2.min(linear[..., 0], linear[..., 1]), linear[..., 2])
    mean = cv2.mean(smallest)[0]
    place, chromaticity, ratio = _candidates(linear.reshape(-1, 3), smallest.reshape(-1), mean)
    diffuse = linear.copy()
    if place.size:
        labels = _clusters(chromaticity)
        ratios = np.array([_typical(ratio, labels, k) for k in range(CLUSTERS)], dtype=np.float32)
        _subtract(diffuse.reshape(-1, 3), place, labels, ratios)
    return diffuse


@njit(
    "Tuple((int32[::1], float32[:, ::1], float32[::1]))"
    "(Array(float32, 2, 'C', readonly=True), float32[::1], float64)",
    cache=True,
)
def _candidates(linear, smallest, mean):  # type: ignore[no-untyped-def]
    """Steps 1 and 2: where candidates are, their chromaticities, and I_max / range (0: range too small)."""
    size, offset = smallest.size, np.float32(mean)
    place = np.empty(size, dtype=np.int32)
    chromaticity = np.empty((size, 2), dtype=np.float32)
    ratio = np.empty(size, dtype=np.float32)
    count = 0
    for i in range(size):
        low = smallest[i]
        if not low > offset:
            continue
        red, green, blue = linear[i, 0], linear[i, 1], linear[i, 2]
        largest = max(red, green, blue)
        total = red + green + blue + np.float32(3.0) * (offset - low)
        place[count] = i
        chromaticity[count, 0] = offset / total
        chromaticity[count, 1] = (largest - low + offset) / total
        ratio[count] = largest / (largest - low) if largest - low > offset else np.float32(0.0)
        count += 1
    return place[:count].copy(), chromaticity[:count].copy(), ratio[:count].copy()


@njit("uint8[::1](float32[:, ::1])", cache=True)
def _clusters(chromaticity):  # type: ignore[no-untyped-def]
    """Step 3: the cluster of each candidate, by the sum of absolute differences to the centres."""
    lowest, highest, palest = 0, 0, 0
    for i in range(len(chromaticity)):
        lowest = i if chromaticity[i, 0] < chromaticity[lowest, 0] else lowest
        highest = i if chromaticity[i, 1] > chromaticity[highest, 1] else highest
        palest = i if chromaticity[i, 0] > chromaticity[palest, 0] else palest
    centres = np.stack((chromaticity[lowest], chromaticity[highest], chromaticity[palest]))
    labels = np.empty(len(chromaticity), dtype=np.uint8)
    for step in range(2):
        sums = np.zeros((CLUSTERS, 3), dtype=np.float64)
        for i in range(len(chromaticity)):
            low, high = chromaticity[i, 0], chromaticity[i, 1]
            best, label = np.float32(np.inf), 0
            for k in range(CLUSTERS):
                distance = abs(low - centres[k, 0]) + abs(high - centres[k, 1])
                if distance < best - SAME:
                    best, label = distance, k
            labels[i] = label
            sums[label, 0] += low
            sums[label, 1] += high
            sums[label, 2] += 1.0
        for k in range(CLUSTERS):
            if step == 0 and sums[k, 2] > 0.0:  # an empty cluster keeps its seed
                centres[k, 0] = sums[k, 0] / sums[k, 2]
                centres[k, 1] = sums[k, 1] / sums[k, 2]
    return labels


@njit("float64(float32[::1], uint8[::1], int64)", cache=True)
def _typical(ratio, labels, cluster):  # type: ignore[no-untyped-def]
    """Step 4: Q of a cluster; NaN without pixels of enough range."""
    count, total = 0, 0.0
    for i in range(ratio.size):
        if labels[i] == cluster and ratio[i] > 0.0:
            total += ratio[i]
            count += 1
    if count == 0:
        return np.nan
    estimate = total / count
    for _ in range(STEPS):
        above = 0
        for i in range(ratio.size):
            above += labels[i] == cluster and ratio[i] > estimate
        if count - above > BALANCE * count:
            estimate -= STEP * estimate
        elif above > BALANCE * count:
            estimate += STEP * estimate
        else:
            break
    return estimate


@njit("void(float32[:, ::1], int32[::1], uint8[::1], float32[::1])", cache=True)
def _subtract(linear, place, labels, ratios):  # type: ignore[no-untyped-def]
    """Step 5, in place."""
    for k in range(place.size):
        red, green, blue = linear[place[k], 0], linear[place[k], 1], linear[place[k], 2]
        largest, low = max(red, green, blue), min(red, green, blue)
        specular = largest - ratios[labels[k]] * (largest - low)
        if specular > 0.0:  # false for NaN: no ratio, no change
            specular = min(specular, low)
            for c in range(3):
                linear[place[k], c] -= specular
