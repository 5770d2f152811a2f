"""What is decided when the drive is over and the track is smooth: neighbouring duplicates, and all
pairings anew.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.stats import chi2

from vslam.frame import Observations
from vslam.geometry import to_local
from vslam.loop_closing.closer import ONE_SIGHT_M
from vslam.loop_closing.smoother import Estimate

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

REACH_M = 1.0
"""Duplicates farther apart than this are left to the constellations: another disc is as near."""


def neighbours(estimate: Estimate, gate: float) -> list[tuple[int, int]]:
    """Pairs of landmarks that may be one disc: compatible by their joint covariance.

    Whether both stand in one picture, as two discs, is for
    `vslam.loop_closing.record.Fragments.merge` to refuse.

    Parameters
    ----------
    estimate : Estimate
    gate : float
        Probability with which two estimates of one disc pass the χ² test of two degrees of freedom.

    Returns
    -------
    list of (landmark, landmark), nearest first.
    """
    pairs = cKDTree(estimate.landmarks).query_pairs(REACH_M, output_type="ndarray").astype(np.int64)
    if not len(pairs):
        return []
    distances = _mahalanobis(estimate, pairs)
    close = np.flatnonzero(distances <= chi2.ppf(gate, 2))
    order = close[np.argsort(distances[close], kind="stable")]
    return [(int(a), int(b)) for a, b in pairs[order]]


def _mahalanobis(estimate: Estimate, pairs: IntArray) -> FloatArray:
    """Squared distance of each pair under its joint covariance, with the floor of one sight."""
    out = np.empty(len(pairs))
    difference = estimate.landmarks[pairs[:, 0]] - estimate.landmarks[pairs[:, 1]]
    for first in range(0, len(pairs), 100):
        part = slice(first, first + 100)
        some, where = np.unique(pairs[part], return_inverse=True)
        where = where.reshape(-1, 2)
        joint = estimate.covariance(some)
        for k, (a, b) in enumerate(where):
            ra, rb = slice(2 * a, 2 * a + 2), slice(2 * b, 2 * b + 2)
            C = joint[ra, ra] + joint[rb, rb] - joint[ra, rb] - joint[rb, ra] + 2 * ONE_SIGHT_M**2 * np.eye(2)
            d = difference[first + k]
            out[first + k] = d @ np.linalg.solve(C, d)
    return out


def pair_anew(
    poses: FloatArray, landmarks: FloatArray, observations: list[Observations], gate: float
) -> list[IntArray]:
    """Pair every observation with the landmark that the smoothed pose sees there: nearest first, −1 for none.

    Parameters
    ----------
    poses : (n, 3) float64
        After each step.
    landmarks : (m, 2) float64
    observations : list of n Observations
    gate : float
        Probability with which a true pairing passes, by the observation's own covariance and one sight's.
    """
    tree, bound = cKDTree(landmarks), float(chi2.ppf(gate, 2))
    labels: list[IntArray] = []
    for pose, seen in zip(poses, observations, strict=True):
        label = np.full(len(seen), -1, dtype=np.int64)
        near = np.array(
            tree.query_ball_point(pose[:2], np.hypot(*seen.points.T).max(initial=0.0) + REACH_M),
            dtype=np.int64,
        )
        if len(seen) and len(near):
            Z = seen.points[:, None] - to_local(pose, landmarks[near])[None]
            C = seen.covariances[:, None] + ONE_SIGHT_M**2 * np.eye(2)
            distances = np.einsum("nmi,nmi->nm", Z, np.linalg.solve(C, Z[..., None])[..., 0])
            i, j = np.nonzero(distances <= bound)
            taken: set[int] = set()
            for k in np.argsort(distances[i, j], kind="stable"):
                if label[i[k]] < 0 and int(j[k]) not in taken:
                    label[i[k]] = near[j[k]]
                    taken.add(int(j[k]))
        labels.append(label)
    return labels
