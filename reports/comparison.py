"""What a filter reaches and what it changes against doing nothing, each number with its interval."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reports import statistics as s
from reports.frame_sums import FrameSums, frame_sums
from reports.run import BASELINE, Run
from reports.run_sums import RunSums, run_sums
from reports.statistics import Estimate
from reports.wording import plural

if TYPE_CHECKING:
    from pandas import DataFrame

Condition = str | None
"""Name of an illumination, or None for all of them pooled."""

RECALL = ("detections_true", "landmarks_visible")
PRECISION = ("detections_true", "landmarks_detected")


@dataclass(frozen=True, eq=False)
class Comparison:
    """Estimates from one rendered run, by filter and condition.

    Attributes
    ----------
    frames : FrameSums
    runs : RunSums
    table : DataFrame
        The frame table itself, ``bench.schema.FRAME_COLUMNS``.
    """

    frames: FrameSums
    runs: RunSums
    table: DataFrame

    @property
    def filters(self) -> frozenset[str]:
        """Those that have filtered a picture, rather than failed on all."""
        return frozenset(self.table["filter"])

    def recall(self, name: str, condition: Condition = None) -> Estimate:
        """Landmarks found of landmarks visible, 0…1."""
        return self._frame_ratio(name, condition, *RECALL)

    def precision(self, name: str, condition: Condition = None) -> Estimate:
        """Detections that are landmarks, 0…1."""
        return self._frame_ratio(name, condition, *PRECISION)

    def recall_change(self, name: str, condition: Condition = None) -> Estimate:
        """Recall minus that without a filter, paired by block."""
        return self._frame_change(name, condition, *RECALL)

    def precision_change(self, name: str, condition: Condition = None) -> Estimate:
        """Precision minus that without a filter, paired by block."""
        return self._frame_change(name, condition, *PRECISION)

    def mask(self, name: str, metric: str, condition: Condition = None) -> Estimate:
        """Mean over the frames that have it of iou, f1, ap, ber, masked_share or true_share."""
        return self._frame_ratio(name, condition, metric, f"{metric}_frames")

    def right_pixels(self, name: str, condition: Condition = None) -> Estimate:
        """Share of pixels that the mask gets right, 0…1."""
        return self._frame_ratio(name, condition, "right_pixels", "frames")

    def psnr(self, name: str, condition: Condition = None) -> Estimate:
        """PSNR over the whole frame, dB."""
        return s.estimate(
            s.decibel, self.frames.of(name, condition, "error", "error_frames"), self.frames.unit
        )

    def psnr_change(self, name: str, condition: Condition = None) -> Estimate:
        """PSNR minus that of the untouched picture, dB."""
        ours = self.frames.of(name, condition, "error")
        base = self.frames.of(BASELINE, condition, "error")
        return self._paired(s.decibel_change, ours, base)

    def psnr_in_mask(self, name: str, condition: Condition = None) -> Estimate:
        """PSNR inside the true mask, dB, over the frames that have one."""
        sums = self.frames.of(name, condition, "error_in_mask", "error_in_mask_frames")
        return s.estimate(s.decibel, sums, self.frames.unit)

    def psnr_in_mask_change(self, name: str, condition: Condition = None) -> Estimate:
        """PSNR inside the true mask minus that of the untouched picture, dB."""
        ours = self.frames.of(name, condition, "error_in_mask")
        base = self.frames.of(BASELINE, condition, "error_in_mask")
        return self._paired(s.decibel_change, ours, base)

    def run_metric(self, name: str, metric: str, condition: Condition = None) -> Estimate:
        """Mean of a metric over the runs that did not fail."""
        return s.crossed(self.runs.of(name, condition, metric), self.runs.factor, "seeds")

    def run_change(self, name: str, metric: str, condition: Condition = None) -> Estimate:
        """Mean paired difference to the run without a filter, by condition and seed."""
        differences = self.runs.change(name, condition, metric)
        return s.crossed(differences, self.runs.factor, "seeds", paired=True)

    def filter_ms(self, name: str, condition: Condition = None) -> float:
        """Median time per picture, ms: a median, because the first call compiles and caches."""
        rows = self.table[self.table["filter"] == name]
        if condition is not None:
            rows = rows[rows["illumination"] == condition]
        return float(rows["filter_ms"].median())

    def _frame_ratio(self, name: str, condition: Condition, part: str, whole: str) -> Estimate:
        return s.estimate(s.ratio, self.frames.of(name, condition, part, whole), self.frames.unit)

    def _frame_change(self, name: str, condition: Condition, part: str, whole: str) -> Estimate:
        ours = self.frames.of(name, condition, part, whole)
        base = self.frames.of(BASELINE, condition, part, whole)
        return self._paired(s.ratio_change, ours, base)

    def _paired(self, statistic: s.Statistic, ours: s.FloatArray, base: s.FloatArray) -> Estimate:
        changed = (ours != base).any(axis=0)
        return s.estimate(statistic, np.concatenate([ours, base]), self.frames.unit, changed)


def compare(run: Run) -> Comparison:
    """Prepare the comparisons of a rendered run."""
    return Comparison(frame_sums(run), run_sums(run), run.frames)


def left_out_text(comparison: Comparison) -> str:
    """How many pictures no filter is compared on."""
    return f"Left out: {plural(comparison.frames.left_out, 'picture')} that not every filter has."
