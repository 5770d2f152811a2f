"""Which fragments are one disc: by alignments that are significant, agree with the drive, and have no rival.

Three questions to an alignment of what was seen lately (the query) with what was seen before (the reference):

1. Would it happen by accident? Its number of false alarms says so (`vslam.loop_closing.constellation`).
2. Does it agree with the drive between? Its displacement, a turn and a shift, has the covariance that the
   smoother's joint covariance of the landmarks implies: a χ² test of three degrees of freedom, the joint
   compatibility of Neira & Tardós 2001 for two maps.
3. Is there another one that would pass both? Then the place repeats itself and nothing is merged; the robot
   drives on, and asks again when the drive is over.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from vslam.loop_closing.constellation import Alignment, density, in_place, recognise
from vslam.loop_closing.smoother import Estimate

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

LOG_NFA = -4.0
"""One false closure in 10,000 queries: some hundred queries make one in a hundred buildings."""

RIVAL_SHARE = 0.5
"""A rival counts when it is half as significant as the best, in decades. A place that repeats itself fits one
period off with all discs but those at its ends, so its rival is nearly as good; an accident is not."""

ONE_SIGHT_M = 0.045
"""What two maps of one place may differ by even if they are exact in themselves: errors of calibration do not
average out over many sights, so the σ of one (the median that the DLR log states) stays."""


@dataclass(frozen=True)
class Bounds:
    """What the drive allows.

    Attributes
    ----------
    gate : float
        Probability with which a true displacement passes.
    largest_turn, largest_shift : float
        Beyond which no alignment is tried, rad and metres.
    """

    gate: float
    largest_turn: float = float(np.pi)
    largest_shift: float = float("inf")


@dataclass(frozen=True)
class Answer:
    """What was found.

    Attributes
    ----------
    pairs : list of (query landmark, reference landmark)
        To be merged; empty where nothing is sure.
    deferred : bool
        Whether something was recognised that could not be decided: worth asking again later.
    """

    pairs: list[tuple[int, int]] = field(default_factory=list)
    deferred: bool = False


def closures(estimate: Estimate, query: IntArray, reference: IntArray, bounds: Bounds) -> Answer:
    """Landmarks to merge.

    Parameters
    ----------
    estimate : Estimate
    query, reference : (n,), (m,) int64
        Landmarks of the estimate.
    bounds : Bounds

    Returns
    -------
    Answer
    """
    q, r = estimate.landmarks[query], estimate.landmarks[reference]
    discs_per_m2 = density(r)
    still = in_place(q, r, discs_per_m2)
    found = ([still] if still is not None else []) + recognise(
        q, r, discs_per_m2, RIVAL_SHARE * LOG_NFA, bounds.largest_turn, bounds.largest_shift
    )
    if not any(a.log_nfa <= LOG_NFA for a in found):
        return Answer()
    gate = float(chi2.ppf(bounds.gate, 3))
    agreeing = [a for a in found if displacement(estimate, query, reference, a) <= gate]
    places = _places(agreeing)
    best = places[0] if places else None
    if best is None or best.log_nfa > LOG_NFA:
        return Answer(deferred=True)
    if any(rival.log_nfa <= RIVAL_SHARE * best.log_nfa for rival in places[1:]):
        return Answer(deferred=True)
    return Answer(
        [(int(query[a]), int(reference[b])) for a, b in zip(best.query, best.reference, strict=True)]
    )


def displacement(estimate: Estimate, query: IntArray, reference: IntArray, alignment: Alignment) -> float:
    """Squared Mahalanobis distance of an alignment's turn and shift from none, three degrees of freedom."""
    a, b = query[alignment.query], reference[alignment.reference]
    k = len(a)
    joint = estimate.covariance(np.concatenate([a, b]))
    # Covariance of the differences: a − b.
    C = joint[: 2 * k, : 2 * k] + joint[2 * k :, 2 * k :] - joint[: 2 * k, 2 * k :] - joint[2 * k :, : 2 * k]
    offsets = estimate.landmarks[a] - estimate.landmarks[query].mean(axis=0)
    blocks = np.zeros((k, 2, 3))
    blocks[:, 0, 0] = blocks[:, 1, 1] = 1.0
    blocks[:, 0, 2], blocks[:, 1, 2] = -offsets[:, 1], offsets[:, 0]
    A = blocks.reshape(-1, 3)
    covariance = np.linalg.inv(A.T @ np.linalg.solve(C + 1e-6 * np.eye(2 * k), A))
    arm = max(float((offsets**2).sum(axis=1).mean()), ONE_SIGHT_M**2)
    floor = 2 * ONE_SIGHT_M**2 * np.array([1.0, 1.0, 1.0 / arm])
    moved = np.append(alignment.shift, alignment.turn)
    return float(moved @ np.linalg.solve(covariance + np.diag(floor), moved))


def _places(alignments: list[Alignment]) -> list[Alignment]:
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
