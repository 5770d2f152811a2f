"""What a back-end refuses: values that are not finite, noise that is no covariance, unknown landmarks."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.frame import Observations, Odometry
from vslam.slam_backend import DISCARDED, NEW

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def check_odometry(odometry: Odometry) -> None:
    """Refuse an increment that is not finite or whose covariance is not positive semi-definite.

    Semi-definite is enough: a robot that cannot slide has no noise sideways.

    Raises
    ------
    VslamError
    """
    Q = np.asarray(odometry.covariance, dtype=np.float64)
    if not (all_finite(np.asarray(odometry.delta, dtype=np.float64)) and all_finite(Q)):
        raise VslamError("the odometry holds a value that is not finite")
    if not _semi_definite(Q):
        raise VslamError(f"the odometry covariance {Q.tolist()} is not positive semi-definite")


def check_observations(observations: Observations) -> None:
    """Refuse points that are not finite and covariances that are not positive definite.

    Raises
    ------
    VslamError
    """
    S = np.asarray(observations.covariances, dtype=np.float64)
    if not (all_finite(np.asarray(observations.points, dtype=np.float64)) and all_finite(S)):
        raise VslamError("an observation holds a value that is not finite")
    if len(S) and (worst := _first_indefinite(S)) >= 0:
        raise VslamError(
            f"the covariance {S[worst].tolist()} of observation {worst} is not positive definite"
        )


def check_hypothesis(observations: Observations, matches: IntArray, known: int) -> None:
    """Refuse a hypothesis of another length, or one that names landmarks beyond the ``known`` ones.

    Raises
    ------
    VslamError
        Also when two observations of one picture are matched to the same landmark.
    """
    if len(matches) != len(observations):
        raise VslamError(f"{len(matches)} hypotheses for {len(observations)} observations")
    named = [j for j in matches.tolist() if j not in (NEW, DISCARDED)]  # a handful: faster than NumPy
    if any(not 0 <= j < known for j in named):
        raise VslamError(f"the hypothesis {matches.tolist()} names landmarks beyond the {known} in the map")
    if len(set(named)) < len(named):
        raise VslamError(f"the hypothesis {matches.tolist()} matches a landmark twice in one picture")


@njit(cache=True)
def all_finite(values: FloatArray) -> bool:
    """Whether no value is infinite or NaN; of a few numbers faster than ``np.isfinite().all()``."""
    for value in values.flat:  # noqa: SIM110  (numba knows no generators)
        if not np.isfinite(value):
            return False
    return True


@njit(cache=True)
def _semi_definite(Q: FloatArray) -> bool:
    """Whether (3, 3) Q is symmetric to a part in a million and no principal minor is negative (Sylvester)."""
    largest = np.abs(Q).max()
    for i in range(3):
        for j in range(i):
            if abs(Q[i, j] - Q[j, i]) > 1e-6 * largest:
                return False
    # Scaled to unit diagonal, since metres and radians have no common size to call a minor small by.
    d = np.empty(3)
    for i in range(3):
        if Q[i, i] < 0.0:
            return False
        d[i] = 1.0 / np.sqrt(Q[i, i]) if Q[i, i] > 0.0 else 0.0
        if Q[i, i] == 0.0:
            for j in range(3):
                if Q[i, j] != 0.0:
                    return False
    a, b, c = Q[1, 0] * d[1] * d[0], Q[2, 0] * d[2] * d[0], Q[2, 1] * d[2] * d[1]
    tiny = -1e-9
    if 1.0 - a * a < tiny or 1.0 - b * b < tiny or 1.0 - c * c < tiny:
        return False
    if d[0] > 0.0 and d[1] > 0.0 and d[2] > 0.0:
        return bool(1.0 + 2.0 * a * b * c - a * a - b * b - c * c >= tiny)
    return True


@njit(cache=True)
def _first_indefinite(S: FloatArray) -> int:
    """First of (n, 2, 2) that is not symmetric positive definite, −1 where all are."""
    for i in range(len(S)):
        a, b, c, d = S[i, 0, 0], S[i, 0, 1], S[i, 1, 0], S[i, 1, 1]
        if a <= 0.0 or a * d - b * b <= 0.0 or abs(b - c) > 1e-6 * max(a, d):
            return i
    return -1
