"""Trajectory files: TUM's text, and the true poses of a sequence in any layout that has them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bench.errors import BenchError
from bench.metrics.space_trajectory import SpaceTrack

TUM_TRUTH = "groundtruth.txt"
EUROC_TRUTH = "mav0/state_groundtruth_estimate0/data.csv"


def read_tum(path: Path) -> SpaceTrack:
    """Read ``t x y z qx qy qz qw`` lines; empty lines and those with # are passed over.

    Raises
    ------
    BenchError
        With the number of the line that does not fit.
    """
    numbers = _numbers(path, " ", 8)
    return _track(path, numbers[:, 0], numbers[:, 1:4], numbers[:, 4:8])


def read_truth(sequence: Path) -> SpaceTrack:
    """The true poses of a sequence: a folder in TUM or EuRoC layout, or a trajectory file.

    Raises
    ------
    BenchError
        When there are none, or they cannot be read.
    """
    if sequence.is_file():
        return read_tum(sequence)
    if (sequence / TUM_TRUTH).is_file():
        return read_tum(sequence / TUM_TRUTH)
    if (sequence / EUROC_TRUTH).is_file():
        numbers = _numbers(sequence / EUROC_TRUTH, ",", 8)
        wxyz = numbers[:, 4:8]
        return _track(sequence / EUROC_TRUTH, numbers[:, 0] * 1e-9, numbers[:, 1:4], wxyz[:, [1, 2, 3, 0]])
    raise BenchError(
        f"{sequence}: no true poses; give a sequence in TUM layout ({TUM_TRUTH}) or EuRoC layout "
        f"({EUROC_TRUTH}), or a file of TUM lines"
    )


def _track(
    path: Path, stamps: NDArray[np.float64], positions: NDArray[np.float64], xyzw: NDArray[np.float64]
) -> SpaceTrack:
    length = np.linalg.norm(xyzw, axis=1)
    odd = np.flatnonzero(np.abs(length - 1) > 1e-2)
    if len(odd):
        raise BenchError(
            f"{path}: pose {int(odd[0]) + 1}: its quaternion has length {length[odd[0]]:.3f}, not 1"
        )
    try:
        return SpaceTrack(stamps, positions, Rotation.from_quat(xyzw))
    except BenchError as error:
        raise BenchError(f"{path}: {str(error).removeprefix('trajectory: ')}") from None


def _numbers(path: Path, separator: str, least: int) -> NDArray[np.float64]:
    """(n, least) float64 of the first numbers of each line."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise BenchError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    rows = []
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        fields = [f for f in line.strip().split(separator) if f]
        try:
            row = [float(field) for field in fields[:least]]
        except ValueError:
            row = []
        if len(row) < least or not np.isfinite(row).all():
            raise BenchError(
                f"{path}, line {number}: expected {least} finite numbers, got {line.strip()[:60]!r}"
            )
        rows.append(row)
    if not rows:
        raise BenchError(f"{path}: holds no pose")
    return np.array(rows)
