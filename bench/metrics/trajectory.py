"""Trajectories: how far the estimated track lies from the true one, and whether the filter knew.

Sources
-------
Position RMSE: eq. 3-39. Squared error of each axis: eqs. 3-40 and 3-41. SE(2) alignment without scale:
Umeyama 1991, whose rotation has a closed form in the plane. Absolute and relative pose error: Sturm et al.
2012, section VI; ``rmse_aligned_m`` is their ATE, `relative_errors` their RPE. NEES: Bar-Shalom, Li &
Kirubarajan 2001, section 5.4.

Conventions
-----------
- Poses are (n, 3): x, y (metres), heading (rad), estimate and truth row by row, both in the frame of the
  first true pose. A heading may be wrapped or not.
- ``rmse_m`` compares as it is: the filter starts at the origin. ``rmse_aligned_m`` first moves the whole
  estimate rigidly to where the squared error is smallest; it is never larger.
- ``rmse_m``² = ``rmse_x_m``² + ``rmse_y_m``².
- NEES = eᵀ P⁻¹ e with e = (x, y, θ) error, θ wrapped into [−π, π). It is 3 on average for a consistent
  filter; above, the filter trusts itself too much. Steps whose P is singular (before any noise has
  entered) have none and are left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import chi2

from bench.errors import BenchError
from vslam.geometry import rotation, wrap_angle

FloatArray = NDArray[np.float64]

POSE_DOF = 3
RPE_STEPS = 10


@dataclass(frozen=True)
class TrajectoryScores:
    """Scores of one track; the names are those of `bench.schema.RUN_COLUMNS`.

    Attributes
    ----------
    rmse_m, rmse_aligned_m, rmse_x_m, rmse_y_m : float
        Metres, ≥ 0.
    sq_err_x_max, sq_err_y_max : float
        Largest squared error of an axis, m².
    nees : float
        Mean over the steps, ≥ 0; NaN without covariances.
    rpe_m, rpe_deg : float
        Root mean square of the relative pose error over `RPE_STEPS` steps, metres and degrees; NaN for
        shorter tracks.
    """

    rmse_m: float
    rmse_aligned_m: float
    rmse_x_m: float
    rmse_y_m: float
    sq_err_x_max: float
    sq_err_y_max: float
    nees: float
    rpe_m: float
    rpe_deg: float


def validate(estimated: ArrayLike, true: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Check a pair of tracks and return them as float64.

    Raises
    ------
    BenchError
        When they are not both (n, 3) with one n ≥ 1, or hold a value that is not finite.
    """
    tracks = np.asarray(estimated, dtype=np.float64), np.asarray(true, dtype=np.float64)
    for name, track in zip(("estimated", "true"), tracks, strict=True):
        if track.ndim != 2 or track.shape[1] != 3 or not len(track):
            raise BenchError(f"{name} track: expected poses (n, 3) with n ≥ 1, got shape {track.shape}")
        if not np.isfinite(track).all():
            raise BenchError(
                f"{name} track: row {int(np.argmin(np.isfinite(track).all(axis=1)))} is not finite"
            )
    if len(tracks[0]) != len(tracks[1]):
        raise BenchError(
            f"{len(tracks[0])} estimated poses for {len(tracks[1])} true ones; they must pair up"
        )
    return tracks


def position_rmse(estimated: ArrayLike, true: ArrayLike) -> float:
    """√( (1/n) Σ (X − X̂)² + (Y − Ŷ)² ), metres, without alignment (eq. 3-39)."""
    return float(np.sqrt(squared_errors(estimated, true).sum(axis=1).mean()))


def squared_errors(estimated: ArrayLike, true: ArrayLike) -> FloatArray:
    """(X_A − X_E)² and (Y_A − Y_E)² of each step (eqs. 3-41, 3-40), (n, 2) float64, m²."""
    estimate, truth = validate(estimated, true)
    return np.asarray((estimate[:, :2] - truth[:, :2]) ** 2)


def squared_error_range(estimated: ArrayLike, true: ArrayLike) -> FloatArray:
    """Smallest and largest squared error of x and y, [[x_min, x_max], [y_min, y_max]], m²."""
    errors = squared_errors(estimated, true)
    return np.stack([errors.min(axis=0), errors.max(axis=0)], axis=1)


def align(estimated: ArrayLike, true: ArrayLike) -> FloatArray:
    """Move the estimate rigidly onto the truth, least squares over the positions (Umeyama 1991, no scale).

    Returns
    -------
    (n, 3) float64: the moved poses.
    """
    estimate, truth = validate(estimated, true)
    centre, target = estimate[:, :2].mean(axis=0), truth[:, :2].mean(axis=0)
    a, b = estimate[:, :2] - centre, truth[:, :2] - target
    # The rotation that maximises Σ bᵀ Rot(φ) a; a proper one, so no reflection has to be ruled out.
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    return np.column_stack([a @ rotation(angle).T + target, estimate[:, 2] + angle])


