"""The SLAM driver: predict, associate, update, once per step."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

import vslam.jcbb  # noqa: F401  (registers)
from vslam.association import associations
from vslam.errors import VslamError
from vslam.frame import Observations, Odometry
from vslam.loop_closing.association import Constellation
from vslam.observation import observation_models
from vslam.slam_backend import Backend, Smoothed, Smoother, backends, create

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class SlamSettings:
    """Which parts the SLAM system is made of.

    Attributes
    ----------
    backend, association, observation : str
        Names in `vslam.slam_backend.backends`, `vslam.association.associations` and
        `vslam.observation.observation_models`.
    gate : float
        Probability with which a true pairing passes the χ² test; 0.99 is Neira & Tardós' customary choice.
    new_gate : float
        Probability with which a true pairing is *not* taken for a new landmark: one duplicate in 10,000
        re-observations when the models hold.
    seed : int
        Of whatever is random in the back-end, ≥ 0.
    parameters : mapping
        The back-end's own, such as ``{"particles": 200}``.

    Raises
    ------
    VslamError
        For an unknown name or gates that are not 0 < gate ≤ new_gate < 1; `Slam` refuses parameters that the
        back-end does not have.
    """

    backend: str = "ekf"
    association: str = "icnn"
    observation: str = "range_bearing"
    gate: float = 0.99
    new_gate: float = 0.9999
    seed: int = 0
    parameters: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        backends.get(self.backend)
        associations.get(self.association)
        observation_models.get(self.observation)
        if not 0.0 < self.gate <= self.new_gate < 1.0:
            raise VslamError(f"gates must be 0 < gate ≤ new_gate < 1, not {self.gate} and {self.new_gate}")


@dataclass(frozen=True, eq=False)
class SlamResult:
    """What a SLAM run estimated, in the frame of the first pose.

    Attributes
    ----------
    poses : (n, 3) float64
        x, y (metres) and heading (rad, not wrapped) after each step.
    covariances : (n, 3, 3) float64
        P_RR after each step.
    landmarks : (m, 2) float64
        Final estimates, metres.
    landmark_covariances : (m, 2, 2) float64, m²
    matches : tuple of n (n_k,) int64 arrays
        Landmark number of each observation of each step, −1 where it was discarded. The first mention of a
        number is the observation that founded the landmark.
    seconds : float
        Wall clock of the whole run, smoothing left out.
    memory_bytes : int
        What the back-end's estimate takes after the last step.
    smoothed : Smoothed or None
        Of a back-end that smooths (`vslam.slam_backend.Smoother`): track and landmarks with hindsight.
    """

    poses: FloatArray
    covariances: FloatArray
    landmarks: FloatArray
    landmark_covariances: FloatArray
    matches: tuple[IntArray, ...]
    seconds: float
    memory_bytes: int = 0
    smoothed: Smoothed | None = None


class Slam:
    """SLAM step by step, for a loop that also does other things.

    BLAS with several threads is far slower on these small matrices; a caller who cares wraps his loop in
    ``threadpoolctl.threadpool_limits(1, user_api="blas")``, as `run_slam` does.
    """

    def __init__(self, settings: SlamSettings | None = None) -> None:
        self.settings = settings or SlamSettings()
        model = observation_models.get(self.settings.observation)()
        self.backend: Backend = create(
            self.settings.backend, model, self.settings.seed, self.settings.parameters
        )
        self.associator = associations.get(self.settings.association)(
            self.settings.gate, self.settings.new_gate
        )
        self.steps = 0

    def step(self, odometry: Odometry, observations: Observations) -> IntArray:
        """Take one motion increment and the landmarks seen after it.

        Returns
        -------
        (n,) int64: landmark number of each observation, −1 where it was discarded.

        Raises
        ------
        VslamError
            Naming the step, counted from 0: an input is not finite, a covariance is not positive definite, an
            id repeats within the picture, or the filter broke down.
        """
        try:
            self.backend.predict(odometry)
            hypothesis = self.associator.associate(self.backend, observations)
            matches = self.backend.update(observations, hypothesis)
        except VslamError as error:
            raise VslamError(f"SLAM step {self.steps}: {error}") from error
        if not (np.isfinite(self.backend.pose).all() and np.isfinite(self.backend.pose_covariance).all()):
            raise VslamError(f"SLAM step {self.steps}: the estimated pose is no longer finite")
        self.steps += 1
        return matches


def decides_over_drive(association: str) -> bool:
    """Whether an association brings its own estimator and pairs over the whole drive (`run_slam` alone can).

    Back-end and observation form then play no part: it takes points in the robot's frame.
    """
    return associations.get(association) is Constellation


def run_slam(
    steps: Sequence[tuple[Odometry, Observations]], settings: SlamSettings | None = None
) -> SlamResult:
    """Run SLAM over a whole sequence, on one BLAS thread.

    Parameters
    ----------
    steps : sequence of (Odometry, Observations)
        Each increment with what is seen after it.
    settings : SlamSettings, optional

    Returns
    -------
    SlamResult

    Raises
    ------
    VslamError
        As `Slam.step`; also when the final map is not finite.
    """
    slam = Slam(settings)
    if isinstance(slam.associator, Constellation):
        return _run_drive(steps, slam.associator)
    poses = np.empty((len(steps), 3))
    covariances = np.empty((len(steps), 3, 3))
    matches: list[IntArray] = []
    start = time.perf_counter()
    with threadpool_limits(limits=1, user_api="blas"):
        for k, (odometry, observations) in enumerate(steps):
            matches.append(slam.step(odometry, observations))
            poses[k], covariances[k] = slam.backend.pose, slam.backend.pose_covariance
    seconds = time.perf_counter() - start
    landmarks, landmark_covariances = slam.backend.landmarks, slam.backend.landmark_covariances
    if not (np.isfinite(landmarks).all() and np.isfinite(landmark_covariances).all()):
        raise VslamError(f"SLAM step {slam.steps - 1}: the estimated map is not finite")
    smoothed = slam.backend.smooth() if isinstance(slam.backend, Smoother) and len(steps) else None
    return SlamResult(
        poses,
        covariances,
        landmarks,
        landmark_covariances,
        tuple(matches),
        seconds,
        slam.backend.memory_bytes,
        smoothed,
    )


def _run_drive(steps: Sequence[tuple[Odometry, Observations]], associator: Constellation) -> SlamResult:
    """A run whose pairings are known at its end alone: the map is that of the smoothed track."""
    start = time.perf_counter()
    with threadpool_limits(limits=1, user_api="blas"):
        done = associator.run(steps)
    return SlamResult(
        done.online_poses,
        done.online_covariances,
        done.landmarks,
        done.landmark_covariances,
        done.matches,
        time.perf_counter() - start,
        smoothed=Smoothed(done.poses, done.landmarks),
    )
