"""SLAM as a factor graph: iSAM2 online, Levenberg–Marquardt over everything at the end.

Sources: Dellaert & Kaess 2006, "Square root SAM"; Kaess et al. 2012, "iSAM2: incremental smoothing and
mapping using the Bayes tree"; the implementation is GTSAM's. GTSAM is imported when a graph is made, not
before.

iSAM2 takes landmarks by bearing and range; Cartesian observations are handed over as such, their covariance
through the Jacobian at the measured point, which differs to second order. Smoothing at the end uses the
Cartesian error itself (eq. 3-6), through a factor written in Python: too slow for every step, exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vslam.backends.parts.input_checks import check_hypothesis, check_observations, check_odometry
from vslam.errors import VslamError
from vslam.frame import Observations, Odometry
from vslam.geometry import rotation, wrap_angle
from vslam.motion import motion_jacobians, move
from vslam.observation import ObservationModel, RangeBearing
from vslam.slam_backend import NEW, Smoothed, backends

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_START_SIGMA = 1e-6  # P_0 = 0 as a prior: a micrometre and a microradian
_FLOOR = 1e-12  # variance of an increment that is certain, such as sideways for a robot that cannot slide

# Constants for 95 % efficiency on Gaussian noise: Zhang 1997, "Parameter estimation techniques", table 1;
# Geman–McClure has none there, and takes GTSAM's default scale.
ROBUST = {"huber": 1.345, "cauchy": 2.3849, "tukey": 4.6851, "geman_mcclure": 1.0}
FACTORISATIONS = {"qr": "QR", "cholesky": "CHOLESKY"}
_GTSAM_NAMES = {"huber": "Huber", "cauchy": "Cauchy", "tukey": "Tukey", "geman_mcclure": "GemanMcClure"}


@dataclass(frozen=True, eq=False)
class _Predicted:
    """The pose after a motion whose picture has not come yet, with F_R for cross-covariances."""

    pose: FloatArray
    covariance: FloatArray
    F_R: FloatArray


@backends.register("graph")
class Graph:
    """The factor graph, a `vslam.slam_backend.Backend` and `vslam.slam_backend.Smoother`.

    Joint covariances are read from the Bayes tree landmark by landmark: exact, and slow. Association by
    gating costs far more here than with a filter.

    Parameters
    ----------
    model : ObservationModel
        How a landmark is measured: "cartesian" or "range_bearing", as GTSAM knows no other.
    seed : int
        Unused: nothing here is random.
    robust : str
        Loss of the observations: "none" or a name in `ROBUST`.
    relinearise : float
        Step of a variable beyond which iSAM2 linearises it anew, metres and rad alike, > 0; it looks at every
        tenth update. Both are GTSAM's defaults.
    factorisation : str
        How iSAM2 eliminates: "qr", or "cholesky", which is three times as fast where many landmarks are seen
        at once, but breaks down where one is poorly known.

    Raises
    ------
    VslamError
        For an unknown loss or factorisation, a threshold that is not positive, or another observation model.
    """

    name = "graph"

    def __init__(
        self,
        model: ObservationModel,
        seed: int = 0,
        robust: str = "none",
        relinearise: float = 0.1,
        factorisation: str = "qr",
    ) -> None:
        import gtsam

        if factorisation not in FACTORISATIONS:
            raise VslamError(f"unknown factorisation {factorisation!r}: known: {', '.join(FACTORISATIONS)}")
        if robust != "none" and robust not in ROBUST:
            raise VslamError(f"unknown robust loss {robust!r}: known: none, {', '.join(ROBUST)}")
        if not relinearise > 0.0:
            raise VslamError(f"relinearise must be positive, not {relinearise}")
        if model.name not in ("cartesian", "range_bearing"):
            raise VslamError(f"the back-end graph has no factor for the observation model {model.name!r}")
        self.model = model
        self._gtsam: Any = gtsam
        self._robust = robust
        self._isam = _isam(gtsam, relinearise, FACTORISATIONS[factorisation])
        self._everything = gtsam.NonlinearFactorGraph()
        self._steps, self._count = 0, 0
        self._pose, self._P_RR = np.zeros(3), np.zeros((3, 3))
        self._predicted: _Predicted | None = None
        self._new_factors, self._new_values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        prior = gtsam.noiseModel.Isotropic.Sigma(3, _START_SIGMA)
        self._add(gtsam.PriorFactorPose2(_x(0), gtsam.Pose2(), prior))
        self._new_values.insert(_x(0), gtsam.Pose2())
        self._optimise()

    @property
    def pose(self) -> FloatArray:
        """(3,) float64: x, y (metres), heading (rad, not wrapped)."""
        return (self._pose if self._predicted is None else self._predicted.pose).copy()

    @property
    def pose_covariance(self) -> FloatArray:
        """P_RR, (3, 3) float64."""
        return (self._P_RR if self._predicted is None else self._predicted.covariance).copy()

    @property
    def landmarks(self) -> FloatArray:
        """(n, 2) float64, metres."""
        return self._positions(self._isam.calculateEstimate())

    @property
    def landmark_covariances(self) -> FloatArray:
        """(n, 2, 2) float64, m²."""
        blocks = [self._isam.marginalCovariance(_l(i)) for i in range(self._count)]
        return np.array(blocks).reshape(-1, 2, 2)

    @property
    def cross_covariances(self) -> FloatArray:
        """P_RL of each landmark, (n, 3, 2) float64."""
        blocks = [self.joint_covariance(np.array([i]))[:3, 3:] for i in range(self._count)]
        return np.array(blocks).reshape(-1, 3, 2)

    @property
    def memory_bytes(self) -> int:
        """Bytes of the numbers in the Bayes tree; factors and values, which grow linearly, are left out."""
        return 8 * int(self._isam.treeNnz())

    def joint_covariance(self, landmarks: IntArray) -> FloatArray:
        """Covariance of the pose and the given k landmarks, (3 + 2k, 3 + 2k) float64."""
        keys = [_x(self._steps), *(_l(int(i)) for i in landmarks)]
        P = np.array(self._isam.jointMarginalCovariance(keys).fullMatrix())
        turn = np.eye(len(P))
        turn[:2, :2] = rotation(self._pose[2])
        P = turn @ P @ turn.T
        if self._predicted is not None:
            F = np.eye(len(P))
            F[:3, :3] = self._predicted.F_R
            P = F @ P @ F.T
            P[:3, :3] = self._predicted.covariance
        return np.asarray(0.5 * (P + P.T))

    def predict(self, odometry: Odometry) -> None:
        """Note a motion; iSAM2 takes it together with its picture.

        Raises
        ------
        VslamError
            When the increment is not finite or its covariance not positive semi-definite.
        """
        check_odometry(odometry)
        if self._predicted is not None:
            self._take_motion()
        gtsam, delta = self._gtsam, odometry.delta
        # GTSAM's noise is in the tangent space at the increment, that is in axes turned by Δθ.
        turn = np.eye(3)
        turn[:2, :2] = rotation(delta[2]).T
        Q = turn @ odometry.covariance @ turn.T + _FLOOR * np.eye(3)
        noise = gtsam.noiseModel.Gaussian.Covariance(0.5 * (Q + Q.T))
        here, there = _x(self._steps), _x(self._steps + 1)
        self._add(gtsam.BetweenFactorPose2(here, there, gtsam.Pose2(*delta), noise))
        F_R, F_n = motion_jacobians(self._pose, delta)
        covariance = F_R @ self._P_RR @ F_R.T + F_n @ odometry.covariance @ F_n.T
        self._predicted = _Predicted(move(self._pose, delta), covariance, F_R)
        self._new_values.insert(there, gtsam.Pose2(*self._predicted.pose))

    def update(self, observations: Observations, hypothesis: IntArray) -> IntArray:
        """Add a factor per observation and let iSAM2 solve; see `vslam.slam_backend.Backend.update`.

        Raises
        ------
        VslamError
            As `FullCovariance.update`.
        """
        check_observations(observations)
        matches = np.array(hypothesis, dtype=np.int64)
        check_hypothesis(observations, matches, self._count)
        pose = self.pose
        key = _x(self._steps + (self._predicted is not None))
        for i in np.flatnonzero(matches == NEW):
            matches[i] = self._count
            point = pose[:2] + rotation(pose[2]) @ observations.points[i]
            self._new_values.insert(_l(self._count), point)
            self._count += 1
        kept = matches >= 0
        if kept.any():
            self._observe(key, observations, kept, matches[kept].tolist())
        self._take_motion()
        return matches

    def smooth(self) -> Smoothed:
        """Levenberg–Marquardt over all factors, from iSAM2's estimate.

        Raises
        ------
        VslamError
            When it does not end in finite numbers.
        """
        gtsam = self._gtsam
        optimiser = gtsam.LevenbergMarquardtOptimizer(self._everything, self._isam.calculateBestEstimate())
        values = optimiser.optimize()
        poses = np.array([_vector(values.atPose2(_x(k))) for k in range(self._steps + 1)])
        landmarks = self._positions(values)
        if not (np.isfinite(poses).all() and np.isfinite(landmarks).all()):
            raise VslamError("smoothing ended in values that are not finite")
        poses[:, 2] = np.unwrap(poses[:, 2])
        return Smoothed(poses[1:], landmarks)

    def _observe(self, pose: int, observations: Observations, kept: Any, numbers: list[int]) -> None:
        """Factors of one picture, for iSAM2 and for smoothing."""
        chosen = Observations(
            observations.points[kept], observations.covariances[kept], observations.ids[kept]
        )
        polar = zip(*RangeBearing().measure(chosen), strict=True)
        cartesian = zip(chosen.points, chosen.covariances, strict=True)
        for number, (z, S), (point, S_point) in zip(numbers, polar, cartesian, strict=True):
            factor = self._bearing_range(pose, _l(number), z, S)
            self._new_factors.add(factor)
            if self.model.name == "cartesian":
                factor = self._point_seen(pose, _l(number), point, S_point)
            self._everything.add(factor)

    def _bearing_range(self, pose: int, landmark: int, z: FloatArray, S: FloatArray) -> Any:
        gtsam = self._gtsam
        # GTSAM stacks bearing before range.
        noise = self._loss(gtsam.noiseModel.Gaussian.Covariance(np.ascontiguousarray(S[::-1, ::-1])))
        return gtsam.BearingRangeFactor2D(pose, landmark, gtsam.Rot2(z[1]), z[0], noise)

    def _point_seen(self, pose: int, landmark: int, z: FloatArray, S: FloatArray) -> Any:
        """Rot(θ)ᵀ (L − p) − z, with the pose's derivatives in its own axes as GTSAM has them."""
        gtsam = self._gtsam

        def error(this: Any, values: Any, H: Any) -> FloatArray:
            robot = values.atPose2(pose)
            local = robot.transformTo(values.atPoint2(landmark))
            if H is not None:
                H[0] = np.array([[-1.0, 0.0, local[1]], [0.0, -1.0, -local[0]]])
                H[1] = robot.rotation().matrix().T
            return np.asarray(local - z)

        return gtsam.CustomFactor(
            self._loss(gtsam.noiseModel.Gaussian.Covariance(S)), [pose, landmark], error
        )

    def _loss(self, noise: Any) -> Any:
        if self._robust == "none":
            return noise
        of_gtsam = self._gtsam.noiseModel
        loss = getattr(of_gtsam.mEstimator, _GTSAM_NAMES[self._robust])
        return of_gtsam.Robust.Create(loss.Create(ROBUST[self._robust]), noise)

    def _positions(self, values: Any) -> FloatArray:
        return np.array([values.atPoint2(_l(i)) for i in range(self._count)]).reshape(-1, 2)

    def _add(self, factor: Any) -> None:
        self._new_factors.add(factor)
        self._everything.add(factor)

    def _take_motion(self) -> None:
        predicted = self.pose
        self._steps += self._predicted is not None
        self._optimise()
        estimate = _vector(self._isam.calculateEstimatePose2(_x(self._steps)))
        self._pose = estimate
        self._pose[2] = predicted[2] + wrap_angle(estimate[2] - predicted[2])
        self._predicted = None
        # GTSAM's tangent space is in the robot's axes.
        turn = np.eye(3)
        turn[:2, :2] = rotation(estimate[2])
        P = turn @ self._isam.marginalCovariance(_x(self._steps)) @ turn.T
        self._P_RR = 0.5 * (P + P.T)

    def _optimise(self) -> None:
        try:
            self._isam.update(self._new_factors, self._new_values)
        except RuntimeError as error:
            reason = " ".join(str(error).split())
            raise VslamError(f"iSAM2 cannot solve the graph: {reason[:200]}") from None
        self._new_factors, self._new_values = self._gtsam.NonlinearFactorGraph(), self._gtsam.Values()


def _isam(gtsam: Any, relinearise: float, factorisation: str) -> Any:
    parameters = gtsam.ISAM2Params()
    parameters.setFactorization(factorisation)
    parameters.setRelinearizeThreshold(relinearise)
    parameters.relinearizeSkip = 10
    return gtsam.ISAM2(parameters)


def _x(step: int) -> int:
    """Key of the pose after a step, 0 the start."""
    return (ord("x") << 56) | step


def _l(number: int) -> int:
    """Key of a landmark."""
    return (ord("l") << 56) | number


def _vector(pose: Any) -> FloatArray:
    return np.array([pose.x(), pose.y(), pose.theta()])
