"""The table of SLAM runs, laid out by condition and seed: the two factors that pooled numbers resample."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reports.errors import ReportError
from reports.run import BASELINE, OK, Run

FloatArray = NDArray[np.float64]

CONDITION = ["scene", "illumination", "backend", "association", "observation"]
METRICS = ("rmse_m", "landmarks_mapped", "nav_success", "nav_cost_ratio")


@dataclass(frozen=True, eq=False)
class RunSums:
    """Metrics of every run as arrays over conditions and seeds.

    Attributes
    ----------
    values : dict
        (filter, metric) → (conditions, seeds) float64; NaN where a run failed, is absent or lacks it.
    illuminations : (conditions,) str
        The light of each condition.
    failures : dict
        (filter, illumination) → failed runs and all runs.
    factor : str
        What the conditions are that pooled numbers resample, in the plural.
    """

    values: dict[tuple[str, str], FloatArray]
    illuminations: NDArray[np.str_]
    failures: dict[tuple[str, str], tuple[int, int]]
    factor: str

    def of(self, name: str, illumination: str | None, metric: str) -> FloatArray:
        """(conditions, seeds) float64: a metric under one or every light, NaN where a run has none."""
        return self._under(self.values[name, metric], illumination)

    def change(self, name: str, illumination: str | None, metric: str) -> FloatArray:
        """(conditions, seeds) float64: the paired differences to the baseline."""
        return self._under(self.values[name, metric] - self.values[BASELINE, metric], illumination)

    def failed(self, name: str, illumination: str | None = None) -> tuple[int, int]:
        """Failed runs and all runs."""
        counts = [
            count
            for (of_filter, light), count in self.failures.items()
            if of_filter == name and illumination in (None, light)
        ]
        return sum(bad for bad, _ in counts), sum(total for _, total in counts)

    def _under(self, values: FloatArray, illumination: str | None) -> FloatArray:
        return values if illumination is None else values[self.illuminations == illumination]


def run_sums(run: Run) -> RunSums:
    """Lay the run table out by condition and seed, failed runs as NaN.

    Raises
    ------
    ReportError
        Two rows are the same run.
    """
    table = run.runs.set_index(CONDITION)
    repeated = run.runs.duplicated(["filter", *CONDITION, "seed"])
    if repeated.any():
        raise ReportError(
            f"{run.folder / 'runs.parquet'} holds a run twice (row {int(repeated.to_numpy().argmax())}): "
            "run the study again"
        )
    conditions = table.index.unique().sort_values()
    seeds = np.unique(run.runs["seed"])
    at = (conditions.get_indexer(table.index), np.searchsorted(seeds, table["seed"]))
    good = (table["status"] == OK).to_numpy()
    values = {}
    for name in run.filters:
        chosen = good & (table["filter"] == name).to_numpy()
        for metric in METRICS:
            grid = np.full((len(conditions), len(seeds)), np.nan)
            grid[at[0][chosen], at[1][chosen]] = table[metric].to_numpy(np.float64)[chosen]
            values[name, metric] = grid
    lights = conditions.get_level_values("illumination").to_numpy(dtype=str)
    factor = "illuminations" if run.runs["scene"].nunique() < 2 else "scenes under lights"
    return RunSums(values, lights, _failures(run), factor)


def _failures(run: Run) -> dict[tuple[str, str], tuple[int, int]]:
    keys = list(zip(run.runs["filter"], run.runs["illumination"], strict=True))
    every, bad = Counter(keys), Counter(k for k, s in zip(keys, run.runs["status"], strict=True) if s != OK)
    return {key: (bad[key], count) for key, count in every.items()}
