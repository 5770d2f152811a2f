"""Landmark detection: which of a picture's discs were found, and what else was reported.

Conventions
-----------
- Points lie on the floor in the robot's frame, metres.
- A landmark is *visible* when the ground truth says so (the caller's limit on the visible share of its disc).
- Detections and visible landmarks are paired one to one by the Hungarian method (Kuhn 1955): first as many
  pairs within the gate as possible, then the least sum of distances. A second detection of a disc is false.
- A left-over detection of a landmark below the visibility limit is set aside: it counts neither as detected
  nor as false, since the limit is ours and not the detector's.
- precision = true / detected; recall = true / visible; NaN where the denominator is 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import linear_sum_assignment

from bench.errors import BenchError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class DetectionScores:
    """Counts of one picture.

    Attributes
    ----------
    visible : int
        Landmarks that could be found.
    detected : int
        Detections that count (those of landmarks below the visibility limit are set aside).
    true : int
        Detections of a visible landmark = visible landmarks found.
    precision, recall : float
        0…1, or NaN.
    assigned_ids : (n,) int64
        For each detection the row of its landmark in ``true_points_all``, −1 where there is none. Set-aside
        detections carry their landmark too.
    """

    visible: int
    detected: int
    true: int
    precision: float
    recall: float
    assigned_ids: IntArray


def evaluate(
    points: ArrayLike, true_points: ArrayLike, true_points_all: ArrayLike, gate_m: float = 0.15
) -> DetectionScores:
    """Score the detections of one picture.

    Parameters
    ----------
    points : (n, 2) array_like
        Detections.
    true_points : (m, 2) array_like
        The visible landmarks; each is one of ``true_points_all``.
    true_points_all : (k, 2) array_like
        All landmarks.
    gate_m : float
        Largest distance of a pair. The default is the mean disc radius: the detection lies on the disc.

    Raises
    ------
    BenchError
        For points that are not finite (n, 2) arrays, or a visible landmark that is not among all of them.
    """
    found = _points("detections", points)
    visible = _points("visible landmarks", true_points)
    everything = _points("all landmarks", true_points_all)
    row_of_visible = _rows(visible, everything)
    assigned = np.full(len(found), -1, dtype=np.int64)
    first = match(found, visible, gate_m)
    assigned[first[:, 0]] = row_of_visible[first[:, 1]]
    left = np.flatnonzero(assigned < 0)
    hidden = np.setdiff1d(np.arange(len(everything)), row_of_visible)
    second = match(found[left], everything[hidden], gate_m)
    assigned[left[second[:, 0]]] = hidden[second[:, 1]]
    detected, true = len(found) - len(second), len(first)
    return DetectionScores(
        visible=len(visible),
        detected=detected,
        true=true,
        precision=true / detected if detected else float("nan"),
        recall=true / len(visible) if len(visible) else float("nan"),
        assigned_ids=assigned,
    )


def match(a: FloatArray, b: FloatArray, gate_m: float) -> IntArray:
    """Pair points one to one within a gate.

    Parameters
    ----------
    a : (n, 2) float64
    b : (m, 2) float64
    gate_m : float
        Same unit as the points.

    Returns
    -------
    (p, 2) int64
        Rows of ``a`` and ``b``, ascending in ``a``: the most pairs, and of these the least sum of distances.
    """
    if len(a) == 0 or len(b) == 0:
        return np.zeros((0, 2), dtype=np.int64)
    distance = np.linalg.norm(a[:, None] - b[None], axis=2)
    # A pair beyond the gate costs more than all pairs within it together.
    beyond = gate_m * (min(len(a), len(b)) + 1.0) + 1.0
    rows, cols = linear_sum_assignment(np.where(distance <= gate_m, distance, beyond))
    inside = distance[rows, cols] <= gate_m
    return np.stack([rows[inside], cols[inside]], axis=1).astype(np.int64)


def _points(name: str, values: ArrayLike) -> FloatArray:
    array = np.asarray(values, dtype=np.float64)
    if array.size == 0:
        return np.zeros((0, 2))
    if array.ndim != 2 or array.shape[1] != 2 or not np.isfinite(array).all():
        raise BenchError(f"detection metric: {name} must be a finite (n, 2) array, not {array.shape}")
    return array


def _rows(visible: FloatArray, everything: FloatArray) -> IntArray:
    """(m,) int64: where each visible landmark stands among all."""
    if len(visible) == 0:
        return np.zeros(0, dtype=np.int64)
    if len(everything) == 0:
        raise BenchError("detection metric: there are visible landmarks, but no landmarks at all")
    distance = np.linalg.norm(visible[:, None] - everything[None], axis=2)
    rows = distance.argmin(axis=1)
    if distance.min(axis=1).max() > 1e-6 or len(set(rows.tolist())) < len(rows):
        raise BenchError("detection metric: each visible landmark must be one of all landmarks, once")
    return rows.astype(np.int64)
