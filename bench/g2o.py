"""SLAM runs as g2o files with landmarks, for other people's solvers (Kümmerle et al. 2011)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from vslam.frame import Observations, Odometry

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

SMALLEST_VARIANCE = 1e-12
"""m² and rad²: a motion that is certain has no finite information."""


def text(
    steps: Sequence[tuple[Odometry, Observations]],
    matches: Sequence[IntArray],
    poses: FloatArray,
    landmarks: FloatArray,
) -> str:
    """Write a run: what was measured as edges, what was estimated as vertices.

    Parameters
    ----------
    steps : sequence of n (Odometry, Observations)
    matches : sequence of n (k,) int64
        Landmark number of each observation, −1 where it was discarded and stays out.
    poses : (n, 3) float64
        After each step; the start, number 0, is the origin and fixed.
    landmarks : (m, 2) float64
        Numbered after the poses: landmark l is vertex n + 1 + l.
    """
    return "".join(f"{line}\n" for line in _lines(steps, matches, poses, landmarks))


def _lines(
    steps: Sequence[tuple[Odometry, Observations]],
    matches: Sequence[IntArray],
    poses: FloatArray,
    landmarks: FloatArray,
) -> Iterator[str]:
    first_landmark = len(poses) + 1
    yield "VERTEX_SE2 0 0 0 0"
    yield "FIX 0"
    for k, pose in enumerate(poses, start=1):
        yield f"VERTEX_SE2 {k} {_row(pose)}"
    for k, landmark in enumerate(landmarks):
        yield f"VERTEX_XY {first_landmark + k} {_row(landmark)}"
    for k, ((odometry, seen), numbers) in enumerate(zip(steps, matches, strict=True)):
        yield f"EDGE_SE2 {k} {k + 1} {_row(odometry.delta)} {_information(odometry.covariance)}"
        for point, covariance, number in zip(seen.points, seen.covariances, numbers, strict=True):
            if number >= 0:
                edge = f"{k + 1} {first_landmark + number} {_row(point)}"
                yield f"EDGE_SE2_XY {edge} {_information(covariance)}"


def _information(covariance: FloatArray) -> str:
    size = len(covariance)
    certain = np.diag(np.maximum(SMALLEST_VARIANCE - np.diag(covariance), 0.0))
    return _row(np.linalg.inv(covariance + certain)[np.triu_indices(size)])


def _row(values: FloatArray) -> str:
    return " ".join(f"{value:.12g}" for value in values)
