"""What every SLAM back-end offers, so that association and driver need not know which one runs."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.frame import Observations, Odometry
from vslam.observation import ObservationModel
from vslam.slam_registry import Registry

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Entries of the hypothesis H_k (eq. 3-30) that are no landmark index.
DISCARDED = -1
NEW = -2


class Backend(Protocol):
    """An estimator of the robot's pose and the landmarks, both in the frame of the first pose.

    Landmarks are numbered from 0 in the order in which `update` founds them and keep their number.
    """

    @property
    def model(self) -> ObservationModel:
        """The observation model in use."""

    @property
    def pose(self) -> FloatArray:
        """(3,) float64: x, y (metres), heading (rad, not wrapped)."""

    @property
    def pose_covariance(self) -> FloatArray:
        """P_RR, (3, 3) float64."""

    @property
    def landmarks(self) -> FloatArray:
        """(n, 2) float64, metres."""

    @property
    def landmark_covariances(self) -> FloatArray:
        """Diagonal blocks of P_MM, (n, 2, 2) float64, m²."""

    @property
    def cross_covariances(self) -> FloatArray:
        """P_RL of each landmark, (n, 3, 2) float64."""

    @property
    def memory_bytes(self) -> int:
        """Bytes of the numbers that the estimate consists of."""

    def joint_covariance(self, landmarks: IntArray) -> FloatArray:
        """Covariance of pose and the given k landmarks, (3 + 2k, 3 + 2k) float64, in that order."""

    def predict(self, odometry: Odometry) -> None:
        """Move by one increment (eqs. 3-17 … 3-20)."""

    def update(self, observations: Observations, hypothesis: IntArray) -> IntArray:
        """Correct with the matched observations, then found landmarks for the new ones.

        Parameters
        ----------
        observations : Observations, n of them
        hypothesis : (n,) int64
            Landmark number, `NEW` or `DISCARDED` of each observation (eq. 3-30).

        Returns
        -------
        (n,) int64: landmark number of each observation, founded ones included, or `DISCARDED`.
        """


@dataclass(frozen=True, eq=False)
class Smoothed:
    """What a smoother knows after the last step, with hindsight.

    Attributes
    ----------
    poses : (n, 3) float64
        x, y (metres), heading (rad, not wrapped) after each step.
    landmarks : (m, 2) float64, metres
    """

    poses: FloatArray
    landmarks: FloatArray


@runtime_checkable
class Smoother(Protocol):
    """A back-end that can estimate the whole track at the end."""

    def smooth(self) -> Smoothed:
        """Solve for all poses and landmarks together."""


BackendFactory = Callable[..., Backend]
"""Called with the observation model, ``seed=`` and the back-end's own parameters."""

backends: Registry[BackendFactory] = Registry("SLAM back-end", "vslam.backends", "glarebench.backends")


def create(name: str, model: ObservationModel, seed: int, parameters: Mapping[str, Any]) -> Backend:
    """Build a back-end by name.

    Raises
    ------
    VslamError
        For an unknown name, a parameter that the back-end does not have, or a value that it refuses.
    """
    factory = backends.get(name)
    try:
        inspect.signature(factory).bind(model, seed=seed, **parameters)
        return factory(model, seed=seed, **parameters)
    except (TypeError, ValueError) as error:
        raise VslamError(f"SLAM back-end {name!r}: {error}") from None
