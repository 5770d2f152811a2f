"""Data association: which mapped landmark each observation shows, the hypothesis H_k of eq. 3-30.

``annotated``
    By the ids of the source; the first sight of an id founds a landmark, id −1 is dropped.
``icnn``
    Individual compatibility nearest neighbour (Neira & Tardós 2001, section III): a pairing is compatible
    when its squared Mahalanobis distance Zᵀ S_Z⁻¹ Z lies under the χ² quantile of two degrees of freedom.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.stats import chi2

from vslam.errors import VslamError
from vslam.frame import Observations
from vslam.slam_backend import DISCARDED, NEW, Backend
from vslam.slam_registry import Registry

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class Associator(Protocol):
    """Finds the hypothesis of one picture; called once per step, after the prediction."""

    def associate(self, backend: Backend, observations: Observations) -> IntArray:
        """Landmark number, ``NEW`` or ``DISCARDED`` of each observation, (n,) int64."""


associations: Registry[Callable[[float, float], Associator]] = Registry("association")
"""Factories take the match gate and the gate for new landmarks, both probabilities."""


@associations.register("annotated")
class Annotated:
    """By annotated ids; the gates play no part."""

    def __init__(self, gate: float, new_gate: float) -> None:
        self._numbers: dict[int, int] = {}

    def associate(self, backend: Backend, observations: Observations) -> IntArray:
        """See `Associator`.

        Raises
        ------
        VslamError
            When a picture holds an id twice.
        """
        seen: set[int] = set()
        known = len(self._numbers)
        hypothesis = np.full(len(observations), DISCARDED, dtype=np.int64)
        for i, landmark in enumerate(observations.ids.tolist()):
            if landmark < 0:
                continue
            if landmark in seen:
                raise VslamError(f"landmark id {landmark} occurs twice in one picture")
            seen.add(landmark)
            # The back-end numbers new landmarks in the order of the observations, as here.
            number = self._numbers.setdefault(landmark, len(self._numbers))
            hypothesis[i] = number if number < known else NEW
        return hypothesis


@associations.register("icnn")
class Icnn:
    """Individual compatibility nearest neighbour.

    Each landmark takes at most one observation per picture and the reverse: compatible pairings are
    accepted in the order of their Mahalanobis distance, smallest first (a greedy rule, no optimal
    assignment). An observation is new when every landmark lies beyond the wider gate; what is left, in
    between or beaten to its landmark, is ambiguous and discarded.

    Parameters
    ----------
    gate : float
        Probability that a true pairing is accepted, 0…1.
    new_gate : float
        Probability that a true pairing is not taken for a new landmark, ``gate``…1.
    """

    def __init__(self, gate: float, new_gate: float) -> None:
        self._match, self._new = float(chi2.ppf(gate, df=2)), float(chi2.ppf(new_gate, df=2))

    def associate(self, backend: Backend, observations: Observations) -> IntArray:
        """See `Associator`."""
        distances = squared_distances(backend, observations)
        hypothesis = unmatched(distances, self._new)
        taken: set[int] = set()
        for i, j in _nearest_first(distances, self._match):
            if hypothesis[i] == DISCARDED and j not in taken:
                hypothesis[i] = j
                taken.add(j)
        return hypothesis


def unmatched(distances: FloatArray, new: float) -> IntArray:
    """The hypothesis before any match: new beyond the gate ``new`` of every landmark, else discarded.

    Parameters
    ----------
    distances : (n, m) float64
        Of `squared_distances`.

    Returns
    -------
    (n,) int64
    """
    return np.where((distances <= new).any(axis=1), DISCARDED, NEW)


def squared_distances(backend: Backend, observations: Observations) -> FloatArray:
    """Zᵀ S_Z⁻¹ Z of every observation with every landmark.

    Returns
    -------
    (n, m) float64, ≥ 0; inf where S_Z is singular.
    """
    model, pose, landmarks = backend.model, backend.pose, backend.landmarks
    z, S = model.measure(observations)
    if not len(z) or not len(landmarks):
        return np.zeros((len(z), len(landmarks)))
    H_R, H_L = model.h_jacobians(pose, landmarks)
    projected = _project(
        H_R, H_L, backend.pose_covariance, backend.cross_covariances, backend.landmark_covariances
    )
    Z = model.innovation(z[:, None, :], model.h(pose, landmarks)[None, :, :])
    return _mahalanobis(Z, projected, np.ascontiguousarray(S))


def _nearest_first(distances: FloatArray, bound: float) -> list[tuple[int, int]]:
    """Pairs within the bound by rising distance; stable, so ties keep the order of the observations."""
    rows, columns = np.nonzero(distances <= bound)
    order = np.argsort(distances[rows, columns], kind="stable")
    return list(zip(rows[order].tolist(), columns[order].tolist(), strict=True))


@njit(cache=True)
def _project(
    H_R: FloatArray, H_L: FloatArray, P_RR: FloatArray, P_RL: FloatArray, P_LL: FloatArray
) -> FloatArray:
    """H P Hᵀ of each landmark from the robot's and its own blocks (eq. 3-25 without S), (m, 2, 2)."""
    m = len(H_L)
    out = np.empty((m, 2, 2))
    H = np.empty((2, 5))
    P = np.empty((5, 5))
    P[:3, :3] = P_RR
    for i in range(m):
        H[:, :3], H[:, 3:] = H_R[i], H_L[i]
        for a in range(3):
            for b in range(2):
                P[a, 3 + b] = P[3 + b, a] = P_RL[i, a, b]
        P[3:, 3:] = P_LL[i]
        for a in range(2):
            for b in range(2):
                total = 0.0
                for c in range(5):
                    for d in range(5):
                        total += H[a, c] * P[c, d] * H[b, d]
                out[i, a, b] = total
    return out


@njit(cache=True)
def _mahalanobis(Z: FloatArray, projected: FloatArray, S: FloatArray) -> FloatArray:
    """Zᵀ (projected + S)⁻¹ Z, (n, m), with the 2 × 2 inverse written out."""
    n, m = Z.shape[0], Z.shape[1]
    out = np.empty((n, m))
    for i in range(n):
        for j in range(m):
            a = projected[j, 0, 0] + S[i, 0, 0]
            b = projected[j, 0, 1] + S[i, 0, 1]
            d = projected[j, 1, 1] + S[i, 1, 1]
            determinant = a * d - b * b
            x, y = Z[i, j, 0], Z[i, j, 1]
            out[i, j] = (
                (d * x * x - 2.0 * b * x * y + a * y * y) / determinant if determinant > 0.0 else np.inf
            )
    return out
