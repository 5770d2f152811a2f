"""What the provenance tells of a run besides the versions, and the names of its files."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bench.schema import FRAME_COLUMNS, RUN_COLUMNS


@dataclass(frozen=True)
class RunFacts:
    """Engine, notice about it, and seconds per stage."""

    engine: str
    engine_notice: str = ""
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Note the seconds that a stage takes."""
        start = time.perf_counter()
        yield
        self.seconds[stage] = time.perf_counter() - start


def empty_run_row() -> dict[str, object]:
    """A row of the runs table in which everything is still empty: NaN, 0 and no text."""
    empty: dict[str, object] = {"float64": math.nan, "int64": 0, "string": ""}
    return {name: empty[kind] for name, kind in RUN_COLUMNS.items()}


def empty_frame_row() -> dict[str, object]:
    """A row of the frames table in which everything is still empty: NaN, 0 and no text."""
    empty: dict[str, object] = {"float64": math.nan, "int64": 0, "string": ""}
    return {name: empty[kind] for name, kind in FRAME_COLUMNS.items()}


def run_stem(row: Mapping[str, object]) -> str:
    """File stem of what belongs to one row of the runs table."""
    keys = ("scene", "illumination", "filter", "backend", "association", "observation")
    return "--".join(str(row[k]) for k in keys) + f"--s{row['seed']}"


def landmark_csv(table: NDArray[np.float64]) -> str:
    """Landmarks of one run, (n, 5), as CSV."""
    lines = [f"{int(i)},{a:.6f},{b:.6f},{c:.6f},{d:.6f}" for i, a, b, c, d in table]
    return "\n".join(["id,x_true_m,y_true_m,x_est_m,y_est_m", *lines]) + "\n"
