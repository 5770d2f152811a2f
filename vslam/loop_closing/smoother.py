"""Smoothing of track and map: nonlinear least squares over all poses and landmarks (√SAM, Dellaert &
Kaess 2006).

minimise  Σ_k |u_k − (R_{k−1}⁻¹ R_k)|²_Q  +  Σ_i c²/2 · log(1 + |z_i − h(R, L)|²_S / c²)

Robust (Cauchy's loss, by iterated reweighting), as a false observation or a wrong pairing must not bend the
track. Every term is linearised in one vectorised pass and the normal equations are solved by SuperLU:
for such chain-like problems that takes less time than building GTSAM's factors one by one from
Python, which merging fragments would ask for again and again. A test holds both to the same optimum.
The first pose is the frame, so it is no unknown.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import SuperLU, splu

from vslam.errors import VslamError
from vslam.geometry import wrap_angle

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

CAUCHY = 2.385
"""c of Cauchy's loss, in σ: 95 % efficient where the noise is Gaussian after all (Zhang 1997, table 1)."""

LEAST_SQUARES = float("inf")
"""c with which every residual counts in full."""

_LARGEST_DAMPING = 1e8


@dataclass(frozen=True, eq=False)
class Problem:
    """What was measured. Pose 0 is the start; step k leads from pose k to pose k + 1.

    Attributes
    ----------
    deltas : (n, 3) float64
        Odometry increments, metres and rad.
    roots : (n, 3, 3) float64
        W with Wᵀ W = Q⁻¹.
    pose : (m,) int64
        Pose of each observation, 1 … n.
    landmark : (m,) int64
        Landmark of each observation, 0 …
    points : (m, 2) float64
        Where it was seen, robot's frame, metres.
    point_roots : (m, 2, 2) float64
        W with Wᵀ W = S⁻¹.
    """

    deltas: FloatArray
    roots: FloatArray
    pose: IntArray
    landmark: IntArray
    points: FloatArray
    point_roots: FloatArray


@dataclass(frozen=True, eq=False)
class Estimate:
    """Poses and landmarks at a minimum.

    Attributes
    ----------
    poses : (n + 1, 3) float64
        The start included; headings not wrapped.
    landmarks : (l, 2) float64
    cost : float
        Half the robust sum of squares.
    factor : SuperLU
        Of the information matrix over poses 1 … n, then landmarks.
    """

    poses: FloatArray
    landmarks: FloatArray
    cost: float
    factor: SuperLU

    def covariance(self, landmarks: IntArray) -> FloatArray:
        """Joint covariance of k landmarks, (2k, 2k) float64, m²."""
        rows = 3 * (len(self.poses) - 1) + (2 * np.asarray(landmarks)[:, None] + np.arange(2)).ravel()
        return self._covariance(rows)

    def pose_covariance(self, pose: int) -> FloatArray:
        """Covariance of pose 1 … n, (3, 3) float64."""
        return self._covariance(3 * (pose - 1) + np.arange(3))

    def _covariance(self, rows: IntArray) -> FloatArray:
        unit = np.zeros((self.factor.shape[0], len(rows)))
        unit[rows, np.arange(len(rows))] = 1.0
        block = self.factor.solve(unit)[rows]
        return 0.5 * (block + block.T)


def inverse_roots(covariances: FloatArray) -> FloatArray:
    """W with Wᵀ W = covariance⁻¹, (n, k, k)."""
    return np.linalg.inv(np.linalg.cholesky(covariances)) if len(covariances) else covariances


def smooth(
    problem: Problem,
    poses: FloatArray,
    landmarks: FloatArray,
    iterations: int = 20,
    tolerance: float = 1e-5,
    cauchy: float = CAUCHY,
) -> Estimate:
    """Levenberg–Marquardt from a first guess until no unknown moves by more than ``tolerance`` (metres, rad).

    Parameters
    ----------
    problem : Problem
    poses : (n + 1, 3) float64
    landmarks : (l, 2) float64
        Each must be observed.
    iterations : int
        Linearisations at most.
    tolerance : float
    cauchy : float
        c of the loss of observations.

    Raises
    ------
    VslamError
        When the problem has no unique solution.
    """
    poses, landmarks = poses.copy(), landmarks.copy()
    damping, n = 0.0, len(problem.deltas)
    residuals, cost = _residuals(problem, poses, landmarks, cauchy)
    factor: SuperLU | None = None
    for _ in range(iterations):
        J, r = _linearise(problem, poses, landmarks, residuals, cauchy)
        information, gradient = (J.T @ J).tocsc(), J.T @ r
        while True:
            factor = _factor(information, damping)
            step = factor.solve(-gradient)
            moved = poses.copy()
            moved[1:] += step[: 3 * n].reshape(-1, 3)
            shifted = landmarks + step[3 * n :].reshape(-1, 2)
            tried, tried_cost = _residuals(problem, moved, shifted, cauchy)
            if tried_cost <= cost * (1 + 1e-9) or damping > _LARGEST_DAMPING:
                break
            damping = max(10.0 * damping, 1e-4)
        if tried_cost > cost * (1 + 1e-9):
            break
        poses, landmarks, residuals, cost = moved, shifted, tried, tried_cost
        damping = 0.0 if damping < 1e-3 else damping / 10.0
        if np.abs(step).max(initial=0.0) < tolerance:
            break
    if factor is None or damping > 0.0:
        J, _ = _linearise(problem, poses, landmarks, residuals, cauchy)
        factor = _factor((J.T @ J).tocsc(), 0.0)
    return Estimate(poses, landmarks, cost, factor)


