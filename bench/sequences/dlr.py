"""The DLR building log of Kurlbaum & Frese 2009 ("A Benchmark Data Set for Data Association").

Axes. The log's robot has −Y forward and +X left (its header says right, its pictures say left). Ours has x
forward and y left, so every vector and covariance is turned by +90°: x = −Y, y = X. Robot and world turn
alike, which leaves headings as they are. The world is the frame of the first pose.

``truth.txt`` is no independent truth: it lies 2.3 cm rms from the batch solution of these very observations.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bench.errors import BenchError
from vslam.frame import Observations, Odometry

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Rows = list[tuple[int, list[str]]]

LOG, TRUTH = "map.circles", "truth.txt"
BATCH_POSES, BATCH_LANDMARKS = "batch_poses.csv", "batch_landmarks.csv"

# Log axes to ours, a proper rotation.
_TURN = np.array([[0.0, -1.0], [1.0, 0.0]])

# Fields of a row after its keyword, as the header of the log lists them; the last of LANDMARK_C is the id.
_STEP_FIELDS = 10
_LANDMARK_FIELDS = 7


@dataclass(frozen=True, eq=False)
class DlrLog:
    """The log in our axes, metres and radians.

    Attributes
    ----------
    steps : tuple of n (Odometry, Observations)
        Each increment with what is seen after it.
    truth : (n + 1, 3) float64
        x, y, heading (not wrapped); row 0 is the start, row k + 1 belongs to step k.
    batch_poses : (n + 1, 3) float64
        The least-squares track with the annotated ids.
    landmark_ids : (m,) int64
        Annotated ids, rising.
    landmark_positions : (m, 2) float64
        Their least-squares positions.
    image_names : tuple of n str
        File name of each step's picture.
    """

    steps: tuple[tuple[Odometry, Observations], ...]
    truth: FloatArray
    batch_poses: FloatArray
    landmark_ids: IntArray
    landmark_positions: FloatArray
    image_names: tuple[str, ...]


def load(folder: Path) -> DlrLog:
    """Read the log, its truth and its batch solution.

    Parameters
    ----------
    folder : Path
        Holds ``map.circles``, ``truth.txt``, ``batch_poses.csv`` and ``batch_landmarks.csv``.

    Returns
    -------
    DlrLog

    Raises
    ------
    BenchError
        For a file that is missing or unreadable, and for any malformed row, with file and line.
    """
    folder = Path(folder)
    ids, positions = _batch_landmarks(folder / BATCH_LANDMARKS)
    steps, names = _log(folder / LOG, ids)
    truth = _poses(folder / TRUTH, _truth_rows(folder / TRUTH), len(steps))
    batch = _poses(folder / BATCH_POSES, _csv(folder / BATCH_POSES, "x_m,y_m,theta_rad"), len(steps))
    return DlrLog(steps, truth, batch, ids, positions, names)


def _log(path: Path, known: IntArray) -> tuple[tuple[tuple[Odometry, Observations], ...], tuple[str, ...]]:
    step_rows: Rows = []
    landmark_rows: Rows = []
    owners: list[int] = []
    for number, text in enumerate(_lines(path), start=1):
        fields = text.split()
        if not fields or fields[0].startswith("#"):
            continue
        if fields[0] == "STEP":
            _expect(path, number, fields, _STEP_FIELDS)
            step_rows.append((number, fields[1:]))
        elif fields[0] == "LANDMARK_C":
            _expect(path, number, fields, _LANDMARK_FIELDS)
            if not step_rows:
                _fail(path, number, "a LANDMARK_C row before the first STEP")
            landmark_rows.append((number, fields[1:]))
            owners.append(len(step_rows) - 1)
        else:
            _fail(path, number, f"unknown keyword {fields[0]!r}; expected STEP or LANDMARK_C")
    if not step_rows:
        raise BenchError(f"{path}: no STEP rows; fetch the log again with: python -m bench fetch dlr")
    odometry = _odometry(path, step_rows)
    observations = _observations(path, landmark_rows, np.array(owners, dtype=np.int64), len(step_rows), known)
    names = tuple(f"{fields[0]}.jpg" for _, fields in step_rows)
    return tuple(zip(odometry, observations, strict=True)), names


def _odometry(path: Path, rows: Rows) -> list[Odometry]:
    values = _numbers(path, [(number, fields[1:]) for number, fields in rows])
    delta = values[:, :3].copy()
    delta[:, :2] = delta[:, :2] @ _TURN.T
    # The columns are cXX cXY cYY cXPhi cYPhi cPhiPhi.
    Q = values[:, 3:][:, [0, 1, 3, 1, 2, 4, 3, 4, 5]].reshape(-1, 3, 3)
    turn = np.eye(3)
    turn[:2, :2] = _TURN
    Q = turn @ Q @ turn.T
    _refuse(
        path, rows, np.linalg.eigvalsh(Q)[:, 0] < 0.0, "the odometry covariance is not positive semi-definite"
    )
    return [Odometry(d, q) for d, q in zip(delta, Q, strict=True)]


def _observations(
    path: Path, rows: Rows, owners: IntArray, steps: int, known: IntArray
) -> list[Observations]:
    if not rows:
        return [Observations.none()] * steps
    values = _numbers(path, rows)
    points = values[:, :2] @ _TURN.T
    S = values[:, 3:6][:, [0, 1, 1, 2]].reshape(-1, 2, 2)
    S = _TURN @ S @ _TURN.T
    _refuse(
        path, rows, np.linalg.eigvalsh(S)[:, 0] <= 0.0, "the landmark covariance is not positive definite"
    )
    ids = values[:, 6].astype(np.int64)
    _refuse(
        path,
        rows,
        (ids != values[:, 6]) | ~np.isin(ids, [-1, *known]),
        f"the landmark id is not in {BATCH_LANDMARKS}",
    )
    ends = np.searchsorted(owners, np.arange(steps), side="right").tolist()
    starts = [0, *ends[:-1]]
    return [Observations(points[a:b], S[a:b], ids[a:b]) for a, b in zip(starts, ends, strict=True)]


def _truth_rows(path: Path) -> Rows:
    rows: Rows = []
    for number, text in enumerate(_lines(path), start=1):
        if not text.strip():
            continue
        try:
            values = json.loads(text)
        except ValueError:
            _fail(path, number, "not a list [x, y, theta, …]")
        if not isinstance(values, list) or len(values) != 12:
            _fail(path, number, "expected a list of 12 numbers: pose and covariance")
        rows.append((number, values[:3]))
    return rows


def _batch_landmarks(path: Path) -> tuple[IntArray, FloatArray]:
    rows = _csv(path, "id,x_m,y_m")
    values = _numbers(path, rows)
    ids = values[:, 0].astype(np.int64)
    _refuse(path, rows, (ids != values[:, 0]) | (ids < 0), "a landmark id is a whole number from 0")
    order = np.argsort(ids)
    first = np.zeros(len(ids), dtype=bool)
    first[np.unique(ids, return_index=True)[1]] = True
    _refuse(path, rows, ~first, "this landmark id occurs twice")
    return ids[order], (values[:, 1:] @ _TURN.T)[order]


def _csv(path: Path, header: str) -> Rows:
    lines = _lines(path)
    if not lines or lines[0].strip() != header:
        raise BenchError(f"{path}, line 1: expected the header {header!r}")
    rows: Rows = []
    for number, text in enumerate(lines[1:], start=2):
        if not text.strip():
            continue
        fields = text.split(",")
        if len(fields) != 3:
            _fail(path, number, f"expected 3 fields, found {len(fields)}")
        rows.append((number, fields))
    return rows


def _poses(path: Path, rows: Rows, steps: int) -> FloatArray:
    if len(rows) != steps + 1:
        raise BenchError(
            f"{path}: {len(rows)} poses for {steps} steps; expected {steps + 1}, the start included"
        )
    poses = _numbers(path, rows)
    poses[:, :2] = poses[:, :2] @ _TURN.T
    return poses


def _numbers(path: Path, rows: Rows) -> FloatArray:
    """Fields as (n, k) float64; the first row that is not finite numbers is named."""
    if not rows:
        raise BenchError(f"{path}: no data rows; fetch the log again with: python -m bench fetch dlr")
    try:
        values = np.array([fields for _, fields in rows], dtype=np.float64)
    except (ValueError, TypeError):
        number, text = next((n, t) for n, fields in rows for t in fields if not _is_number(t))
        _fail(path, number, f"{text!r} is not a number")
    _refuse(path, rows, ~np.isfinite(values).all(axis=1), "a value is not finite")
    return values


def _is_number(text: object) -> bool:
    try:
        np.array(text, dtype=np.float64)
    except (ValueError, TypeError):
        return False
    return not isinstance(text, list | dict)


def _refuse(path: Path, rows: Sequence[tuple[int, list[str]]], bad: ArrayLike, reason: str) -> None:
    if np.any(bad):
        _fail(path, rows[int(np.argmax(bad))][0], reason)


def _expect(path: Path, number: int, fields: list[str], count: int) -> None:
    if len(fields) != count + 1:
        _fail(path, number, f"{fields[0]} has {len(fields) - 1} fields, expected {count}")


def _lines(path: Path) -> list[str]:
    try:
        return path.read_text(encoding="ascii").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not a text file"
        remedy = "give the log's folder with --data or run: python -m bench fetch dlr"
        raise BenchError(f"cannot read {path}: {reason}; {remedy}") from error


def _fail(path: Path, number: int, reason: str) -> NoReturn:
    raise BenchError(f"{path}, line {number}: {reason}")
