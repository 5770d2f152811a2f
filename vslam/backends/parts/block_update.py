"""What a Gaussian state goes through: motions, and pictures, whose matched observations correct it in one
block and whose new ones found landmarks.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from vslam.backends.parts.input_checks import check_hypothesis, check_observations, check_odometry
from vslam.frame import Observations, Odometry
from vslam.observation import ObservationModel
from vslam.slam_backend import NEW

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class BlockUpdate(ABC):
    """A state of one robot and many landmarks, ``_size`` numbers in all."""

    model: ObservationModel
    _size: int

    def predict(self, odometry: Odometry) -> None:
        """Move by one increment.

        Raises
        ------
        VslamError
            When the increment is not finite or its covariance not positive semi-definite.
        """
        check_odometry(odometry)
        self._predict(odometry)

    def update(self, observations: Observations, hypothesis: IntArray) -> IntArray:
        """Correct with the matched observations, then found landmarks for the new ones.

        Parameters
        ----------
        observations : Observations, n of them
        hypothesis : (n,) int64
            Landmark number, ``NEW`` or ``DISCARDED`` of each observation (eq. 3-30).

        Returns
        -------
        (n,) int64: landmark number of each observation, or ``DISCARDED``.

        Raises
        ------
        VslamError
            When an observation is not finite, its covariance not positive definite, or the hypothesis names
            landmarks that do not exist or one twice.
        """
        check_observations(observations)
        matches = np.array(hypothesis, dtype=np.int64)
        check_hypothesis(observations, matches, (self._size - 3) // 2)
        if not len(matches):
            return matches
        z, S = self.model.measure(observations)
        matched, new = matches >= 0, matches == NEW
        if matched.any():
            self._correct(z[matched], S[matched], matches[matched])
        if new.any():
            matches[new] = self._found(z[new], S[new])
        return matches

    @abstractmethod
    def _predict(self, odometry: Odometry) -> None:
        """Move the state by one increment, which has been checked."""

    @abstractmethod
    def _correct(self, z: FloatArray, S: FloatArray, numbers: IntArray) -> None:
        """Correct the state with measurements of known landmarks."""

    @abstractmethod
    def _found(self, z: FloatArray, S: FloatArray) -> IntArray:
        """Append landmarks and return their numbers."""
