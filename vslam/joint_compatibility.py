"""Joint compatibility branch and bound (Neira & Tardós 2001, sections IV and V).

A hypothesis is jointly compatible when the squared Mahalanobis distance of all its innovations together,
D² = Zᵀ C⁻¹ Z, lies under the χ² quantile of their degrees of freedom. C = H P Hᵀ + S has the full
cross-covariances between pairings: errors of the robot's pose and of neighbouring landmarks shift all
innovations alike, and that is what the joint test knows and individual gates do not.

The search walks the interpretation tree, an observation per level, and keeps C's Cholesky factor, so that
a pairing costs one forward substitution. Among hypotheses with the most pairings the one with the smallest D²
wins; this also decides ties, which the paper leaves open.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.stats import chi2

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

BUDGET = 20_000
"""Joint tests of one picture at most, about 10 ms; then the best hypothesis so far stands."""


def joint_bounds(gate: float, most: int) -> FloatArray:
    """χ² quantiles of ``gate`` for 0 … ``most`` pairings of two degrees of freedom each; the first is 0."""
    return np.append(0.0, chi2.ppf(gate, 2 * np.arange(1, most + 1)))


@njit(cache=True)
def branch_and_bound(
    Z: FloatArray,
    projected: FloatArray,
    S: FloatArray,
    distances: FloatArray,
    compatible: BoolArray,
    bounds: FloatArray,
    budget: int,
) -> tuple[IntArray, int]:
    """Find the largest jointly compatible hypothesis.

    Parameters
    ----------
    Z : (n, m, 2) float64
        Innovation of each observation with each landmark.
    projected : (2m, 2m) float64
        H P Hᵀ of all landmarks, their cross-covariances included.
    S : (n, 2, 2) float64
        Noise of each observation, independent of each other.
    distances : (n, m) float64
        Individual squared Mahalanobis distances: the order in which branches are tried.
    compatible : (n, m) bool
        Individually compatible pairings, the only ones considered.
    bounds : (n + 1,) float64
        χ² quantile for k pairings, 2k degrees of freedom; entry 0 is not used.
    budget : int
        Joint tests at most. Nearest pairings are tried first, so a search that is cut short has at least the
        hypothesis of sequential nearest neighbours under the joint test.

    Returns
    -------
    (n,) int64
        Landmark of each observation, −1 for none.
    int
        Joint tests made; ``budget`` if the search was cut short.
    """
    n, m = compatible.shape
    # Branches of each level, nearest first.
    branches = np.full((n, m), -1, np.int64)
    width = np.zeros(n, np.int64)
    for i in range(n):
        for j in np.argsort(distances[i]):
            if compatible[i, j]:
                branches[i, width[i]] = j
                width[i] += 1
    # How many pairings the levels from i on can add.
    rest = np.zeros(n + 1, np.int64)
    for i in range(n - 1, -1, -1):
        rest[i] = rest[i + 1] + (1 if width[i] > 0 else 0)

    best = np.full(n, -1, np.int64)
    best_size, best_distance = 0, 0.0
    chosen = np.full(n, -1, np.int64)
    taken = np.zeros(m, np.bool_)
    turn = np.zeros(n + 1, np.int64)  # next branch of each level; branch width[i] is the star node
    owner = np.zeros(n, np.int64)  # observation of each pairing
    L = np.zeros((2 * n, 2 * n))  # Cholesky factor of C, and L⁻¹ Z
    w = np.zeros(2 * n)
    D2 = np.zeros(n + 1)
    size, level, tests = 0, 0, 0

    while level >= 0:
        back = False
        if level == n:
            if size > best_size or (size == best_size and D2[size] < best_distance):
                best_size, best_distance = size, D2[size]
                best[:] = chosen
            back = True
        elif turn[level] > width[level]:
            back = True
        elif turn[level] == 0 and (
            size + rest[level] < best_size
            or (size + rest[level] == best_size and D2[size] >= best_distance and best_size > 0)
        ):
            back = True  # bound: D² only grows
        if back:
            turn[level] = 0
            level -= 1
            if level >= 0 and chosen[level] >= 0:
                taken[chosen[level]] = False
                chosen[level] = -1
                size -= 1
            continue
        k = turn[level]
        turn[level] += 1
        if k == width[level]:  # star node: this observation is paired with nothing
            if size + rest[level + 1] >= best_size:
                level += 1
                turn[level] = 0
            continue
        j = branches[level, k]
        if taken[j]:
            continue
        if tests >= budget:
            break
        tests += 1
        d = _extend(L, w, owner, chosen, size, level, j, Z, projected, S)
        if d < 0.0 or D2[size] + d > bounds[size + 1]:
            continue
        chosen[level] = j
        taken[j] = True
        owner[size] = level
        size += 1
        D2[size] = D2[size - 1] + d
        level += 1
        turn[level] = 0
    if tests >= budget and size > best_size:
        best[:] = chosen
    return best, tests


@njit(cache=True)
def _extend(
    L: FloatArray,
    w: FloatArray,
    owner: IntArray,
    chosen: IntArray,
    size: int,
    i: int,
    j: int,
    Z: FloatArray,
    projected: FloatArray,
    S: FloatArray,
) -> float:
    """Append a pairing to the Cholesky factor; how much D² grows, or −1 where C is not positive definite."""
    r = 2 * size
    for a in range(2):
        row = r + a
        for q in range(size):
            other = chosen[owner[q]]
            for b in range(2):
                column = 2 * q + b
                total = projected[2 * j + a, 2 * other + b]
                for t in range(column):
                    total -= L[row, t] * L[column, t]
                L[row, column] = total / L[column, column]
        for b in range(a + 1):
            column = r + b
            total = projected[2 * j + a, 2 * j + b] + S[i, a, b]
            for t in range(column):
                total -= L[row, t] * L[column, t]
            if b < a:
                L[row, column] = total / L[column, column]
            elif total <= 0.0:
                return -1.0
            else:
                L[row, row] = np.sqrt(total)
        total = Z[i, j, a]
        for t in range(row):
            total -= L[row, t] * w[t]
        w[row] = total / L[row, row]
    return w[r] ** 2 + w[r + 1] ** 2
