"""Trajectories, landmark maps and occupancy as the runner stores them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports.errors import ReportError

if TYPE_CHECKING:
    from pandas import DataFrame

FloatArray = NDArray[np.float64]

LANDMARK_COLUMNS = ("id", "x_true_m", "y_true_m", "x_est_m", "y_est_m")
STAMP_TOLERANCE_S = 1e-3


@dataclass(frozen=True, eq=False)
class Track:
    """A path on the floor.

    Attributes
    ----------
    stamps : (n,) float64, seconds
    xy : (n, 2) float64, metres
    """

    stamps: FloatArray
    xy: FloatArray


@dataclass(frozen=True, eq=False)
class Occupancy:
    """The true grid behind a map.

    Attributes
    ----------
    blocked : (rows, cols) bool
    extent : (x_min, x_max, y_min, y_max), metres
    """

    blocked: NDArray[np.bool_]
    extent: tuple[float, float, float, float]


def stem(row: Mapping[str, Any]) -> str:
    """File stem of one row of the run table."""
    parts = [
        str(row[k]) for k in ("scene", "illumination", "filter", "backend", "association", "observation")
    ]
    return "--".join([*parts, f"s{row['seed']}"])


def truth(folder: Path, scene: str) -> Track:
    """The true path through a scene."""
    return read_tum(folder / "trajectories" / f"truth--{scene}.tum")


def estimate(folder: Path, row: Mapping[str, Any]) -> Track:
    """The estimated path of one run."""
    return read_tum(folder / "trajectories" / f"{stem(row)}.tum")


def read_tum(path: Path) -> Track:
    """Read ``t x y z qx qy qz qw`` rows.

    Raises
    ------
    ReportError
        The file is missing, or a row does not hold eight finite numbers.
    """
    if not path.exists():
        raise ReportError(f"{path} is missing: run the study again")
    rows = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        try:
            values = [float(v) for v in line.split()]
        except ValueError:
            values = []
        if len(values) != 8 or not np.isfinite(values).all():
            raise ReportError(f"{path}, line {number}: expected 8 finite numbers: run the study again")
        rows.append(values)
    if not rows:
        raise ReportError(f"{path} has no poses: run the study again")
    table = np.array(rows)
    return Track(table[:, 0], table[:, 1:3])


def paired(true: Track, estimated: Track, name: str) -> tuple[FloatArray, FloatArray]:
    """The poses that both tracks have, (n, 2) each, matched by stamp.

    Raises
    ------
    ReportError
        No stamp of the estimate occurs in the truth.
    """
    order = np.argsort(true.stamps, kind="stable")
    stamps = true.stamps[order]
    right = np.clip(np.searchsorted(stamps, estimated.stamps), 1, max(len(stamps) - 1, 1))
    right = np.minimum(right, len(stamps) - 1)
    left = np.maximum(right - 1, 0)
    nearer_left = np.abs(stamps[left] - estimated.stamps) <= np.abs(stamps[right] - estimated.stamps)
    near = np.where(nearer_left, left, right)
    same = np.abs(stamps[near] - estimated.stamps) <= STAMP_TOLERANCE_S
    if not same.any():
        raise ReportError(f"{name} shares no time stamp with its true trajectory: run the study again")
    return true.xy[order][near[same]], estimated.xy[same]


def landmarks(folder: Path, row: Mapping[str, Any]) -> DataFrame:
    """True and estimated landmarks of one run; duplicates are further rows of the same id."""
    return read_csv(folder / "figures" / f"landmarks--{stem(row)}.csv", LANDMARK_COLUMNS)


def read_csv(path: Path, columns: tuple[str, ...]) -> DataFrame:
    """Read a CSV file that must have certain columns.

    Raises
    ------
    ReportError
        The file is missing, no CSV, or lacks a column.
    """
    import pandas as pd

    if not path.exists():
        raise ReportError(f"{path} is missing: run the study again")
    try:
        table = pd.read_csv(path)
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise ReportError(f"{path} is no readable CSV file: run the study again") from error
    missing = [c for c in columns if c not in table.columns]
    if missing:
        raise ReportError(f"{path} lacks the columns {', '.join(missing)}: run the study again")
    return table


def occupancy(folder: Path, scene: str) -> Occupancy | None:
    """The true grid of a scene, or None where the run stored none."""
    path = folder / "figures" / f"occupancy--{scene}.npz"
    if not path.exists():
        return None
    try:
        with np.load(path, allow_pickle=False) as stored:
            blocked = np.asarray(stored["blocked"], dtype=bool)
            x, y = (float(v) for v in stored["origin"])
            cell = float(stored["resolution"])
    except (OSError, KeyError, ValueError, EOFError) as error:
        raise ReportError(f"{path} holds no occupancy grid: run the study again") from error
    if blocked.ndim != 2:
        raise ReportError(f"{path} holds no two-dimensional grid: run the study again")
    rows, columns = blocked.shape
    return Occupancy(blocked, (x, x + columns * cell, y, y + rows * cell))
