"""What the pairs say of each filter: means over the pictures, and the change against doing nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bench.schema import MASK_COLUMNS, PICTURE_COLUMNS
from reports import statistics as s
from reports.run import BASELINE, OK, Run, read_table
from reports.statistics import Estimate
from reports.tables import Failure, counted

if TYPE_CHECKING:
    from pandas import DataFrame

UNIT = "pictures"


@dataclass(frozen=True)
class Measure:
    """One number per picture.

    Attributes
    ----------
    key : str
        Column of the table.
    title, unit : str
    digits : int
    higher_is_better : bool
    """

    key: str
    title: str
    unit: str
    digits: int
    higher_is_better: bool = True

    @property
    def heading(self) -> str:
        """Title and unit: "PSNR, dB"."""
        return f"{self.title}, {self.unit}" if self.unit else self.title


REPAIR = (
    Measure("psnr_db", "PSNR", "dB", 2),
    Measure("psnr_in_mask_db", "in-mask PSNR", "dB", 2),
    Measure("ssim", "SSIM", "", 4),
    Measure("ssim_volume", "SSIM (3-D)", "", 4),
    Measure("lmse", "LMSE", "", 4, higher_is_better=False),
    Measure("delta_e", "ΔE2000", "", 2, higher_is_better=False),
    Measure("filter_ms", "time", "ms", 1, higher_is_better=False),
)
DETECTION = (
    Measure("iou", "IoU", "", 3),
    Measure("f1", "F1", "", 3),
    Measure("ber", "BER", "", 3, higher_is_better=False),
    Measure("ap", "AP", "", 3),
)


@dataclass(frozen=True, eq=False)
class Pairs:
    """The two tables of a run, and its filters in the study's order."""

    pictures: DataFrame
    masks: DataFrame
    filters: tuple[str, ...]

    @property
    def truths(self) -> tuple[str, ...]:
        """Names of the true masks, as stored."""
        return tuple(dict.fromkeys(self.masks["truth"]))


def read(run: Run) -> Pairs:
    """Read and check the tables.

    Raises
    ------
    ReportError
        When one is missing or damaged.
    """
    pictures = read_table(run.folder / "pictures.parquet", PICTURE_COLUMNS)
    masks = read_table(run.folder / "masks.parquet", MASK_COLUMNS)
    return Pairs(pictures, masks, tuple(dict.fromkeys(pictures["filter"])))


def mean(table: DataFrame, name: str, key: str) -> Estimate:
    """The mean over the pictures that have the number: as the field does it, of decibels too."""
    values = table.loc[table["filter"] == name, key].to_numpy(np.float64)
    measured = np.isfinite(values)
    sums = np.stack([np.where(measured, values, 0.0), measured.astype(np.float64)])
    return s.estimate(s.ratio, sums, UNIT)


def change(table: DataFrame, name: str, key: str) -> Estimate:
    """The mean difference to doing nothing on the same pictures."""
    wide = table.pivot(index="picture", columns="filter", values=key)
    difference = (wide[name] - wide[BASELINE]).to_numpy(np.float64)
    measured = np.isfinite(difference)
    sums = np.stack([np.where(measured, difference, 0.0), measured.astype(np.float64)])
    return s.estimate(s.ratio, sums, UNIT, difference != 0.0)


def mark(measure: Measure, effect: Estimate) -> str:
    """Better or worse than doing nothing, where the interval can tell; otherwise empty."""
    if not effect.excludes_zero:
        return ""
    return "better" if (effect.value > 0.0) == measure.higher_is_better else "worse"


def failures(run: Run) -> tuple[Failure, ...]:
    """Every reason for which a filter failed on pictures."""
    pictures = read(run).pictures
    bad = pictures[pictures["status"] != OK]
    return counted(bad, "picture")
