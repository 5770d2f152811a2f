"""Numbers of a study that composites light: each filter under each light, beside doing nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reports import statistics as s
from reports.frame_sums import FrameSums, frame_sums
from reports.run import BASELINE, Run
from reports.statistics import Estimate
from reports.terminal import ARROWS, paragraphs, text_table
from reports.wording import interval, number

if TYPE_CHECKING:
    from rich.console import RenderableType

RECORDED = "recorded"


@dataclass(frozen=True)
class Column:
    """A number: a statistic of sums over blocks of pictures, and whether more of it is better.

    Attributes
    ----------
    heading : str
    digits : int
    sums : tuple of str
        Columns of `FrameSums`.
    statistic : callable
    change : callable or None
        Of the sums of a filter and of none, where a difference says better or worse.
    """

    heading: str
    digits: int
    sums: tuple[str, ...]
    statistic: Callable[..., s.FloatArray]
    change: Callable[..., s.FloatArray] | None = None


def _percent(part: s.FloatArray, whole: s.FloatArray) -> s.FloatArray:
    return 100 * part / whole


def _percent_change(
    part: s.FloatArray, whole: s.FloatArray, base: s.FloatArray, base_whole: s.FloatArray
) -> s.FloatArray:
    return 100 * (part / whole - base / base_whole)


def _decibels_gained(
    error: s.FloatArray, _: s.FloatArray, base: s.FloatArray, __: s.FloatArray
) -> s.FloatArray:
    return s.decibel_change(error, base)


COLUMNS = (
    Column("masked, %", 1, ("masked_share", "masked_share_frames"), _percent),
    Column("mask IoU", 3, ("iou", "iou_frames"), s.ratio),
    Column("mask AP", 3, ("ap", "ap_frames"), s.ratio),
    Column("PSNR, dB", 2, ("error", "error_frames"), s.decibel, _decibels_gained),
    Column("in-mask PSNR, dB", 2, ("error_in_mask", "error_in_mask_frames"), s.decibel, _decibels_gained),
    Column("recall, %", 1, ("detections_true", "landmarks_visible"), _percent, _percent_change),
    Column("precision, %", 1, ("detections_true", "landmarks_detected"), _percent, _percent_change),
)


def conditions(run: Run) -> tuple[str, ...]:
    """The lights, pictures as recorded first, then as the study lists them."""
    return tuple(dict.fromkeys([RECORDED, *run.frames["illumination"]]))


def row_of(sums: FrameSums, name: str, light: str) -> list[tuple[Estimate, str]]:
    """Each column's number, and whether it is better or worse than without a filter."""
    return [(_value(sums, c, name, light), _mark(sums, c, name, light)) for c in COLUMNS]


def _value(sums: FrameSums, column: Column, name: str, light: str) -> Estimate:
    return s.estimate(column.statistic, sums.of(name, light, *column.sums), sums.unit)


def change(sums: FrameSums, column: Column, name: str, light: str) -> Estimate:
    """The paired difference to no filter; NaN where the column has none."""
    if column.change is None:
        return Estimate(float("nan"))
    ours, base = (sums.of(which, light, *column.sums) for which in (name, BASELINE))
    changed = (ours != base).any(axis=0)
    return s.estimate(column.change, np.concatenate([ours, base]), sums.unit, changed)


def _mark(sums: FrameSums, column: Column, name: str, light: str) -> str:
    effect = change(sums, column, name, light)
    if name == BASELINE or not effect.excludes_zero:
        return ""
    return "better" if effect.value > 0.0 else "worse"


def verdict(run: Run, sums: FrameSums) -> str:
    """What the strongest light costs the detector, and which filter wins most of it back."""
    recall = next(c for c in COLUMNS if c.heading.startswith("recall"))
    lights = conditions(run)
    untouched = {light: _value(sums, recall, BASELINE, light).value for light in lights}
    worst = min(lights, key=lambda light: untouched[light])
    told = (
        f"Without a filter the detector finds {number(untouched[RECORDED], 1)} % of the annotated discs in "
        f"the pictures as recorded, and {number(untouched[worst], 1)} % under {worst}"
    )
    if not run.light_filters:
        return f"{told}."
    effects = {name: change(sums, recall, name, worst) for name in run.light_filters}
    best = max(effects, key=lambda name: effects[name].value)
    found = effects[best]
    if not found.value > 0.0:
        return f"{told}; no filter lets it find more there."
    shown = interval(found, 1, signed=True)
    bounds = f", 95 % interval {shown}" if shown else ""
    return (
        f"{told}; there the best filter is “{best}” with {number(found.value, 1, signed=True)} percentage "
        f"points{bounds}."
    )


def summary(run: Run) -> RenderableType:
    """The table in a terminal."""
    from rich.console import Group

    sums = frame_sums(run)
    tables = []
    for light in conditions(run):
        shown = text_table(light, [c.heading.replace(", ", "\n") for c in COLUMNS])
        for name in run.filters:
            numbers = row_of(sums, name, light)
            shown.add_row(
                name,
                *(number(v.value, c.digits) + ARROWS[m] for c, (v, m) in zip(COLUMNS, numbers, strict=True)),
            )
        tables.append(shown)
    notes = ["▲ better, ▼ worse than no filter on the same pictures, by a paired 95 % interval."]
    return Group(*paragraphs([verdict(run, sums)], "bold"), *tables, *paragraphs(notes, "dim"))
