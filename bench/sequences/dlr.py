"""The DLR building log of Kurlbaum & Frese 2009 ("A Benchmark Data Set for Data Association").

Axes. The log's robot has −Y forward and +X left (its header says right, its pictures say left). Ours has x
forward and y left, so every vector and covariance is turned by +90°: x = −Y, y = X. Robot and world turn
alike, which leaves headings as they are. The world is the frame of the first pose.

``truth.txt`` is no independent truth: it lies 2.3 cm rms from the batch solution of these very
observations.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.errors import BenchError
from bench.sequences.dlr_rows import Rows, csv_rows, expect, fail, lines, list_rows, refuse, values
from vslam.frame import Observations, Odometry
from vslam.geometry import to_global

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Steps = tuple[tuple[Odometry, Observations], ...]

LOG, TRUTH = "map.circles", "truth.txt"
BATCH_POSES, BATCH_LANDMARKS = "batch_poses.csv", "batch_landmarks.csv"

# Log axes to ours, a proper rotation; the same with the heading below.
_TURN = np.array([[0.0, -1.0], [1.0, 0.0]])
_TURN_POSE = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])

# Fields of a row, keyword included, as the log's header lists them.
_STEP_FIELDS = 11
_LANDMARK_FIELDS = 8
# truth.txt: the pose, then a covariance that is not used.
_TRUTH_FIELDS = 12


@dataclass(frozen=True, eq=False)
class DlrLog:
    """The log in our axes, metres and radians.

    Attributes
    ----------
    steps : tuple of n (Odometry, Observations)
        Each increment with what is seen after it.
    truth : (n + 1, 3) float64
        x, y, heading (not wrapped); row 0 is the start, row k + 1 belongs to step k.
    batch_poses : (n + 1, 3) float64 or None
        The least-squares track with the annotated ids; None where the folder has none.
    landmark_ids : (m,) int64
        Annotated ids, rising.
    landmark_positions : (m, 2) float64
        Their positions: of the least-squares solution, or, where the folder has none, the means of the
        observations as seen from the true track (4 cm rms apart).
    image_names : tuple of n str
        File name of each step's picture.
    """

    steps: Steps
    truth: FloatArray
    batch_poses: FloatArray | None
    landmark_ids: IntArray
    landmark_positions: FloatArray
    image_names: tuple[str, ...]


def load(folder: Path) -> DlrLog:
    """Read the log, its truth and, where present, its batch solution.

    Parameters
    ----------
    folder : Path
        Holds ``map.circles`` and ``truth.txt``, and may hold ``batch_poses.csv`` and
        ``batch_landmarks.csv``, which the public sources lack.

    Returns
    -------
    DlrLog

    Raises
    ------
    BenchError
        For a file that is missing or unreadable, and for any malformed row, with file and line.
    """
    folder = Path(folder)
    steps, names, landmark_rows = _read_log(folder / LOG)
    truth = _poses(folder / TRUTH, list_rows(folder / TRUTH, _TRUTH_FIELDS), len(steps))
    batch = None
    if (folder / BATCH_POSES).exists():
        batch = _poses(folder / BATCH_POSES, csv_rows(folder / BATCH_POSES, "x_m,y_m,theta_rad"), len(steps))
    if (folder / BATCH_LANDMARKS).exists():
        ids, positions = _batch_landmarks(folder / BATCH_LANDMARKS)
        known = np.isin(np.concatenate([o.ids for _, o in steps]), [-1, *ids])
        refuse(folder / LOG, landmark_rows, ~known, f"the landmark id is not in {BATCH_LANDMARKS}")
    else:
        ids, positions = _landmarks_from_truth(steps, truth)
    return DlrLog(steps, truth, batch, ids, positions, names)


def _read_log(path: Path) -> tuple[Steps, tuple[str, ...], Rows]:
    step_rows, landmark_rows, owners = _sort_rows(path)
    odometry = _odometry(path, step_rows)
    observations = _observations(path, landmark_rows, owners, len(step_rows))
    names = tuple(f"{fields[1]}.jpg" for _, fields in step_rows)
    return tuple(zip(odometry, observations, strict=True)), names, landmark_rows


def _sort_rows(path: Path) -> tuple[Rows, Rows, IntArray]:
    """STEP rows, LANDMARK_C rows, and the step that each of the latter belongs to."""
    step_rows: Rows = []
    landmark_rows: Rows = []
    owners: list[int] = []
    for number, line in enumerate(lines(path), start=1):
        fields = line.split()
        if not fields or fields[0].startswith("#"):
            continue
        if fields[0] == "STEP":
            expect(path, number, "STEP", fields, _STEP_FIELDS)
            step_rows.append((number, fields))
        elif fields[0] == "LANDMARK_C":
            expect(path, number, "LANDMARK_C", fields, _LANDMARK_FIELDS)
            if not step_rows:
                fail(path, number, "a LANDMARK_C row before the first STEP")
            landmark_rows.append((number, fields))
            owners.append(len(step_rows) - 1)
        else:
            fail(path, number, f"unknown keyword {fields[0]!r}; expected STEP or LANDMARK_C")
    return step_rows, landmark_rows, np.array(owners, dtype=np.int64)


def _odometry(path: Path, rows: Rows) -> list[Odometry]:
    columns = values(path, [(number, fields[2:]) for number, fields in rows])
    delta = columns[:, :3] @ _TURN_POSE.T
    # In the log: cXX cXY cYY cXPhi cYPhi cPhiPhi.
    Q = columns[:, 3:][:, [0, 1, 3, 1, 2, 4, 3, 4, 5]].reshape(-1, 3, 3)
    Q = _TURN_POSE @ Q @ _TURN_POSE.T
    indefinite = np.linalg.eigvalsh(Q)[:, 0] < 0.0
    refuse(path, rows, indefinite, "the odometry covariance is not positive semi-definite")
    return [Odometry(d, q) for d, q in zip(delta, Q, strict=True)]


def _observations(path: Path, rows: Rows, owners: IntArray, steps: int) -> list[Observations]:
    if not rows:
        return [Observations.none()] * steps
    columns = values(path, [(number, fields[1:]) for number, fields in rows])
    points = columns[:, :2] @ _TURN.T
    # In the log, after the quality: cXX cXY cYY.
    S = _TURN @ columns[:, 3:6][:, [0, 1, 1, 2]].reshape(-1, 2, 2) @ _TURN.T
    indefinite = np.linalg.eigvalsh(S)[:, 0] <= 0.0
    refuse(path, rows, indefinite, "the landmark covariance is not positive definite")
    ids = _ids(path, rows, columns[:, 6], lowest=-1)
    ends = np.searchsorted(owners, np.arange(steps), side="right").tolist()
    starts = [0, *ends[:-1]]
    return [Observations(points[a:b], S[a:b], ids[a:b]) for a, b in zip(starts, ends, strict=True)]


def _batch_landmarks(path: Path) -> tuple[IntArray, FloatArray]:
    rows = csv_rows(path, "id,x_m,y_m")
    columns = values(path, rows)
    ids = _ids(path, rows, columns[:, 0], lowest=0)
    unique, first = np.unique(ids, return_index=True)
    refuse(path, rows, ~np.isin(np.arange(len(ids)), first), "this landmark id occurs a second time")
    return unique, (columns[:, 1:] @ _TURN.T)[first]


def _landmarks_from_truth(steps: Steps, truth: FloatArray) -> tuple[IntArray, FloatArray]:
    ids = np.concatenate([o.ids for _, o in steps])
    points = np.concatenate(
        [to_global(pose, o.points) for pose, (_, o) in zip(truth[1:], steps, strict=True)]
    )
    known, row = np.unique(ids[ids >= 0], return_inverse=True)
    sums = np.zeros((len(known), 2))
    np.add.at(sums, row, points[ids >= 0])
    return known, sums / np.bincount(row, minlength=len(known))[:, None]


def _poses(path: Path, rows: Rows, steps: int) -> FloatArray:
    if len(rows) != steps + 1:
        raise BenchError(
            f"{path}: {len(rows)} poses for {steps} steps; expected {steps + 1}, the start included"
        )
    return values(path, rows)[:, :3] @ _TURN_POSE.T


def _ids(path: Path, rows: Rows, column: FloatArray, lowest: int) -> IntArray:
    ids = column.astype(np.int64)
    refuse(path, rows, (ids != column) | (ids < lowest), f"a landmark id is a whole number from {lowest}")
    return ids
