"""Drives in closed loop, counted: successes with Wilson's interval, and the paired difference to no filter.

Sources
-------
Interval of a share: Wilson 1927, *Probable inference, the law of succession, and statistical inference*.
Paired shares: McNemar's exact test (1947) on the drives that only one of two filters brought home. SPL:
Anderson et al. 2018, *On evaluation of embodied navigation agents*.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from bench.schema import DRIVE_COLUMNS
from reports.illuminations import COLUMNS, Illumination
from reports.run import BASELINE, Run, read_table, records
from reports.statistics import CONFIDENCE, Estimate, estimate, ratio
from reports.tables import Failure, counted
from reports.wording import listing, number

if TYPE_CHECKING:
    from pandas import DataFrame

GOAL, EXPLORE = "goal", "explore"
PAIRED_ON = ["illumination", "task", "episode"]


@dataclass(frozen=True, eq=False)
class Drives:
    """The table of drives.

    Attributes
    ----------
    table : DataFrame
        `bench.schema.DRIVE_COLUMNS`.
    filters : tuple of str
        In the study's order, the baseline first.
    lights : tuple of Illumination
        From dark to bright.
    """

    table: DataFrame
    filters: tuple[str, ...]
    lights: tuple[Illumination, ...]

    def of(self, task: str, name: str, light: str | None = None) -> DataFrame:
        """The drives of a task with one filter, under one light or all."""
        t = self.table
        chosen = (t["task"] == task) & (t["filter"] == name)
        return t[chosen if light is None else chosen & (t["illumination"] == light)]

    def has(self, task: str) -> bool:
        """Whether the study had this task."""
        return bool((self.table["task"] == task).any())


@cache
def load(folder: Path) -> Drives:
    """The drives of a run folder.

    Raises
    ------
    ReportError
        The table is missing or damaged.
    """
    table = read_table(folder / "drives.parquet", DRIVE_COLUMNS)
    present = list(dict.fromkeys(table["filter"]))
    filters = [BASELINE, *present] if BASELINE in present else present
    lights = sorted(Illumination.of(row) for row in records(table[list(COLUMNS)].drop_duplicates()))
    return Drives(table, tuple(dict.fromkeys(filters)), tuple(lights))


def drives(run: Run) -> Drives:
    """The drives of a run."""
    return load(run.folder)


def wilson(successes: int, trials: int) -> Estimate:
    """A share with Wilson's 95 % interval; NaN without trials."""
    if trials == 0:
        return Estimate(math.nan, note="nothing to measure")
    from scipy.stats import norm

    z, p = float(norm.ppf(0.5 + CONFIDENCE / 2)), successes / trials
    centre = (p + z * z / (2 * trials)) / (1 + z * z / trials)
    half = z * math.sqrt(p * (1 - p) / trials + z * z / (4 * trials**2)) / (1 + z * z / trials)
    return Estimate(p, max(centre - half, 0.0), min(centre + half, 1.0), trials, "drives")


def share(rows: DataFrame, column: str) -> Estimate:
    """The share of drives with a 1 in a column, with Wilson's interval."""
    return wilson(int(rows[column].sum()), len(rows))


def mean(rows: DataFrame, column: str) -> Estimate:
    """The mean over drives with a bootstrap interval, where there are enough of them."""
    values = rows[column].to_numpy(np.float64)
    values = values[np.isfinite(values)]
    return estimate(ratio, np.stack([values, np.ones_like(values)]), "drives")


def recall(rows: DataFrame) -> Estimate:
    """Share of the visible landmarks that were detected, drives resampled."""
    sums = rows[["detections_true", "landmarks_visible"]].to_numpy(np.float64).T
    return estimate(ratio, sums, "drives")


def discordant(all_drives: Drives, name: str, task: str, light: str | None = None) -> tuple[int, int, float]:
    """Drives that only the filter, and that only doing nothing brought home, and McNemar's exact p."""
    from scipy.stats import binomtest

    with_it = all_drives.of(task, name, light).set_index(PAIRED_ON)["success"]
    without = all_drives.of(task, BASELINE, light).set_index(PAIRED_ON)["success"]
    joined = with_it.to_frame("with").join(without.rename("without"), how="inner")
    gained = int(((joined["with"] == 1) & (joined["without"] == 0)).sum())
    lost = int(((joined["with"] == 0) & (joined["without"] == 1)).sum())
    p = float(binomtest(gained, gained + lost).pvalue) if gained + lost else 1.0
    return gained, lost, p


def outcomes(rows: DataFrame) -> str:
    """What became of the drives that did not succeed: "2 lost, 1 collision"."""
    counts = Counter(rows[rows["success"] == 0]["outcome"])
    return ", ".join(f"{count} {name}" for name, count in sorted(counts.items())) or "none"


def titles(run: Run) -> dict[str, tuple[str, str]]:
    """Of each task, its heading and what a drive has done that succeeded in it."""
    home = (run.study.get("drive") or {}).get("home", True)
    return {
        GOAL: ("To the goal and home", "came home") if home else ("To the goal", "reached the goal"),
        EXPLORE: ("Exploring the unknown", "left nothing unexplored that could be reached"),
    }


def failures(run: Run) -> tuple[Failure, ...]:
    """Drives that the robot's own software ended, not the world or the clock."""
    table = drives(run).table
    broken = table[table["outcome"].str.startswith("failed:")]
    return counted(broken, "drive", "outcome")


def verdict(run: Run) -> str:
    """Does the filter bring the robot home? One sentence."""
    own = drives(run)
    task = GOAL if own.has(GOAL) else EXPLORE
    what = titles(run)[task][1]
    base = own.of(task, BASELINE)
    begin = f"Without a filter {int(base['success'].sum())} of {len(base)} drives {what}"
    parts = []
    for name in (f for f in own.filters if f != BASELINE):
        rows = own.of(task, name)
        gained, lost, p = discordant(own, name, task)
        told = f"{int(rows['success'].sum())} of {len(rows)} with {name}"
        if gained + lost == 0:
            parts.append(f"{told} (the same drives)")
        else:
            sure = "a difference" if p < 1 - CONFIDENCE else "no difference that so few drives can show"
            parts.append(f"{told} ({gained} gained, {lost} lost: {sure}, p = {number(p, 3)})")
    return f"{begin}, {listing(parts)}." if parts else f"{begin}."
