"""Landmark logs in text: g2o with SE(2) poses and XY landmarks, and Victoria Park's ODOMETRY and LANDMARK.

Forms
-----
g2o (Kümmerle et al. 2011)::

    VERTEX_SE2 i x y θ          VERTEX_XY l x y              FIX i
    EDGE_SE2 i j Δx Δy Δθ I11 I12 I13 I22 I23 I33            information of the increment
    EDGE_SE2_XY i l x y I11 I12 I22                          of the landmark seen in the robot's frame

Victoria Park, as GTSAM distributes it, with covariances instead of information::

    ODOMETRY i j Δx Δy Δθ C11 C12 C13 C22 C23 C33
    LANDMARK i l x y C11 C12 C22

Conventions
-----------
- x forward, y left, metres and radians, as ours. The frame is that of the first pose.
- An online estimator needs a stream: the increments must form one chain, each from where the one before
  ends. A file with loop closures between poses is refused, since no back-end here would use them.
- What is seen from the first pose belongs to a first step that does not move.
- Vertices are the reference where the file has them for every pose; they are somebody's estimate, no truth.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.errors import BenchError
from vslam.frame import Observations, Odometry
from vslam.geometry import to_local, wrap_angle

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LandmarkLog:
    """A landmark log.

    Attributes
    ----------
    steps : tuple of n (Odometry, Observations)
        One for each pose; the first does not move.
    reference : (n, 3) float64 or None
        Pose at each step in the frame of the first, heading not wrapped; None where the file has none.
    landmark_ids : (m,) int64
        Rising.
    landmark_positions : (m, 2) float64
        Metres, in the same frame; NaN where the file does not say.
    """

    steps: tuple[tuple[Odometry, Observations], ...]
    reference: FloatArray | None
    landmark_ids: NDArray[np.int64]
    landmark_positions: FloatArray


@dataclass
class _Content:
    """A file's rows as they are read."""

    increments: dict[int, tuple[int, FloatArray, FloatArray]] = field(default_factory=dict)
    seen: dict[int, list[tuple[int, FloatArray, FloatArray]]] = field(
        default_factory=lambda: defaultdict(list)
    )
    poses: dict[int, FloatArray] = field(default_factory=dict)
    landmarks: dict[int, FloatArray] = field(default_factory=dict)


def load(path: Path) -> LandmarkLog:
    """Read a log of either form; the tags of its rows say which it is.

    Raises
    ------
    BenchError
        In one line, with the number of the row: an unknown tag, numbers that do not fit, a matrix that is not
        positive definite, increments that form no chain, a landmark seen from a pose that does not exist.
    """
    content = _Content()
    for number, fields in _rows(path):
        where = f"{path}, line {number}"
        take = _TAGS.get(fields[0])
        if take is None:
            raise BenchError(f"{where}: unknown tag {fields[0]!r}; known are {', '.join(_TAGS)}")
        count, keep = take
        keep(content, _numbers(fields[1:], count, where), where)
    return _assembled(content, path)


def _rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise BenchError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    for number, line in enumerate(lines, start=1):
        fields = line.split("#")[0].split()
        if fields:
            yield number, fields


def _numbers(fields: list[str], count: int, where: str) -> FloatArray:
    try:
        numbers = np.array([float(f) for f in fields])
    except ValueError:
        raise BenchError(f"{where}: holds something that is no number: {' '.join(fields)[:60]!r}") from None
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise BenchError(f"{where}: expected {count} finite numbers after the tag, got {len(numbers)}")
    return numbers


def _vertex(content: _Content, numbers: FloatArray, where: str) -> None:
    content.poses[int(numbers[0])] = numbers[1:4]


def _landmark(content: _Content, numbers: FloatArray, where: str) -> None:
    content.landmarks[int(numbers[0])] = numbers[1:3]


def _fixed(content: _Content, numbers: FloatArray, where: str) -> None:
    """The first pose is the frame here, whatever a file fixes."""


def _increment(inverse: bool) -> Callable[[_Content, FloatArray, str], None]:
    def keep(content: _Content, numbers: FloatArray, where: str) -> None:
        start, end = int(numbers[0]), int(numbers[1])
        if start in content.increments:
            raise BenchError(
                f"{where}: a second increment from pose {start}, to {end}; a log is one chain of them"
            )
        matrix = _symmetric(numbers[5:11], 3, inverse, where)
        content.increments[start] = end, numbers[2:5], matrix

    return keep


