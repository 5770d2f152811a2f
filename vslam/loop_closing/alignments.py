"""The search behind `vslam.loop_closing.constellation`: every pair of query discs on every pair of
reference discs.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.special import gammaln

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

LENGTH_TOLERANCE_M = 0.15
"""Two sights of one distance differ by the errors of four discs: 0.09 m (σ) at the 0.045 m that the DLR log
states for one sight, 0.05 m for discs seen three times, which is what counts; three σ of that."""

SHORTEST_M, LONGEST_M = 1.5, 8.0
"""Distances of pairs: shorter ones give no direction, longer ones bend with the track."""

LARGEST_R_M = 0.3
"""No alignment is so vague that r should grow further."""

SMALLEST_R_M = 0.03
"""Nor so exact: a chance coincidence must not count as if discs were known to the millimetre."""

_MOST_ROWS = 4096


def alignments(
    query: FloatArray,
    reference: FloatArray,
    discs_per_m2: float,
    log_limit: float,
    largest_turn: float,
    largest_shift: float,
) -> tuple[FloatArray, int]:
    """Try alignments; parameters as of `vslam.loop_closing.constellation.recognise`.

    Returns
    -------
    (k, 6) float64
        log10 of the binomial tail, cos, sin, x, y, r of those that may be significant; the best if they are
        more than 4,096.
    int
        N, how many were tried.
    """
    pairs, lengths = _pairs(reference)
    order = np.argsort(lengths, kind="stable")
    origin, cells = _grid(reference)
    return _search(
        np.ascontiguousarray(query),
        reference,
        pairs[order],
        lengths[order],
        origin,
        cells,
        discs_per_m2,
        _log_binomials(len(query)),
        log_limit,
        float(np.cos(min(largest_turn, np.pi))),
        float(largest_shift),
    )


def _pairs(points: FloatArray) -> tuple[IntArray, FloatArray]:
    """Ordered pairs of points at usable distances, (p, 2), and their lengths."""
    pairs = (
        cKDTree(points).query_pairs(LONGEST_M + LENGTH_TOLERANCE_M, output_type="ndarray").astype(np.int64)
    )
    pairs = np.vstack([pairs, pairs[:, ::-1]])
    lengths = np.hypot(*(points[pairs[:, 1]] - points[pairs[:, 0]]).T)
    usable = lengths > SHORTEST_M - LENGTH_TOLERANCE_M
    return pairs[usable], lengths[usable]


@njit(cache=True)
def _grid(points: FloatArray) -> tuple[FloatArray, IntArray]:
    """The point nearest to the centre of each cell of 0.1 m, −1 where none is near."""
    origin = np.array([points[:, 0].min(), points[:, 1].min()]) - LARGEST_R_M - 0.1
    columns = int((points[:, 0].max() - origin[0] + LARGEST_R_M + 0.1) * 10.0) + 1
    rows = int((points[:, 1].max() - origin[1] + LARGEST_R_M + 0.1) * 10.0) + 1
    cells = np.full((columns, rows), -1, np.int64)
    for k in range(len(points)):
        x, y = points[k, 0] - origin[0], points[k, 1] - origin[1]
        reach = int(LARGEST_R_M * 10.0) + 1
        for i in range(max(0, int(x * 10.0) - reach), min(columns, int(x * 10.0) + reach + 1)):
            for j in range(max(0, int(y * 10.0) - reach), min(rows, int(y * 10.0) + reach + 1)):
                other = cells[i, j]
                u, v = (i + 0.5) / 10.0, (j + 0.5) / 10.0
                if other < 0 or (u - x) ** 2 + (v - y) ** 2 < (
                    (u - points[other, 0] + origin[0]) ** 2 + (v - points[other, 1] + origin[1]) ** 2
                ):
                    cells[i, j] = k
    return origin, cells


def _log_binomials(n: int) -> FloatArray:
    """log10 of n − 2 over k, for k = 0 … n − 2."""
    k = np.arange(max(n - 1, 1))
    return (gammaln(n - 1) - gammaln(k + 1) - gammaln(n - 1 - k)) / np.log(10.0)


@njit(cache=True)
def _search(
    query: FloatArray,
    reference: FloatArray,
    pairs: IntArray,
    lengths: FloatArray,
    origin: FloatArray,
    cells: IntArray,
    density: float,
    log_binomials: FloatArray,
    log_limit: float,
    least_cosine: float,
    largest_shift: float,
) -> tuple[FloatArray, int]:
    """Rows (log10 of the binomial tail, cos, sin, x, y, r) of alignments that may be significant, and N."""
    n = len(query)
    rows = np.empty((_MOST_ROWS, 6))
    count, tried = 0, 0
    squares = np.empty(n)
    gx, gy = np.mean(query[:, 0]), np.mean(query[:, 1])
    for a in range(n):
        for b in range(a + 1, n):
            qx, qy = query[b, 0] - query[a, 0], query[b, 1] - query[a, 1]
            length = np.hypot(qx, qy)
            if length < SHORTEST_M or length > LONGEST_M:
                continue
            first = np.searchsorted(lengths, length - LENGTH_TOLERANCE_M)
            last = np.searchsorted(lengths, length + LENGTH_TOLERANCE_M)
            for k in range(first, last):
                i, j = pairs[k, 0], pairs[k, 1]
                px, py = reference[j, 0] - reference[i, 0], reference[j, 1] - reference[i, 1]
                c = (qx * px + qy * py) / (length * lengths[k])
                if c < least_cosine:
                    continue
                s = (qx * py - qy * px) / (length * lengths[k])
                mx, my = 0.5 * (query[a, 0] + query[b, 0]), 0.5 * (query[a, 1] + query[b, 1])
                tx = 0.5 * (reference[i, 0] + reference[j, 0]) - (c * mx - s * my)
                ty = 0.5 * (reference[i, 1] + reference[j, 1]) - (s * mx + c * my)
                if np.hypot(c * gx - s * gy + tx - gx, s * gx + c * gy + ty - gy) > largest_shift:
                    continue
                tried += 1
                near = 0
                for e in range(n):
                    if e in (a, b):
                        continue
                    x = c * query[e, 0] - s * query[e, 1] + tx
                    y = s * query[e, 0] + c * query[e, 1] + ty
                    u, v = int((x - origin[0]) * 10.0), int((y - origin[1]) * 10.0)
                    if x < origin[0] or y < origin[1] or u >= cells.shape[0] or v >= cells.shape[1]:
                        continue
                    f = cells[u, v]
                    if f < 0:
                        continue
                    square = (reference[f, 0] - x) ** 2 + (reference[f, 1] - y) ** 2
                    if square <= LARGEST_R_M**2:
                        slot = near  # kept in ascending order
                        while slot > 0 and squares[slot - 1] > square:
                            squares[slot] = squares[slot - 1]
                            slot -= 1
                        squares[slot] = square
                        near += 1
                if near < 2:
                    continue
                best, radius = np.inf, 0.0
                for h in range(near):
                    p = min(1.0, density * np.pi * max(squares[h], SMALLEST_R_M**2))
                    # P(Binomial ≥ k) ≤ (n over k) p^k.
                    tail = log_binomials[h + 1] + (h + 1) * np.log10(p)
                    if tail < best:
                        best, radius = tail, np.sqrt(max(squares[h], SMALLEST_R_M**2))
                if best + np.log10(tried + 0.0) > log_limit:
                    continue
                place = count
                if count < len(rows):
                    count += 1
                else:  # full: the least significant one makes room
                    place = int(np.argmax(rows[:, 0]))
                    if rows[place, 0] <= best:
                        continue
                rows[place] = best, c, s, tx, ty, radius
    return rows[:count], tried
