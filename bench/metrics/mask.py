"""Masks: how well the pixels that a filter calls affected by light match those that are.

Sources
-------
IoU (Jaccard 1912), F1 (van Rijsbergen 1979), precision and recall as everywhere. BER: the
balanced error rate of shadow detection (Vicente et al. 2016). Average precision: Σ_n (R_n − R_{n−1}) P_n
without interpolation, as scikit-learn's ``average_precision_score``.

Conventions
-----------
- Positive = affected by light. TP, FP, FN, TN count pixels of one picture.
- IoU, F1, recall and AP ask how well light was found. In a picture **without** affected pixels there is
  nothing to find, and they are NaN, whatever was predicted. A score of 1 there would flatter a filter
  that never fires, and a score for some filters only would average them over different pictures. What
  decides is the truth alone, so the mean over the pictures that are not NaN (``numpy.nanmean``) is over
  the same pictures for each filter.
- False alarms in such pictures are not lost: BER and ``masked_share`` show them.
- BER is the mean of the two classes' error rates; with one class absent, the error rate of the other. It
  is never NaN. Doing nothing costs 0.5 where there is light and 0 where there is none, as it should.
- Precision is NaN where nothing was predicted (0/0), so its mean covers the pictures in which a filter
  fired: read it next to recall. Where something was predicted and nothing is true, it is 0.
- So a filter that does nothing has IoU = F1 = recall = 0, AP = the true share (what chance gives), BER 0.5.
- The score is read in steps of 1/255, nearest step: exact for scores that come from 8-bit values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.errors import BenchError

LEVELS = 256
NAN = math.nan


@dataclass(frozen=True)
class MaskScores:
    """Scores of one predicted mask, all in 0…1 or NaN as the conventions say.

    Attributes
    ----------
    iou, f1, precision, recall : float
        Of the affected pixels.
    ber : float
        Balanced error rate; lower is better.
    ap : float
        Average precision of the score, free of any threshold.
    masked_share, true_share : float
        Predicted and truly affected pixels over all pixels.
    """

    iou: float
    f1: float
    precision: float
    recall: float
    ber: float
    ap: float
    masked_share: float
    true_share: float


@dataclass(frozen=True)
class Confusion:
    """Pixel counts: true and false positives, false and true negatives."""

    tp: int
    fp: int
    fn: int
    tn: int


def validate(predicted: NDArray[np.bool_], true: NDArray[np.bool_], score: NDArray[np.float32]) -> None:
    """Refuse what is not two masks and a score of one picture.

    Raises
    ------
    BenchError
        On another type, on shapes that differ, on an empty picture, on a score outside 0…1 or NaN.
    """
    for name, mask in (("predicted", predicted), ("true", true)):
        if mask.dtype != np.bool_ or mask.ndim != 2 or mask.size == 0:
            raise BenchError(f"mask metrics: the {name} mask is {mask.dtype} {mask.shape}; give (H, W) bool")
    if not (predicted.shape == true.shape == score.shape):
        raise BenchError(
            f"mask metrics: shapes differ: predicted {predicted.shape}, true {true.shape}, "
            f"score {score.shape}; score one picture at a time"
        )
    if not (score.min() >= 0.0 and score.max() <= 1.0):  # a NaN fails both
        raise BenchError(f"mask metrics: the score spans {score.min()}…{score.max()}; it must lie in 0…1")


def iou(counts: Confusion) -> float:
    """TP / (TP + FP + FN); NaN where nothing is true."""
    return counts.tp / (counts.tp + counts.fp + counts.fn) if counts.tp + counts.fn else NAN


def f1(counts: Confusion) -> float:
    """2 TP / (2 TP + FP + FN); NaN where nothing is true."""
    return 2 * counts.tp / (2 * counts.tp + counts.fp + counts.fn) if counts.tp + counts.fn else NAN


def precision(counts: Confusion) -> float:
    """TP / (TP + FP); NaN where nothing was predicted."""
    return counts.tp / (counts.tp + counts.fp) if counts.tp + counts.fp else NAN


def recall(counts: Confusion) -> float:
    """TP / (TP + FN); NaN where nothing is true."""
    return counts.tp / (counts.tp + counts.fn) if counts.tp + counts.fn else NAN


def balanced_error_rate(counts: Confusion) -> float:
    """Mean of FN / (TP + FN) and FP / (FP + TN) over the classes that occur."""
    positives, negatives = counts.tp + counts.fn, counts.fp + counts.tn
    rates = [miss / size for miss, size in ((counts.fn, positives), (counts.fp, negatives)) if size]
    return sum(rates) / len(rates)


def average_precision(positives: NDArray[np.int64], negatives: NDArray[np.int64]) -> float:
    """Average precision over all thresholds of a score in steps.

    Parameters
    ----------
    positives, negatives : (n,) int64
        How many truly affected and unaffected pixels have each score step, lowest step first.

    Returns
    -------
    float
        Σ_n (R_n − R_{n−1}) P_n, thresholds from the highest step down; NaN where nothing is true.
    """
    total = positives.sum()
    if total == 0:
        return NAN
    found = np.cumsum(positives[::-1])
    called = found + np.cumsum(negatives[::-1])
    gained = positives[::-1] / total
    return float(np.sum(gained * found / np.maximum(called, 1)))


def evaluate(predicted: NDArray[np.bool_], true: NDArray[np.bool_], score: NDArray[np.float32]) -> MaskScores:
    """Score one predicted mask.

    Parameters
    ----------
    predicted : (H, W) bool
        What the filter calls affected.
    true : (H, W) bool
        What is affected.
    score : (H, W) float32
        The filter's soft evidence, 0…1.

    Raises
    ------
    BenchError
        When the three do not fit together; see ``validate``.
    """
    validate(predicted, true, score)
    counts, positives, negatives = _count(predicted, true, score)
    size = predicted.size
    return MaskScores(
        iou=iou(counts),
        f1=f1(counts),
        precision=precision(counts),
        recall=recall(counts),
        ber=balanced_error_rate(counts),
        ap=average_precision(positives, negatives),
        masked_share=(counts.tp + counts.fp) / size,
        true_share=(counts.tp + counts.fn) / size,
    )


def _count(
    predicted: NDArray[np.bool_], true: NDArray[np.bool_], score: NDArray[np.float32]
) -> tuple[Confusion, NDArray[np.int64], NDArray[np.int64]]:
    """Confusion counts and the score histograms of both classes, in one pass over the picture."""
    # one number per pixel: predicted, true and the score's step side by side
    cell = np.rint(score * np.float32(LEVELS - 1)).astype(np.intp)
    cell += true * np.intp(LEVELS)
    cell += predicted * np.intp(2 * LEVELS)
    histogram = np.bincount(cell.ravel(), minlength=4 * LEVELS).reshape(2, 2, LEVELS)
    (tn, fn), (fp, tp) = histogram.sum(axis=2).tolist()
    negatives, positives = histogram.sum(axis=0)
    return Confusion(tp=tp, fp=fp, fn=fn, tn=tn), positives, negatives
