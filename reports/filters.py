"""What a study of filters says: the comparison on lit pictures, on pictures without highlights, by scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

from bench.schema import FRAME_COLUMNS, TIME_COLUMNS
from reports.comparison import Comparison, Condition, compare
from reports.run import BASELINE, OK, Run, read_table
from reports.statistics import Estimate

if TYPE_CHECKING:
    from pandas import DataFrame

ORACLE = "oracle"
"""Stored beside the filters: repaired from the true mask and the true diffuse picture."""


@dataclass(frozen=True)
class Measure:
    """One number of a filter.

    Attributes
    ----------
    key, title, unit : str
    digits : int
    of : callable
        (comparison, filter, condition) → Estimate, in ``unit`` after ``scale``.
    scale : float
    change : bool
        Whether it is a paired change against doing nothing, signed, and marked where it excludes zero.
    """

    key: str
    title: str
    unit: str
    digits: int
    of: Callable[[Comparison, str, Condition], Estimate]
    scale: float = 1.0
    change: bool = False

    @property
    def heading(self) -> str:
        """Title and unit: "IoU", "masked, %"."""
        return f"{self.title}, {self.unit}" if self.unit else self.title

    def measure(self, comparison: Comparison, name: str, condition: Condition = None) -> Estimate:
        """The number in its unit."""
        value = self.of(comparison, name, condition)
        low, high = value.low * self.scale, value.high * self.scale
        return replace(value, value=value.value * self.scale, low=low, high=high)


def _mask(metric: str) -> Callable[[Comparison, str, Condition], Estimate]:
    return lambda comparison, name, condition: comparison.mask(name, metric, condition)


IOU = Measure("iou", "IoU", "", 3, _mask("iou"))
F1 = Measure("f1", "F1", "", 3, _mask("f1"))
AP = Measure("ap", "AP", "", 3, _mask("ap"))
MASKED = Measure("masked_share", "masked", "%", 2, _mask("masked_share"), scale=100)
IN_MASK = Measure("psnr_in_mask_db", "in-mask PSNR", "dB", 2, lambda c, f, light: c.psnr_in_mask(f, light))
IN_MASK_CHANGE = Measure(
    "psnr_in_mask_change_db",
    "in-mask PSNR change",
    "dB",
    2,
    lambda c, f, light: c.psnr_in_mask_change(f, light),
    change=True,
)
PSNR_CHANGE = Measure(
    "psnr_change_db", "frame PSNR change", "dB", 2, lambda c, f, light: c.psnr_change(f, light), change=True
)
RECALL_CHANGE = Measure(
    "recall_change",
    "recall change",
    "points",
    1,
    lambda c, f, light: c.recall_change(f, light),
    scale=100,
    change=True,
)


@dataclass(frozen=True, eq=False)
class Filters:
    """The comparisons of a run.

    Attributes
    ----------
    run : Run
        As stored; ``lit_run`` has the oracle among its filters.
    highlight_free : Comparison
        On the pictures without any specular light.
    neutral : Comparison, optional
        Over the pixels of white and grey objects; None where no picture shows one.
    times : DataFrame
        ``bench.schema.TIME_COLUMNS``.
    """

    run: Run
    lit_run: Run
    highlight_free: Comparison
    neutral: Comparison | None
    times: DataFrame

    @cached_property
    def lit(self) -> Comparison:
        """All scenes together."""
        return compare(self.lit_run)

    @cached_property
    def by_scene(self) -> dict[str, Comparison]:
        """Each scene by itself, in the study's order."""
        return {name: compare(self.lit_run.in_scene(name)) for name in self.scenes}

    @property
    def scenes(self) -> tuple[str, ...]:
        """In the study's order."""
        return tuple(dict.fromkeys(self.run.frames["scene"]))

    @property
    def levels(self) -> tuple[str, ...]:
        """Names of the levels of light, in the study's order."""
        return tuple(dict.fromkeys(self.run.frames["illumination"]))

    @property
    def names(self) -> tuple[str, ...]:
        """The filters that filtered a picture, the baseline first, the oracle last."""
        return tuple(name for name in self.lit_run.filters if name in self.lit.filters)

    @property
    def light_filters(self) -> tuple[str, ...]:
        """Without the baseline and the oracle."""
        return tuple(name for name in self.names if name not in (BASELINE, ORACLE))

    @property
    def sizes(self) -> tuple[tuple[int, int], ...]:
        """Width and height of the pictures that filters were timed on."""
        return tuple(dict.fromkeys(zip(self.times["width"], self.times["height"], strict=True)))

    def milliseconds(self, name: str, size: tuple[int, int]) -> float:
        """Median time of a filter for a picture of a size; NaN where it was not measured."""
        at = (self.times["width"] == size[0]) & (self.times["height"] == size[1])
        found = self.times.loc[at & (self.times["filter"] == name), "filter_ms"]
        return float(found.iloc[0]) if len(found) else float("nan")

    def worst_psnr_change(self, name: str) -> tuple[Estimate, str]:
        """The least change of the frame's PSNR of any scene under any level, and where that is."""
        changes = [
            (PSNR_CHANGE.measure(comparison, name, level), f"{scene}, {level}")
            for scene, comparison in self.by_scene.items()
            for level in self.levels
        ]
        measured = [c for c in changes if c[0].value == c[0].value]
        return min(measured, key=lambda change: change[0].value) if measured else (Estimate(float("nan")), "")


def read(run: Run) -> Filters:
    """Read and check the tables of a run.

    Raises
    ------
    ReportError
        When one is missing or damaged.
    """
    import pandas as pd

    tables = {
        name: read_table(run.folder / f"{name}.parquet", FRAME_COLUMNS)
        for name in ("highlight_free", "neutral", "oracle")
    }
    lit = replace(
        run,
        frames=pd.concat([run.frames, tables["oracle"]], ignore_index=True),
        filters=(*run.filters, ORACLE),
    )
    return Filters(
        run,
        lit,
        compare(_with(run, tables["highlight_free"])),
        compare(_with(run, tables["neutral"])) if len(tables["neutral"]) else None,
        read_table(run.folder / "times.parquet", TIME_COLUMNS),
    )


def _with(run: Run, frames: DataFrame) -> Run:
    return replace(run, frames=frames[frames["status"] == OK].reset_index(drop=True))
