"""Sigma points over a sub-state: the two rules, and the exact conditional update of all that is left out.

A motion touches the pose alone, a measurement the pose and the landmarks seen. So sigma points are drawn over
that sub-state s (3 + 2k dimensions) and not over the whole X (1,155 on the DLR log). Nothing is lost: for
jointly Gaussian s and rest r, E[r | s] is linear in s, hence for any y = f(s) + noise

    Cov(r, y) = Cov(r, s) Cov(s, s)⁻¹ Cov(s, y)

holds exactly, whatever f (Lefebvre, Bruyninckx & De Schutter 2002, statistical linear regression; Särkkä
2013, *Bayesian Filtering and Smoothing*, section 5.1; the same argument as the conditionally linear models
of Morelande & Moran 2007). With P_ss = A Aᵀ, points s ± √c A e_i and D = Σ_i (y⁺_i − y⁻_i) e_iᵀ / (2 √c), the
regression matrix is H = D A⁻¹, and the rest of P is corrected as in a linear filter with that H.

For the unscented rule with n + κ = 3, whose spread √3 does not depend on the dimension, the result equals the
unscented filter over the whole state to rounding, if its Cholesky factor lists s first: the columns beyond s
do not move s, their points give f at the mean, and the central weight makes up for their number.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from vslam.errors import VslamError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Rule:
    """Where the points of an n-dimensional sub-state lie and how they weigh.

    Attributes
    ----------
    spread : float
        c: points at ± √c standard deviations, each of weight 1 / (2c).
    central : float
        Weight of the central point in the covariance; in the mean its weight is 1 − n/c.
    """

    spread: float
    central: float


def unscented(n: int) -> Rule:
    """Julier & Uhlmann 1997 with their n + κ = 3 for Gaussians, in the scaled form of Julier 2002.

    With α = 1, κ = 3 − n and β = 2 (van der Merwe 2004), the covariance's central weight is (1 − n/3) + 2.
    Though 1 − n/3 is negative beyond three dimensions, the covariance is positive semi-definite: taken about
    the central point all weights are positive, and one (y_0 − ȳ)(y_0 − ȳ)ᵀ is added.
    """
    return Rule(3.0, 3.0 - n / 3.0)


def cubature(n: int) -> Rule:
    """Third-degree spherical–radial rule of Arasaratnam & Haykin 2009, eq. 36: 2n points of equal weight."""
    return Rule(float(n), 0.0)


RuleOf = Callable[[int], Rule]


@dataclass(frozen=True, eq=False)
class Transformed:
    """Moments of y = f(s).

    Attributes
    ----------
    offset : (d,) float64
        ȳ − y_0, the mean from the value at the central point.
    slopes : (d, n) float64
        D: the regression on the whitened sub-state.
    deviations : (d, 2n + 1) float64
        Weighted so that their product with their transpose is Cov(y, y).
    """

    offset: FloatArray
    slopes: FloatArray
    deviations: FloatArray

    @property
    def covariance(self) -> FloatArray:
        """Cov(y, y), (d, d) float64."""
        return self.deviations @ self.deviations.T

    def residual(self, slopes: FloatArray, rule: Rule) -> FloatArray:
        """Deviations from a linear function of the whitened sub-state's first columns, (d, 2n + 1)."""
        n, used = self.slopes.shape[1], slopes.shape[1]
        left = self.deviations.copy()
        step = slopes * np.sqrt(0.5)  # √c e_i, times the root of its weight 1 / (2c)
        left[:, 1 : 1 + used] -= step
        left[:, 1 + n : 1 + n + used] += step
        return left


def offsets(n: int, rule: Rule) -> FloatArray:
    """Whitened points, (2n + 1, n): the centre, then + √c e_i, then − √c e_i."""
    steps = np.sqrt(rule.spread) * np.eye(n)
    return np.vstack([np.zeros((1, n)), steps, -steps])


def transform(differences: FloatArray, rule: Rule) -> Transformed:
    """Moments from the values at the points, given as (2n + 1, d) differences to the central value."""
    n = len(differences) // 2
    offset = differences[1:].sum(axis=0) / (2.0 * rule.spread)
    slopes = (differences[1 : 1 + n] - differences[1 + n :]).T / (2.0 * np.sqrt(rule.spread))
    deviations = np.sqrt(0.5 / rule.spread) * (differences - offset).T
    # The centre's weight may be negative; it is folded into the rest, of which the sum about ȳ knows it.
    return Transformed(offset, slopes, _fold(deviations, offset, n, rule))


def _fold(deviations: FloatArray, offset: FloatArray, n: int, rule: Rule) -> FloatArray:
    """Replace the central column so that D Dᵀ = Σ_{i ≥ 1} w_i d_i d_iᵀ + w_c μ μᵀ, with real columns alone.

    About the centre, Σ_{i ≥ 1} w_i d_i d_iᵀ about ȳ equals the sum about y_0 less (2 − n/c) μ μᵀ.
    """
    if rule.central >= 0.0:
        deviations[:, 0] = np.sqrt(rule.central) * offset
        return deviations
    about_centre = deviations + np.sqrt(0.5 / rule.spread) * offset[:, None]
    about_centre[:, 0] = np.sqrt(rule.central - 2.0 + n / rule.spread) * offset
    return about_centre


def factor(P: FloatArray) -> FloatArray:
    """Lower-triangular A with A Aᵀ = P; a direction without variance has a zero column.

    Raises
    ------
    VslamError
        When P is not positive semi-definite.
    """
    try:
        return np.asarray(np.linalg.cholesky(P), dtype=np.float64)
    except np.linalg.LinAlgError:
        return _semi_definite_factor(P)


def _semi_definite_factor(P: FloatArray) -> FloatArray:
    A, left = np.zeros_like(P), P.copy()
    tiny = 1e-12 * np.maximum(P.diagonal(), np.finfo(np.float64).tiny)
    for j in range(len(P)):
        if left[j, j] < -1e3 * tiny[j]:
            raise VslamError("a covariance is no longer positive semi-definite; the filter has broken down")
        if left[j, j] > tiny[j]:
            A[j:, j] = left[j:, j] / np.sqrt(left[j, j])
            left[j:, j:] -= np.outer(A[j:, j], A[j:, j])
    return A


def factors(S: FloatArray) -> FloatArray:
    """Lower-triangular roots of positive definite (k, 2, 2)."""
    return np.asarray(np.linalg.cholesky(S), dtype=np.float64)


def regression(slopes: FloatArray, A: FloatArray) -> FloatArray:
    """H = D A⁻¹; directions without variance get no slope."""
    if A.diagonal().all():
        return np.asarray(solve_triangular(A, slopes.T, lower=True, trans="T").T)
    return np.asarray(slopes @ np.linalg.pinv(A))


def lower_triangle(wide: FloatArray) -> FloatArray:
    """Tria of Arasaratnam & Haykin: lower-triangular S with S Sᵀ = wide wideᵀ, diagonal ≥ 0."""
    R: FloatArray = np.asarray(np.linalg.qr(wide.T, mode="r"))
    if len(R) < len(wide):
        R = np.vstack([R, np.zeros((len(wide) - len(R), len(wide)))])
    signs = np.where(R.diagonal() < 0.0, -1.0, 1.0)
    return np.asarray((signs[:, None] * R).T)
