"""A study of filters: quality against time, of mask and of repair."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports import figures_quality_time
from reports.filters import IN_MASK_CHANGE, IOU, ORACLE, Filters, Measure
from reports.page import Picture

if TYPE_CHECKING:
    from pandas import DataFrame


def pictures(told: Filters) -> tuple[Picture, ...]:
    """Draw and save the figures; nothing without a filter to compare."""
    if not told.sizes:
        return ()
    width, height = told.sizes[0]
    axis = f"time per picture of {width} × {height}, ms"
    drawn = []
    for measure, what in ((IOU, "Mask"), (IN_MASK_CHANGE, "Repair")):
        stem = f"quality-time-{measure.key.replace('_', '-')}"
        path = figures_quality_time.draw(told.run, _data(told, measure), measure.heading, stem, axis)
        caption = (
            f"{measure.heading}, all scenes and levels pooled, against the median time for one picture of "
            f"{width} × {height} pixels on one core, on a logarithmic axis. Dashed: doing nothing."
        )
        drawn += [Picture(path, f"{what} and time", caption)] if path else []
    return tuple(drawn)


def _data(told: Filters, measure: Measure) -> DataFrame:
    import pandas as pd

    rows = [
        (name, told.milliseconds(name, told.sizes[0]), measure.measure(told.lit, name).value)
        for name in told.names
        if name != ORACLE
    ]
    return pd.DataFrame(rows, columns=["filter", "milliseconds", measure.key])
