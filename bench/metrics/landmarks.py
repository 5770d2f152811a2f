"""Landmark maps: how many true landmarks a run mapped, how often twice, how well, and how it paired them.

Sources
-------
Share of mapped landmarks: the dissertation's landmark detection. Precision and recall of pairings, and
counting distinct true landmarks apart from duplicates: the usage for the DLR log since Kurlbaum & Frese
2009.

Conventions
-----------
- A true landmark is named by its row in ``true_positions``. ``seen`` says for each observation of each
  step which one it shows, −1 for none. ``matches`` says to which estimated landmark SLAM gave it, −1 for
  discarded.
- An estimated landmark *is* the true one that most of its observations show; among equals, the one it
  showed first. False detections vote too, for −1: a landmark made of them is false. Where −1 means
  instead that the source does not know (the DLR log), ``unlabelled=True`` leaves those observations out
  of every count.
- Mapped: distinct true landmarks that some estimate is. Duplicated: further estimates of them. False ones
  count in neither.
- The error of a landmark is that of its *first* estimate, as the run left it, unaligned: which of several
  is best, the robot cannot know.
- A *pairing* is an observation given to a landmark that it did not found. Correct: both are the same true
  landmark. Wrong: they are not, false detections and false landmarks included; a false detection given to
  a false landmark is neither. Precision = correct / (correct + wrong).
- Recall = correct pairings / observations of a true landmark that some estimate of an *earlier* step
  already is. Discarding such an observation and founding a duplicate with it both cost recall.
- 0/0 is NaN.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bench.errors import BenchError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class LandmarkScores:
    """Scores of one map; the names are those of `bench.schema.RUN_COLUMNS`.

    Attributes
    ----------
    landmarks_total : int
        True landmarks.
    landmarks_mapped, landmarks_duplicated : int
        Distinct true landmarks in the map, and their further estimates.
    landmark_rmse_m : float
        Of the first estimates, metres; NaN for an empty map.
    association_precision, association_recall : float
        0…1 or NaN.
    """

    landmarks_total: int
    landmarks_mapped: int
    landmarks_duplicated: int
    landmark_rmse_m: float
    association_precision: float
    association_recall: float


@dataclass(frozen=True, eq=False)
class Pairings:
    """Every observation that was given to an estimated landmark or should have been.

    Attributes
    ----------
    step : (n,) int64
        Step of each observation.
    shown : (n,) int64
        True landmark it shows, −1 for none.
    given : (n,) int64
        Estimated landmark it was given to, −1 for discarded.
    """

    step: IntArray
    shown: IntArray
    given: IntArray


def validate(
    estimated: ArrayLike, matches: Sequence[ArrayLike], seen: Sequence[ArrayLike], true_positions: ArrayLike
) -> tuple[FloatArray, Pairings, FloatArray]:
    """Check the arguments of `evaluate` and flatten them.

    Raises
    ------
    BenchError
        When shapes do not fit, a position is not finite, an index names nothing, or an estimated landmark
        has no observation.
    """
    estimate = np.asarray(estimated, dtype=np.float64).reshape(-1, 2)
    truth = np.asarray(true_positions, dtype=np.float64).reshape(-1, 2)
    if not (np.isfinite(estimate).all() and np.isfinite(truth).all()):
        raise BenchError("landmark positions must be finite")
    lengths = [np.size(m) for m in matches]
    if lengths != [np.size(s) for s in seen]:
        raise BenchError("matches and true landmarks must have the same observations in the same steps")
    given, shown = (np.concatenate([np.zeros(0), *part]).astype(np.int64) for part in (matches, seen))
    for name, values, count in (("match", given, len(estimate)), ("true landmark", shown, len(truth))):
        if np.any((values < -1) | (values >= count)):
            raise BenchError(f"a {name} names a landmark outside -1 … {count - 1}")
    if len(np.unique(given[given >= 0])) != len(estimate):
        raise BenchError("an estimated landmark has no observation; matches and map are not of the same run")
    return estimate, Pairings(np.repeat(np.arange(len(lengths)), lengths), shown, given), truth


def identities(pairings: Pairings, count: int, unlabelled: bool = False) -> IntArray:
    """Which true landmark each estimated one is.

    Parameters
    ----------
    pairings : Pairings
        In order of time.
    count : int
        Number of estimated landmarks.
    unlabelled : bool
        Whether −1 in ``shown`` is unknown rather than a false detection.

    Returns
    -------
    (count,) int64, −1 for a false (or unknown) one.
    """
    votes = (pairings.given >= 0) & ((pairings.shown >= 0) | (not unlabelled))
    pairs = np.stack([pairings.given[votes], pairings.shown[votes]], axis=1)
    result = np.full(count, -1, dtype=np.int64)
    kinds, first, number = np.unique(pairs, axis=0, return_index=True, return_counts=True)
    # Weakest candidate first, so that the strongest is written last: few votes, then late sight.
    for k in np.lexsort((-first, number)):
        result[kinds[k, 0]] = kinds[k, 1]
    return result


def association_scores(
    pairings: Pairings, identity: IntArray, unlabelled: bool = False
) -> tuple[float, float]:
    """Precision and recall of the pairings, 0…1 or NaN each."""
    known = (pairings.shown >= 0) | (not unlabelled)
    founded = _founding_steps(pairings, len(identity))
    founding = np.zeros(len(known), dtype=bool)
    numbers, first = np.unique(pairings.given, return_index=True)
    founding[first[numbers >= 0]] = True

    paired = known & (pairings.given >= 0) & ~founding
    of = np.where(pairings.given >= 0, identity[pairings.given] if len(identity) else -1, -1)
    correct = paired & (of == pairings.shown) & (of >= 0)
    wrong = paired & (of != pairings.shown)

    # When the first estimate of each true landmark came into the map.
    never = np.iinfo(np.int64).max
    mapped_at = np.full(max(int(pairings.shown.max(initial=-1)), int(identity.max(initial=-1))) + 2, never)
    np.minimum.at(mapped_at, identity, founded)
    mapped_at[-1] = never
    due = (pairings.shown >= 0) & (mapped_at[pairings.shown] < pairings.step)
    return _ratio(correct.sum(), correct.sum() + wrong.sum()), _ratio((correct & due).sum(), due.sum())


def table(
    estimated: ArrayLike,
    matches: Sequence[ArrayLike],
    seen: Sequence[ArrayLike],
    true_positions: ArrayLike,
    *,
    unlabelled: bool = False,
) -> FloatArray:
    """Put true and estimated landmarks side by side.

    Returns
    -------
    (k, 5) float64: true landmark, its x and y, estimated x and y. Each true landmark has a row, with NaN
    estimates if it is not mapped, and a further row for each duplicate; false estimates follow as
    landmark −1 with NaN truth.
    """
    estimate, pairings, truth = validate(estimated, matches, seen, true_positions)
    identity = identities(pairings, len(estimate), unlabelled)
    missing = np.setdiff1d(np.arange(len(truth)), identity)
    number = np.concatenate([identity, missing])
    rows = np.full((len(number), 5), np.nan)
    rows[:, 0] = number
    rows[number >= 0, 1:3] = truth[number[number >= 0]]
    rows[: len(estimate), 3:5] = estimate
    # By true landmark, estimates in the order they were founded, false ones last.
    return rows[np.lexsort((np.arange(len(number)), number, number < 0))]


def evaluate(
    estimated: ArrayLike,
    matches: Sequence[ArrayLike],
    seen: Sequence[ArrayLike],
    true_positions: ArrayLike,
    *,
    unlabelled: bool = False,
) -> LandmarkScores:
    """All scores of one map.

    Parameters
    ----------
    estimated : (m, 2) array_like
        Final estimates, metres, in the frame of ``true_positions``, numbered in the order of founding.
    matches : sequence of (n_k,) array_like of int
        As in `vslam.slam.SlamResult`.
    seen : sequence of (n_k,) array_like of int
        True landmark of each observation, −1 for none.
    true_positions : (t, 2) array_like, metres
    unlabelled : bool
        Whether −1 in ``seen`` means unknown (the DLR log) rather than a false detection.

    Raises
    ------
    BenchError
        As `validate`.
    """
    estimate, pairings, truth = validate(estimated, matches, seen, true_positions)
    identity = identities(pairings, len(estimate), unlabelled)
    true_ones = np.flatnonzero(identity >= 0)
    mapped, first = np.unique(identity[true_ones], return_index=True)
    errors = estimate[true_ones[first]] - truth[mapped]
    precision, recall = association_scores(pairings, identity, unlabelled)
    return LandmarkScores(
        landmarks_total=len(truth),
        landmarks_mapped=len(mapped),
        landmarks_duplicated=len(true_ones) - len(mapped),
        landmark_rmse_m=float(np.sqrt((errors**2).sum(axis=1).mean())) if len(mapped) else float("nan"),
        association_precision=precision,
        association_recall=recall,
    )


def _founding_steps(pairings: Pairings, count: int) -> IntArray:
    steps = np.zeros(count, dtype=np.int64)
    numbers, first = np.unique(pairings.given, return_index=True)
    steps[numbers[numbers >= 0]] = pairings.step[first[numbers >= 0]]
    return steps


def _ratio(part: int, whole: int) -> float:
    return float(part) / float(whole) if whole else float("nan")