def _sight(inverse: bool) -> Callable[[_Content, FloatArray, str], None]:
    def keep(content: _Content, numbers: FloatArray, where: str) -> None:
        matrix = _symmetric(numbers[4:7], 2, inverse, where)
        content.seen[int(numbers[0])].append((int(numbers[1]), numbers[2:4], matrix))

    return keep


_TAGS: dict[str, tuple[int, Callable[[_Content, FloatArray, str], None]]] = {
    "VERTEX_SE2": (4, _vertex),
    "VERTEX_XY": (3, _landmark),
    "FIX": (1, _fixed),
    "EDGE_SE2": (11, _increment(inverse=True)),
    "EDGE_SE2_XY": (7, _sight(inverse=True)),
    "ODOMETRY": (11, _increment(inverse=False)),
    "LANDMARK": (7, _sight(inverse=False)),
}


def _symmetric(upper: FloatArray, size: int, inverse: bool, where: str) -> FloatArray:
    """The covariance from an upper triangle, which may hold the information instead."""
    matrix = np.zeros((size, size))
    matrix[np.triu_indices(size)] = upper
    matrix = matrix + np.triu(matrix, 1).T
    if np.linalg.eigvalsh(matrix)[0] <= 0.0:
        kind = "information" if inverse else "covariance"
        raise BenchError(f"{where}: its {kind} is not positive definite")
    return np.asarray(np.linalg.inv(matrix)) if inverse else matrix


def _assembled(content: _Content, path: Path) -> LandmarkLog:
    order = _chain(content, path)
    strangers = sorted(set(content.seen) - set(order))
    if strangers:
        raise BenchError(f"{path}: a landmark is seen from pose {strangers[0]}, which no increment leads to")
    steps = [(Odometry(np.zeros(3), np.zeros((3, 3))), _observations(content, order[0]))]
    for start, end in pairwise(order):
        _, delta, covariance = content.increments[start]
        steps.append((Odometry(delta, covariance), _observations(content, end)))
    ids = np.array(sorted({i for seen in content.seen.values() for i, _, _ in seen}), dtype=np.int64)
    reference, positions = _reference(content, order, ids)
    return LandmarkLog(tuple(steps), reference, ids, positions)


def _chain(content: _Content, path: Path) -> list[int]:
    """Numbers of the poses, one to the next."""
    if not content.increments:
        raise BenchError(f"{path}: holds no increment (EDGE_SE2 or ODOMETRY)")
    ends = {end for end, _, _ in content.increments.values()}
    starts = sorted(set(content.increments) - ends)
    if len(starts) != 1:
        which = ", ".join(map(str, starts[:3])) or "none"
        raise BenchError(f"{path}: its increments form no chain: poses that none leads to: {which}")
    order = starts
    while order[-1] in content.increments:
        order.append(content.increments[order[-1]][0])
    if len(order) != len(content.increments) + 1:
        raise BenchError(f"{path}: its increments form no chain: {len(order)} poses in a row from {order[0]}")
    return order


def _observations(content: _Content, pose: int) -> Observations:
    seen = content.seen.get(pose, [])
    if not seen:
        return Observations.none()
    ids, points, covariances = zip(*seen, strict=True)
    return Observations(np.array(points), np.array(covariances), np.array(ids, dtype=np.int64))


def _reference(
    content: _Content, order: list[int], ids: NDArray[np.int64]
) -> tuple[FloatArray | None, FloatArray]:
    """Vertices in the frame of the first pose."""
    positions = np.full((len(ids), 2), np.nan)
    if any(pose not in content.poses for pose in order):
        return None, positions
    poses = np.array([content.poses[pose] for pose in order])
    first = poses[0].copy()
    for row, number in enumerate(ids):
        if int(number) in content.landmarks:
            positions[row] = to_local(first, content.landmarks[int(number)][None])[0]
    turns = wrap_angle(np.diff(poses[:, 2], prepend=first[2]))
    return np.column_stack([to_local(first, poses[:, :2]), np.cumsum(turns)]), positions
