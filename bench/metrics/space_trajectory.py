"""Trajectories in space: what another system answered for a sequence, against the sequence's true poses.

Sources
-------
Absolute trajectory error (ATE) and relative pose error (RPE): Sturm, Engelhard, Endres, Burgard & Cremers
2012, "A benchmark for the evaluation of RGB-D SLAM systems", eqs. 1-4. Alignment: Umeyama 1991, eqs. 40-43.

Conventions
-----------
- A pose maps the body (camera or robot, the same in both tracks) to the world; metres, seconds.
- Poses are paired by time: the nearest true pose for each estimated one, none farther than the tolerance,
  each used once. What has no partner is not scored, but counted: a system that lost track must not look good.
- ``none`` compares as it is. ``se3`` first moves the estimate rigidly to where the squared position error is
  smallest, ``sim3`` scales it too, which a single camera without known scale needs. Each can only lower ATE.
- RPE is over neighbouring pairs, translation in metres, rotation in degrees. Only a scale changes it.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bench.errors import BenchError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class Alignment(StrEnum):
    """What moves the estimate onto the truth before it is compared."""

    none = "none"
    se3 = "se3"
    sim3 = "sim3"


@dataclass(frozen=True, eq=False)
class SpaceTrack:
    """A path of a body in space.

    Attributes
    ----------
    stamps : (n,) float64
        Seconds, increasing.
    positions : (n, 3) float64
        Metres.
    rotations : Rotation
        n of them, body to world.

    Raises
    ------
    BenchError
        When there is no pose, lengths differ, a value is not finite or time does not increase.
    """

    stamps: FloatArray
    positions: FloatArray
    rotations: Rotation

    def __post_init__(self) -> None:
        n = len(self.stamps)
        if n == 0 or self.positions.shape != (n, 3) or len(self.rotations) != n:
            raise BenchError(f"trajectory: {n} stamps for positions of shape {self.positions.shape}")
        if not (np.isfinite(self.stamps).all() and np.isfinite(self.positions).all()):
            raise BenchError("trajectory: holds a value that is not finite")
        late = np.flatnonzero(np.diff(self.stamps) <= 0)
        if len(late):
            raise BenchError(
                f"trajectory: time does not increase at pose {int(late[0]) + 2} "
                f"({self.stamps[late[0] + 1]:.6f} s after {self.stamps[late[0]]:.6f} s)"
            )

    def __len__(self) -> int:
        return len(self.stamps)

    def at(self, rows: IntArray) -> SpaceTrack:
        """The poses of some rows."""
        return SpaceTrack(self.stamps[rows], self.positions[rows], self.rotations[rows])


@dataclass(frozen=True)
class SpaceScores:
    """Scores of one track under one alignment.

    Attributes
    ----------
    ate_rmse_m, ate_median_m, ate_max_m : float
    rpe_rmse_m, rpe_rmse_deg : float
        NaN with a single pair.
    scale : float
        That the alignment applied to the estimate; 1 unless it is ``sim3``.
    """

    ate_rmse_m: float
    ate_median_m: float
    ate_max_m: float
    rpe_rmse_m: float
    rpe_rmse_deg: float
    scale: float


def associate(
    estimate: SpaceTrack, truth: SpaceTrack, tolerance_s: float = 0.02
) -> tuple[SpaceTrack, SpaceTrack]:
    """Pair the poses by time.

    Raises
    ------
    BenchError
        When no two poses are that close in time; it says which spans of time the two have.
    """
    right = np.clip(np.searchsorted(truth.stamps, estimate.stamps), 1, max(len(truth) - 1, 1))
    neighbours = np.stack([right - 1, np.minimum(right, len(truth) - 1)])
    gaps = np.abs(truth.stamps[neighbours] - estimate.stamps)
    nearest = neighbours[np.argmin(gaps, axis=0), np.arange(len(estimate))]
    gap = gaps.min(axis=0)
    order = np.lexsort((gap, nearest))  # of several that want one true pose, the closest gets it
    first = np.concatenate([[True], np.diff(nearest[order]) != 0])
    kept = np.sort(order[first & (gap[order] <= tolerance_s)])
    if not len(kept):
        spans = (f"{t.stamps[0]:.3f} … {t.stamps[-1]:.3f} s" for t in (estimate, truth))
        raise BenchError(
            f"no estimated pose is within {tolerance_s:g} s of a true one: the estimate spans {next(spans)}, "
            f"the truth {next(spans)}"
        )
    return estimate.at(kept), truth.at(nearest[kept])


def align(estimate: SpaceTrack, truth: SpaceTrack, alignment: Alignment) -> tuple[SpaceTrack, float]:
    """Move paired poses onto the truth; returns them and the scale applied.

    Raises
    ------
    BenchError
        When the estimate does not move, so that it has no scale.
    """
    if alignment is Alignment.none:
        return estimate, 1.0
    centre, target = estimate.positions.mean(axis=0), truth.positions.mean(axis=0)
    a, b = estimate.positions - centre, truth.positions - target
    U, D, Vt = np.linalg.svd(b.T @ a / len(a))  # Umeyama 1991, eq. 38
    S = np.diag([1.0, 1.0, np.sign(np.linalg.det(U) * np.linalg.det(Vt))])  # eqs. 39, 43: no reflection
    R, scale = U @ S @ Vt, 1.0  # eq. 40
    if alignment is Alignment.sim3:
        spread = (a**2).sum() / len(a)
        if spread == 0.0:
            raise BenchError("alignment: the estimate stands still and has no scale; align with se3")
        scale = float((D * np.diag(S)).sum() / spread)  # eq. 42
    moved = scale * a @ R.T + target  # eq. 41
    return SpaceTrack(estimate.stamps, moved, Rotation.from_matrix(R) * estimate.rotations), scale


def evaluate(estimate: SpaceTrack, truth: SpaceTrack, alignment: Alignment, step: int = 1) -> SpaceScores:
    """Score paired poses.

    Parameters
    ----------
    estimate, truth : SpaceTrack
        As `associate` pairs them.
    alignment : Alignment
    step : int
        How many pairs apart the poses of RPE are.

    Raises
    ------
    BenchError
        When they are not paired, or the step is not positive.
    """
    if len(estimate) != len(truth):
        raise BenchError(
            f"{len(estimate)} estimated poses for {len(truth)} true ones; pair them by time first"
        )
    if step < 1:
        raise BenchError(f"relative pose error: {step} pairs apart; give at least 1")
    moved, scale = align(estimate, truth, alignment)
    error = np.linalg.norm(moved.positions - truth.positions, axis=1)
    metres, degrees = relative_pose_errors(moved, truth, step)
    return SpaceScores(
        ate_rmse_m=_rms(error),
        ate_median_m=float(np.median(error)),
        ate_max_m=float(error.max()),
        rpe_rmse_m=_rms(metres),
        rpe_rmse_deg=_rms(degrees),
        scale=scale,
    )


def relative_pose_errors(
    estimate: SpaceTrack, truth: SpaceTrack, step: int = 1
) -> tuple[FloatArray, FloatArray]:
    """E_i = (Q_i⁻¹ Q_{i+Δ})⁻¹ (P_i⁻¹ P_{i+Δ}) (Sturm et al. 2012, eq. 1).

    Returns
    -------
    metres, degrees : (n − step,) float64
        Length of its translation and angle of its rotation.
    """
    motions = []
    for track in (truth, estimate):
        before, after = track.rotations[:-step], track.rotations[step:]
        shift = before.inv().apply(track.positions[step:] - track.positions[:-step])
        motions.append((before.inv() * after, shift))
    (true_turn, true_shift), (turn, shift) = motions
    metres = np.linalg.norm(shift - true_shift, axis=1)
    return metres, np.degrees((true_turn.inv() * turn).magnitude())


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")
