"""Which fragments are one disc: alignments that are significant, agree with the drive, and are the only ones that do.

Three questions to an alignment of what was seen lately (the query) with what was seen before (the reference):

1. Would it happen by accident? Its number of false alarms says so (`vslam.loop_closing.constellation`).
2. Does it agree with the drive between? Its displacement, a turn and a shift, has the covariance that the
   smoother's joint covariance of the landmarks implies: a χ² test of three degrees of freedom, the joint compatibility
   of Neira & Tardós 2001 for two maps.
3. Is there another one that would pass both? Then the place repeats itself and nothing is merged; the robot drives on,
   and asks again when it knows more.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from vslam.loop_closing.constellation import Alignment, in_place, recognise
from vslam.loop_closing.smoother import Estimate

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

LOG_NFA = -4.0
"""One false closure in 10,000 queries: some hundred queries make one in a hundred buildings."""

LOG_NFA_RIVAL = 0.0
"""A rival counts from where accident explains it no better than once per query."""


def closures(
    estimate: Estimate, query: IntArray, reference: IntArray, gate: float
) -> list[tuple[int, int]]:
    """Pairs of landmarks to merge.

    Parameters
    ----------
    estimate : Estimate
    query, reference : (n,), (m,) int64
        Landmarks of the estimate.
    gate : float
        Probability with which a true displacement passes.

    Returns
    -------
    list of (query landmark, reference landmark), empty where nothing is sure.
    """
    q, r = estimate.landmarks[query], estimate.landmarks[reference]
    bound = float(chi2.ppf(gate, 3))
    still = in_place(q, r)
    found = ([still] if still is not None else []) + recognise(q, r, LOG_NFA_RIVAL)
    if not any(a.log_nfa <= LOG_NFA for a in found):
        return []
    agreeing = [a for a in found if displacement(estimate, query, reference, a) <= bound]
    places = _places(agreeing, q)
    if len(places) != 1 or places[0].log_nfa > LOG_NFA:
        return []
    best = places[0]
    return [(int(query[a]), int(reference[b])) for a, b in zip(best.query, best.reference, strict=True)]


def displacement(
    estimate: Estimate, query: IntArray, reference: IntArray, alignment: Alignment
) -> float:
    """Squared Mahalanobis distance of an alignment's turn and shift from none, three degrees of freedom."""
    a, b = query[alignment.query], reference[alignment.reference]
    k = len(a)
    joint = estimate.covariance(np.concatenate([a, b]))
    # Covariance of the differences: a − b.
    C = joint[: 2 * k, : 2 * k] + joint[2 * k :, 2 * k :] - joint[: 2 * k, 2 * k :] - joint[2 * k :, : 2 * k]
    offsets = estimate.landmarks[a] - estimate.landmarks[query].mean(axis=0)
    A = np.zeros((k, 2, 3))
    A[:, 0, 0] = A[:, 1, 1] = 1.0
    A[:, 0, 2], A[:, 1, 2] = -offsets[:, 1], offsets[:, 0]
    A = A.reshape(-1, 3)
    information = A.T @ np.linalg.solve(C + 1e-6 * np.eye(2 * k), A)
    moved = np.append(alignment.shift, alignment.turn)
    return float(moved @ information @ moved)


def _places(alignments: list[Alignment], query: FloatArray) -> list[Alignment]:
    """Most significant alignment of each place; two are one place where they share half their pairs."""
    kept: list[Alignment] = []
    for one in sorted(alignments, key=lambda a: a.log_nfa):
        pairs = set(zip(one.query.tolist(), one.reference.tolist(), strict=True))
        if not any(
            len(pairs & set(zip(o.query.tolist(), o.reference.tolist(), strict=True))) >= 0.5 * len(pairs)
            for o in kept
        ):
            kept.append(one)
    return kept