def _residuals(
    problem: Problem, poses: FloatArray, landmarks: FloatArray, cauchy: float
) -> tuple[tuple[FloatArray, FloatArray], float]:
    """Whitened residuals of odometry (n, 3) and observations (m, 2), and half the robust sum."""
    a, b = poses[:-1], poses[1:]
    motion = np.column_stack([_local(a, b[:, :2]), b[:, 2] - a[:, 2]]) - problem.deltas
    motion[:, 2] = wrap_angle(motion[:, 2])
    motion = (problem.roots @ motion[..., None])[..., 0]
    sight = _local(poses[problem.pose], landmarks[problem.landmark]) - problem.points
    sight = (problem.point_roots @ sight[..., None])[..., 0]
    squares = (sight**2).sum(axis=1)
    losses = squares if np.isinf(cauchy) else cauchy**2 * np.log1p(squares / cauchy**2)
    return (motion, sight), 0.5 * float((motion**2).sum()) + 0.5 * float(losses.sum())


def _linearise(
    problem: Problem,
    poses: FloatArray,
    landmarks: FloatArray,
    residuals: tuple[FloatArray, FloatArray],
    cauchy: float,
) -> tuple[sp.csr_matrix, FloatArray]:
    """Whitened, reweighted Jacobian and residual."""
    motion, sight = residuals
    n, m = len(problem.deltas), len(problem.points)
    by_a, by_b = _local_jacobians(poses[:-1], poses[1:, :2])
    A, B = np.zeros((n, 3, 3)), np.zeros((n, 3, 3))
    A[:, :2], B[:, :2, :2] = by_a, by_b
    A[:, 2, 2], B[:, 2, 2] = -1.0, 1.0
    by_pose, by_landmark = _local_jacobians(poses[problem.pose], landmarks[problem.landmark])
    weights = 1.0 / np.sqrt(1.0 + (sight**2).sum(axis=1) / cauchy**2)  # √ of Cauchy's weight
    W = problem.point_roots * weights[:, None, None]

    steps = np.arange(n)
    row = 3 * steps
    blocks = [
        # The first step leaves the fixed start: it has no left block.
        _block(row[1:], 3 * (steps[1:] - 1), (problem.roots @ A)[1:]),
        _block(row, 3 * steps, problem.roots @ B),
        _block(3 * n + 2 * np.arange(m), 3 * (problem.pose - 1), W @ by_pose),
        _block(3 * n + 2 * np.arange(m), 3 * n + 2 * problem.landmark, W @ by_landmark),
    ]
    rows, columns, data = (np.concatenate(part) for part in zip(*blocks, strict=True))
    shape = (3 * n + 2 * m, 3 * n + 2 * len(landmarks))
    r = np.concatenate([motion.ravel(), (sight * weights[:, None]).ravel()])
    return sp.csr_matrix((data, (rows, columns)), shape), r


def _local(poses: FloatArray, points: FloatArray) -> FloatArray:
    """Each point in the frame of its pose (eq. 3-6), (n, 2)."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    x, y = (points - poses[:, :2]).T
    return np.column_stack([c * x + s * y, -s * x + c * y])


def _local_jacobians(poses: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Derivatives of `_local` by pose (n, 2, 3) and by point (n, 2, 2)."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    by_point = np.stack([np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)], axis=1)
    local = _local(poses, points)
    by_pose = np.concatenate([-by_point, np.stack([local[:, 1], -local[:, 0]], axis=-1)[..., None]], axis=2)
    return by_pose, by_point


def _block(rows: IntArray, columns: IntArray, blocks: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Coordinates and values of dense (n, a, b) blocks at the given corners."""
    _, a, b = blocks.shape
    i = np.broadcast_to(rows[:, None, None] + np.arange(a)[:, None], blocks.shape)
    j = np.broadcast_to(columns[:, None, None] + np.arange(b), blocks.shape)
    return i.ravel(), j.ravel(), blocks.ravel()


def _factor(information: sp.csc_matrix, damping: float) -> SuperLU:
    if damping > 0.0:
        information = information + damping * sp.diags(information.diagonal())
    try:
        return splu(
            information.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError as error:
        raise VslamError(f"the smoothing problem has no unique solution: {error}") from None
