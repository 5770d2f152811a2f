"""What the robot receives at each step: a picture, a depth image and an odometry increment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Odometry:
    """One motion increment u_t with its noise (eqs. 3-8 … 3-11).

    Attributes
    ----------
    delta : (3,) float64
        (Δx, Δy, Δθ): the robot's new pose in the frame of its old one, metres and radians.
        The dissertation's u = [Δx, Δθ] is the case Δy = 0.
    covariance : (3, 3) float64
        Q, of ``delta``, in m², m·rad and rad².
    """

    delta: FloatArray
    covariance: FloatArray


@dataclass(frozen=True, eq=False)
class Observations:
    """The landmarks that one picture shows, as points on the floor in the robot's frame.

    Attributes
    ----------
    points : (n, 2) float64
        Forward and left coordinate, metres.
    covariances : (n, 2, 2) float64
        S of each point, m².
    ids : (n,) int64
        Annotated landmark id where the source knows one, otherwise −1.
    """

    points: FloatArray
    covariances: FloatArray
    ids: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.points)

    @staticmethod
    def none() -> Observations:
        """A step that sees no landmark."""
        return Observations(np.zeros((0, 2)), np.zeros((0, 2, 2)), np.zeros(0, dtype=np.int64))


@dataclass(frozen=True, eq=False)
class Frame:
    """One step of the robot, as it arrives from the sensors.

    Attributes
    ----------
    index : int
        Number of the step, from 0.
    stamp : float
        Seconds since the first frame.
    image : (H, W, 3) uint8
        The recorded picture, sRGB-encoded RGB.
    depth : (H, W) float32
        z in the camera frame, metres; 0 where there is no reading.
    odometry : Odometry
        The motion since the frame before.
    """

    index: int
    stamp: float
    image: NDArray[np.uint8]
    depth: NDArray[np.float32]
    odometry: Odometry