def relative_errors(estimated: ArrayLike, true: ArrayLike, steps: int = RPE_STEPS) -> FloatArray:
    """How far the estimated motion over some steps is from the true one, for every start (Sturm 2012, eq. 2).

    Parameters
    ----------
    estimated, true : (n, 3) array_like
    steps : int
        ≥ 1.

    Returns
    -------
    (max(n − steps, 0), 2) float64, ≥ 0: length of the translation of (true motion)⁻¹ (estimated motion),
    metres, and its angle, rad.

    Raises
    ------
    BenchError
        As `validate`; also for steps < 1.
    """
    if steps < 1:
        raise BenchError(f"relative pose error: need at least 1 step, got {steps}")
    ours, theirs = (_motions(track, steps) for track in validate(estimated, true))
    way = ours[:, :2] - theirs[:, :2]  # a rotation in front of it changes no length
    return np.column_stack([np.hypot(way[:, 0], way[:, 1]), np.abs(wrap_angle(ours[:, 2] - theirs[:, 2]))])


def _motions(track: FloatArray, steps: int) -> FloatArray:
    """Each pose as seen from the one ``steps`` before."""
    start, end = track[:-steps], track[steps:]
    c, s = np.cos(start[:, 2]), np.sin(start[:, 2])
    x, y = (end - start)[:, :2].T
    return np.column_stack([c * x + s * y, c * y - s * x, end[:, 2] - start[:, 2]])


def nees(estimated: ArrayLike, true: ArrayLike, covariances: ArrayLike) -> FloatArray:
    """Normalised estimation error squared of the pose at each step.

    Parameters
    ----------
    estimated, true : (n, 3) array_like
    covariances : (n, 3, 3) array_like
        P_RR, m², m·rad, rad².

    Returns
    -------
    (n,) float64, ≥ 0; NaN where P_RR is not positive definite.
    """
    estimate, truth = validate(estimated, true)
    P = np.asarray(covariances, dtype=np.float64)
    if P.shape != (len(estimate), 3, 3) or not np.isfinite(P).all():
        raise BenchError(f"covariances: expected finite ({len(estimate)}, 3, 3), got shape {P.shape}")
    error = estimate - truth
    error[:, 2] = wrap_angle(error[:, 2])
    # Scaled to unit diagonal, since metres and radians have no common size to call a determinant small by.
    scale = np.sqrt(np.diagonal(P, axis1=1, axis2=2))
    definite = np.asarray((scale > 0.0).all(axis=1))
    result = np.full(len(estimate), np.nan)
    correlation = P[definite] / (scale[definite, :, None] * scale[definite, None, :])
    definite[definite] = np.linalg.eigvalsh(correlation)[:, 0] > np.finfo(np.float64).eps * POSE_DOF
    e = error[definite]
    result[definite] = np.einsum("ni,ni->n", e, np.linalg.solve(P[definite], e[:, :, None])[:, :, 0])
    return result


def nees_band(runs: int, confidence: float = 0.95, dof: int = POSE_DOF) -> tuple[float, float]:
    """Where the mean NEES of independent runs lies with the given probability if the filter is consistent.

    Parameters
    ----------
    runs : int
        Number of runs averaged, ≥ 1.
    confidence : float
        0…1, two-sided.
    dof : int
        Dimension of the error.

    Returns
    -------
    low, high : float
        Quantiles of χ²(runs · dof) / runs.
    """
    if runs < 1 or not 0.0 < confidence < 1.0:
        raise BenchError(f"NEES band: need runs ≥ 1 and 0 < confidence < 1, got {runs} and {confidence}")
    tail = (1.0 - confidence) / 2.0
    low, high = (float(chi2.ppf(p, df=runs * dof)) / runs for p in (tail, 1.0 - tail))
    return low, high


def evaluate(estimated: ArrayLike, true: ArrayLike, covariances: ArrayLike | None = None) -> TrajectoryScores:
    """All scores of one track.

    Parameters
    ----------
    estimated, true : (n, 3) array_like
    covariances : (n, 3, 3) array_like, optional
        P_RR of each pose, for the NEES.

    Raises
    ------
    BenchError
        As `validate`.
    """
    errors = squared_errors(estimated, true)
    x, y = np.sqrt(errors.mean(axis=0))
    x_max, y_max = errors.max(axis=0)
    per_step = np.array([np.nan]) if covariances is None else nees(estimated, true, covariances)
    known = per_step[np.isfinite(per_step)]
    relative = relative_errors(estimated, true)
    rpe = np.sqrt((relative**2).mean(axis=0)) if len(relative) else np.full(2, np.nan)
    return TrajectoryScores(
        rmse_m=position_rmse(estimated, true),
        rmse_aligned_m=position_rmse(align(estimated, true), true),
        rmse_x_m=float(x),
        rmse_y_m=float(y),
        sq_err_x_max=float(x_max),
        sq_err_y_max=float(y_max),
        nees=float(known.mean()) if len(known) else float("nan"),
        rpe_m=float(rpe[0]),
        rpe_deg=float(np.degrees(rpe[1])),
    )
