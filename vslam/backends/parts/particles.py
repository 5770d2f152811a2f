"""What both FastSLAMs share: particles, each a pose with a Kalman filter per landmark, and their resampling.

Sources: Montemerlo, Thrun, Koller & Wegbreit 2002, "FastSLAM: a factored solution to the simultaneous
localization and mapping problem"; Thrun, Burgard & Fox 2005, *Probabilistic Robotics*, chapter 13. Effective
sample size: Liu & Chen 1998, eq. 7, with their threshold of half the particles; systematic resampling:
Kitagawa 1996, appendix.

Given the robot's path the landmarks are independent, so a particle needs a 2 × 2 covariance for each and no
cross-covariances. Arrays run over particles first: N particles, n landmarks.

N samples resolve a density no finer than a kernel about each (Musso, Oudjane & Le Gland 2001, section 12.3),
and after a picture that one particle explains best, all are copies of it. The covariances reported therefore
hold such a kernel, of the last step's proposal; the particles themselves are left as they are.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from vslam.backends.parts import many_poses
from vslam.backends.parts.input_checks import check_hypothesis, check_observations
from vslam.errors import VslamError
from vslam.frame import Observations
from vslam.observation import ObservationModel
from vslam.slam_backend import NEW

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

PARTICLES = 100
_CHUNK = 64


class Particles(ABC):
    """The particle set, and everything of a `vslam.slam_backend.Backend` but the proposal.

    Parameters
    ----------
    model : ObservationModel
        How a landmark is measured.
    seed : int
        Of the particles' noise and their resampling, ≥ 0.
    particles : int
        N, ≥ 2.

    Raises
    ------
    VslamError
        For fewer than two particles.
    """

    def __init__(self, model: ObservationModel, seed: int = 0, particles: int = PARTICLES) -> None:
        if particles < 2:
            raise VslamError(f"{particles} particles: a distribution needs at least 2")
        self.model = model
        self._rng = np.random.default_rng(seed)
        self._poses = np.zeros((particles, 3))
        self._log_weights = np.full(particles, -np.log(particles))
        self._kernel = np.zeros((3, 3))
        self._count = 0
        self._means = np.zeros((particles, _CHUNK, 2))
        self._covariances = np.zeros((particles, _CHUNK, 2, 2))

    @property
    def weights(self) -> FloatArray:
        """(N,) float64, summing to 1."""
        return np.exp(self._log_weights)

    @property
    def effective_size(self) -> float:
        """N_eff = 1 / Σ w², 1 … N."""
        return float(1.0 / np.sum(self.weights**2))

    @property
    def pose(self) -> FloatArray:
        """(3,) float64: the particles' mean; headings are not wrapped, so they have one."""
        return np.asarray(self.weights @ self._poses)

    @property
    def pose_covariance(self) -> FloatArray:
        """Covariance of the particles, and of the kernel that each of them stands for, (3, 3) float64."""
        off = self._poses - self.pose
        return np.asarray((self.weights[:, None] * off).T @ off) + self._kernel

    @property
    def landmarks(self) -> FloatArray:
        """(n, 2) float64, metres: means over the particles."""
        return np.asarray(np.tensordot(self.weights, self._means[:, : self._count], axes=1))

    @property
    def landmark_covariances(self) -> FloatArray:
        """(n, 2, 2) float64, m²: of the mixture."""
        off = self._means[:, : self._count] - self.landmarks
        w = self.weights
        within = np.tensordot(w, self._covariances[:, : self._count], axes=1)
        return np.asarray(within + np.einsum("m,mki,mkj->kij", w, off, off))

    @property
    def cross_covariances(self) -> FloatArray:
        """P_RL of each landmark over the particles, (n, 3, 2) float64."""
        off = self._means[:, : self._count] - self.landmarks
        return np.einsum("m,mi,mkj->kij", self.weights, self._poses - self.pose, off)

    @property
    def covariance(self) -> FloatArray:
        """P of the mixture, (3 + 2n, 3 + 2n) float64."""
        return self.joint_covariance(np.arange(self._count))

    @property
    def memory_bytes(self) -> int:
        """Bytes of poses, weights, and every particle's landmarks."""
        arrays = (self._poses, self._log_weights, self._means, self._covariances)
        return sum(a.nbytes for a in arrays)

    def joint_covariance(self, landmarks: IntArray) -> FloatArray:
        """Covariance of the pose and the given k landmarks, (3 + 2k, 3 + 2k) float64."""
        numbers = np.asarray(landmarks, dtype=np.int64)
        flat = self._means[:, numbers].reshape(len(self._poses), -1)
        state = np.hstack([self._poses, flat])
        off = state - self.weights @ state
        P = (self.weights[:, None] * off).T @ off
        P[:3, :3] += self._kernel
        within = np.tensordot(self.weights, self._covariances[:, numbers], axes=1)
        for i, block in enumerate(within):
            P[3 + 2 * i : 5 + 2 * i, 3 + 2 * i : 5 + 2 * i] += block
        return np.asarray(P)

    def update(self, observations: Observations, hypothesis: IntArray) -> IntArray:
        """Weigh and correct with the matched observations, found the new ones, resample when due.

        See `vslam.slam_backend.Backend.update`.

        Raises
        ------
        VslamError
            As `FullCovariance.update`; also when no particle explains a picture.
        """
        check_observations(observations)
        matches = np.array(hypothesis, dtype=np.int64)
        check_hypothesis(observations, matches, self._count)
        z, S = self.model.measure(observations) if len(matches) else (np.zeros((0, 2)), np.zeros((0, 2, 2)))
        matched, new = matches >= 0, matches == NEW
        self._weigh(self._sample(z[matched], S[matched], matches[matched]))
        if matched.any():
            self._correct(z[matched], S[matched], matches[matched])
        if new.any():
            matches[new] = self._found(z[new], S[new])
        if self.effective_size < 0.5 * len(self._poses):
            self._resample()
        return matches

    @abstractmethod
    def _sample(self, z: FloatArray, S: FloatArray, numbers: IntArray) -> FloatArray:
        """Draw the particles' poses and return the logarithm of what multiplies each weight, (N,)."""

    def _noise(self, roots: FloatArray) -> FloatArray:
        """One draw from N(0, root rootᵀ) per particle, (N, 3); ``roots`` (3, 3) or (N, 3, 3)."""
        draws = self._rng.standard_normal((len(self._poses), 3, 1))
        return np.asarray((roots @ draws)[..., 0])

    def _weigh(self, log_likelihoods: FloatArray) -> None:
        weights = self._log_weights + log_likelihoods
        largest = weights.max()
        if not np.isfinite(largest):
            raise VslamError("no particle explains the picture; the filter has broken down")
        self._log_weights = weights - largest - np.log(np.exp(weights - largest).sum())

    def _correct(self, z: FloatArray, S: FloatArray, numbers: IntArray) -> None:
        """A Kalman update of each particle's seen landmarks (*Probabilistic Robotics*, table 13.1)."""
        means, P = self._means[:, numbers], self._covariances[:, numbers]
        _, H = many_poses.jacobians(self.model, self._poses, means)
        Z = self.model.innovation(z, many_poses.measure(self.model, self._poses, means))
        PHt = P @ H.swapaxes(-1, -2)
        K = PHt @ np.linalg.inv(H @ PHt + S)
        left = np.eye(2) - K @ H
        # Joseph's form: positive definite whatever the rounding.
        P = left @ P @ left.swapaxes(-1, -2) + K @ S @ K.swapaxes(-1, -2)
        self._means[:, numbers] = means + (K @ Z[..., None])[..., 0]
        self._covariances[:, numbers] = 0.5 * (P + P.swapaxes(-1, -2))

    def _found(self, z: FloatArray, S: FloatArray) -> IntArray:
        start, end = self._count, self._count + len(z)
        self._grow(end)
        every = np.broadcast_to(z, (len(self._poses), *z.shape))
        self._means[:, start:end] = many_poses.place(self.model, self._poses, every)
        G_z = many_poses.place_jacobians(self.model, self._poses, z)
        self._covariances[:, start:end] = G_z @ S @ G_z.swapaxes(-1, -2)
        self._count = end
        return np.arange(start, end)

    def _resample(self) -> None:
        chosen = systematic(self.weights, float(self._rng.random()))
        self._poses, self._means = self._poses[chosen], self._means[chosen]
        self._covariances = self._covariances[chosen]
        self._log_weights = np.full(len(chosen), -np.log(len(chosen)))

    def _grow(self, size: int) -> None:
        capacity = -(-size // _CHUNK) * _CHUNK
        more = capacity - self._means.shape[1]
        if more > 0:
            self._means = np.pad(self._means, ((0, 0), (0, more), (0, 0)))
            self._covariances = np.pad(self._covariances, ((0, 0), (0, more), (0, 0), (0, 0)))


def systematic(weights: FloatArray, start: float) -> IntArray:
    """Systematic resampling: one random number, N equally spaced pointers into the cumulated weights.

    Parameters
    ----------
    weights : (N,) float64, summing to 1
    start : float
        Uniform in [0, 1).

    Returns
    -------
    (N,) int64, rising: particle i occurs ⌊N w_i⌋ or ⌈N w_i⌉ times, N w_i on average.
    """
    n = len(weights)
    ends = np.cumsum(weights)
    ends[-1] = 1.0  # rounding must leave no pointer behind the end
    return np.asarray(np.searchsorted(ends, (start + np.arange(n)) / n, side="right"), dtype=np.int64)


def log_gaussian(Z: FloatArray, S: FloatArray) -> FloatArray:
    """Logarithm of the density of N(0, S) at Z, (…, 2) and (…, 2, 2) to (…)."""
    determinant = S[..., 0, 0] * S[..., 1, 1] - S[..., 0, 1] * S[..., 1, 0]
    squared = np.einsum("...i,...i->...", Z, np.linalg.solve(S, Z[..., None])[..., 0])
    return np.asarray(-0.5 * squared - 0.5 * np.log(determinant) - np.log(2.0 * np.pi))
