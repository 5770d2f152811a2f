"""The table of SLAM runs, summed over seeds: seeds are the random factor, all else is a fixed condition."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from reports.run import BASELINE, OK, Run

if TYPE_CHECKING:
    from pandas import DataFrame, Series

FloatArray = NDArray[np.float64]

CONDITION = ["scene", "illumination", "backend", "association", "observation", "seed"]
METRICS = ("rmse_m", "landmarks_mapped", "nav_success", "nav_cost_ratio")


@dataclass(frozen=True, eq=False)
class RunSums:
    """The runs that did not fail, beside all runs.

    Attributes
    ----------
    good, all : DataFrame
        ``bench.schema.RUN_COLUMNS``.
    """

    good: DataFrame
    all: DataFrame

    def of(self, name: str, illumination: str | None, metric: str) -> FloatArray:
        """(2, n) float64: sum and count of a metric for each of n seeds that have it."""
        rows = _chosen(self.good, name, illumination)
        return _per_seed(rows["seed"], rows[metric])

    def change(self, name: str, illumination: str | None, metric: str) -> FloatArray:
        """(2, n) float64: sum and count of the paired differences to the baseline for each of n seeds."""
        ours = _chosen(self.good, name, illumination)[[*CONDITION, metric]]
        base = _chosen(self.good, BASELINE, illumination)[[*CONDITION, metric]]
        both = ours.merge(base, on=CONDITION, suffixes=("", "_base"))
        return _per_seed(both["seed"], both[metric] - both[f"{metric}_base"])

    def failed(self, name: str, illumination: str | None = None) -> tuple[int, int]:
        """Failed runs and all runs."""
        rows = _chosen(self.all, name, illumination)
        return int((rows["status"] != OK).sum()), len(rows)


def run_sums(run: Run) -> RunSums:
    """Set the failed runs apart."""
    return RunSums(run.runs[run.runs["status"] == OK], run.runs)


def _chosen(rows: DataFrame, name: str, illumination: str | None) -> DataFrame:
    rows = rows[rows["filter"] == name]
    return rows if illumination is None else rows[rows["illumination"] == illumination]


def _per_seed(seeds: Series[int], values: Series[float]) -> FloatArray:
    """Sum and count of the finite values of each seed, in the order of the seeds."""
    finite = np.isfinite(values)
    grouped = values[finite].groupby(seeds[finite], sort=True)
    return np.stack([grouped.sum().to_numpy(np.float64), grouped.count().to_numpy(np.float64)])
