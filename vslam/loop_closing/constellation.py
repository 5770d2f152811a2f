"""Recognising a place by its discs: rigid alignment of one set of points with another, a contrario.

Discs look alike, so a place is known by the distances between its discs alone. Each pair of query discs is
laid on each pair of reference discs of the same distance; the alignment that this gives is judged by
how many of the other query discs then fall close to a reference disc.

How many are enough is no constant to choose. Were the discs scattered at random, a query disc would
fall within r of a reference disc with probability p(r) = λ π r², λ the density of reference discs. So
among N alignments tried,

    NFA = N · (n − 2) · P(Binomial(n − 2, p(r)) ≥ k)

of them or fewer would find k discs within r by accident: the *number of false alarms* (Moisan &
Stival 2004; with the r that makes it smallest, hence the factor n − 2 for the choice of r). A place
is recognised when that number is far below one. What the model of randomness cannot see, a building
that repeats itself, shows as several alignments: all of them are returned, and who asked has to
choose or to refuse.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.special import gammaln

from vslam.loop_closing.alignments import LARGEST_R_M, LENGTH_TOLERANCE_M, SMALLEST_R_M, alignments

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

MOST_PLACES = 8
"""Alignments returned at most: who has that many to choose from cannot choose."""

_MOST_DISCS = 128


@dataclass(frozen=True, eq=False)
class Alignment:
    """A way to lay the query on the reference.

    Attributes
    ----------
    log_nfa : float
        log10 of the number of false alarms.
    turn : float
        Rotation, rad in (−π, π].
    shift : (2,) float64
        Translation of the query's centroid, metres.
    query, reference : (k,) int64
        The discs that coincide.
    """

    log_nfa: float
    turn: float
    shift: FloatArray
    query: IntArray
    reference: IntArray


def density(points: FloatArray) -> float:
    """λ, discs per m² of the floor on which there are discs: all that is nearer to one than the mean
    distance d̄ of nearest neighbours. What lies between corridors does not thin it out.

    On a square lattice this is exact; of discs scattered at random, circles of d̄ cover 1 − e^(−π/4) = 54 %
    (Clark & Evans 1954), so λ comes out 1.8 times too large, which is the safe side. Off that floor p is 0.
    """
    if len(points) < 2:
        return 1.0
    tree = cKDTree(points)
    spacing = float(np.mean(np.asarray(tree.query(points, k=2)[0])[:, 1]))
    # Area of the union: each circle's points count by how many circles share them. 36 points on Vogel's
    # spiral stand for equal areas.
    angle = np.arange(36) * (np.pi * (3.0 - np.sqrt(5.0)))
    radius = spacing * np.sqrt((np.arange(36) + 0.5) / 36)
    around = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    shared = tree.query_ball_point(
        (points[:, None] + around).reshape(-1, 2), spacing * (1 + 1e-9), return_length=True
    )
    area = np.pi * spacing**2 * len(points) * float(np.mean(1.0 / np.maximum(shared, 1)))
    return len(points) / area


def recognise(
    query: FloatArray,
    reference: FloatArray,
    discs_per_m2: float,
    log_limit: float = 0.0,
    largest_turn: float = np.pi,
    largest_shift: float = np.inf,
) -> list[Alignment]:
    """All ways to lay the query on the reference with less than 10^``log_limit`` false alarms.

    Parameters
    ----------
    query : (n, 2) float64
        Metres, any frame.
    reference : (m, 2) float64
        Metres, any frame.
    discs_per_m2 : float
        Of the reference, see `density`.
    log_limit : float
        log10 of the largest number of false alarms.
    largest_turn, largest_shift : float
        Bounds on what the query may be off by, rad and metres (of its centroid); none beyond is tried.

    Returns
    -------
    list of Alignment
        The most significant first. Of those that lay the query on nearly the same place, the best alone.
    """
    query, reference = query[:_MOST_DISCS], np.ascontiguousarray(reference)
    if len(query) < 4 or len(reference) < 4:
        return []
    found, tried = alignments(query, reference, discs_per_m2, log_limit, largest_turn, largest_shift)
    found[:, 0] += np.log10(max(tried, 1) * max(len(query) - 2, 1))
    found = found[found[:, 0] <= log_limit]
    found = found[np.argsort(found[:, 0], kind="stable")]
    tree = cKDTree(reference)
    kept: list[Alignment] = []
    while len(found) and len(kept) < MOST_PLACES:
        kept.append(_refined(query, reference, tree, found[0]))
        found = found[~_same_place(found, kept[-1], query)]
    return kept


def in_place(query: FloatArray, reference: FloatArray, discs_per_m2: float) -> Alignment | None:
    """The alignment that moves nothing, or as little as the nearest discs ask for: one test, so N = 1.

    Parameters
    ----------
    query, reference, discs_per_m2
        As of `recognise`, in one frame.

    Returns
    -------
    Alignment or None
        None where fewer than two discs have a partner.
    """
    if not len(query) or len(reference) < 2:
        return None
    turn, shift = 0.0, np.zeros(2)
    tree, radius = cKDTree(reference), LARGEST_R_M
    best: Alignment | None = None
    for _ in range(3):
        moved = _moved(query, turn, shift)
        distance, nearest = _nearest(tree, moved)
        log_nfa, radius = _best_radius(np.sort(distance), discs_per_m2)
        a, b = _mutual(distance, nearest, radius)
        if len(a) < 2:
            break
        turn, shift = _rigid(query, a, reference[b])
        if best is None or log_nfa + np.log10(len(query)) < best.log_nfa:
            best = Alignment(log_nfa + np.log10(len(query)), turn, shift, a, b)
    return best


def _best_radius(distances: FloatArray, density: float) -> tuple[float, float]:
    """Smallest log10 binomial tail over r, and that r, of ascending distances."""
    n = len(distances)
    k = np.arange(1, n + 1)
    p = np.minimum(1.0, density * np.pi * np.maximum(distances, SMALLEST_R_M) ** 2)
    binomials = (gammaln(n + 1) - gammaln(k + 1) - gammaln(n - k + 1)) / np.log(10.0)
    tails = binomials + k * np.log10(p)
    tails[distances > LARGEST_R_M] = np.inf
    best = int(np.argmin(tails))
    return float(tails[best]), float(max(distances[best], SMALLEST_R_M))


def _same_place(rows: FloatArray, other: Alignment, query: FloatArray) -> NDArray[np.bool_]:
    """Which alignments lay the query on the place of another one: no disc moves by half a typical spacing."""
    there = _moved(query, other.turn, other.shift)
    return np.array(
        [np.hypot(*(_laid(query, row) - there).T).max() < 2 * LARGEST_R_M for row in rows], dtype=bool
    )


def _laid(query: FloatArray, row: FloatArray) -> FloatArray:
    """The query under an alignment as `_search` found it."""
    _, c, s, x, y, _ = row
    return query @ np.array([[c, s], [-s, c]]) + (x, y)


def _refined(query: FloatArray, reference: FloatArray, tree: cKDTree, row: FloatArray) -> Alignment:
    """Fit an alignment to all discs that coincide under it, twice."""
    log_nfa, moved, radius = float(row[0]), _laid(query, row), row[5]
    a, b = _mutual(*_nearest(tree, moved), max(radius, LENGTH_TOLERANCE_M))
    turn, shift = _rigid(query, a, reference[b])
    a, b = _mutual(*_nearest(tree, _moved(query, turn, shift)), max(radius, LENGTH_TOLERANCE_M))
    turn, shift = _rigid(query, a, reference[b])
    return Alignment(log_nfa, turn, shift, a, b)


def _nearest(tree: cKDTree, points: FloatArray) -> tuple[FloatArray, IntArray]:
    """Distance to the nearest reference disc, and which one it is."""
    distance, nearest = tree.query(points)
    return np.asarray(distance, dtype=np.float64), np.asarray(nearest, dtype=np.int64)


def _mutual(distance: FloatArray, nearest: IntArray, radius: float) -> tuple[IntArray, IntArray]:
    """Pairs within the radius, each reference disc with its nearest query disc alone."""
    order = np.argsort(distance, kind="stable")
    order = order[distance[order] <= radius]
    _, first = np.unique(nearest[order], return_index=True)
    a = order[np.sort(first)]
    return a, nearest[a]


def _rigid(query: FloatArray, chosen: IntArray, target: FloatArray) -> tuple[float, FloatArray]:
    """Least-squares rotation, and how far it moves the whole query's centroid (Umeyama 1991, without
    scale).
    """
    points = query[chosen]
    a, b = points - points.mean(axis=0), target - target.mean(axis=0)
    turn = float(np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum()))
    centre = query.mean(axis=0)
    moved = _moved(np.vstack([points.mean(axis=0)]), turn, np.zeros(2), centre)
    return turn, target.mean(axis=0) - moved[0]


def _moved(query: FloatArray, turn: float, shift: FloatArray, centre: FloatArray | None = None) -> FloatArray:
    """Turn about the query's centroid, then shift."""
    centre = query.mean(axis=0) if centre is None else centre
    c, s = np.cos(turn), np.sin(turn)
    return (query - centre) @ np.array([[c, s], [-s, c]]) + centre + shift
