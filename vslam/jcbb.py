"""Association ``jcbb``: all observations of a picture at once, under their joint χ² test (Neira &
Tardós 2001).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from vslam.association import associations, squared_distances, unmatched
from vslam.frame import Observations
from vslam.joint_compatibility import BUDGET, branch_and_bound, joint_bounds
from vslam.slam_backend import Backend

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@associations.register("jcbb")
class Jcbb:
    """Joint compatibility branch and bound.

    An observation without a pairing is new when every landmark lies beyond the wider gate, as in ``icnn``;
    what is left is ambiguous and discarded.

    Parameters
    ----------
    gate : float
        Probability that a true hypothesis is accepted, 0…1: of each pairing alone, and of all together.
    new_gate : float
        Probability that a true pairing is not taken for a new landmark, ``gate``…1.
    budget : int
        Joint tests of one picture at most (`vslam.joint_compatibility.branch_and_bound`).
    """

    def __init__(self, gate: float, new_gate: float, budget: int = BUDGET) -> None:
        self._gate, self._new, self._budget = gate, float(chi2.ppf(new_gate, df=2)), budget
        self._bounds = joint_bounds(gate, 32)

    def associate(self, backend: Backend, observations: Observations) -> IntArray:
        """See `vslam.association.Associator`."""
        distances = squared_distances(backend, observations)
        hypothesis = unmatched(distances, self._new)
        # Landmarks that no observation is compatible with have no part in the joint test.
        near = np.flatnonzero((distances <= self._bounds[1]).any(axis=0))
        if not len(near):
            return hypothesis
        if len(observations) >= len(self._bounds):
            self._bounds = joint_bounds(self._gate, 2 * len(observations))
        Z, projected, S = _joint(backend, observations, near)
        distances = np.ascontiguousarray(distances[:, near])
        chosen, _ = branch_and_bound(
            Z, projected, S, distances, distances <= self._bounds[1], self._bounds, self._budget
        )
        hypothesis[chosen >= 0] = near[chosen[chosen >= 0]]
        return hypothesis


def _joint(
    backend: Backend, observations: Observations, near: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Innovations (n, k, 2), H P Hᵀ (2k, 2k) and S (n, 2, 2) of k landmarks."""
    model, pose, landmarks = backend.model, backend.pose, backend.landmarks[near]
    z, S = model.measure(observations)
    H_R, H_L = model.h_jacobians(pose, landmarks)
    k = len(near)
    H = np.zeros((2 * k, 3 + 2 * k))
    H[:, :3] = H_R.reshape(-1, 3)
    for j in range(k):
        H[2 * j : 2 * j + 2, 3 + 2 * j : 5 + 2 * j] = H_L[j]
    projected = H @ backend.joint_covariance(near) @ H.T
    Z = model.innovation(z[:, None, :], model.h(pose, landmarks)[None, :, :])
    return np.ascontiguousarray(Z), projected, np.ascontiguousarray(S)
