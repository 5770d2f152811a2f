"""Quality against time: each filter's PSNR over its time per picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports import figures_quality_time, pairs
from reports.page import Picture
from reports.pairs import Pairs
from reports.run import Run

if TYPE_CHECKING:
    from pandas import DataFrame


def pictures(run: Run, told: Pairs) -> tuple[Picture, ...]:
    """Draw and save the figure; nothing without a filter to compare."""
    path = figures_quality_time.draw(run, _data(told), "PSNR, dB", "quality-time")
    caption = (
        "Mean PSNR over all pictures against the mean time of one, on a logarithmic axis. Dashed: doing "
        "nothing; a filter below the line costs time and quality."
    )
    return (Picture(path, "Quality and time", caption),) if path else ()


def _data(told: Pairs) -> DataFrame:
    import pandas as pd

    rows = [
        (
            name,
            pairs.mean(told.pictures, name, "filter_ms").value,
            pairs.mean(told.pictures, name, "psnr_db").value,
        )
        for name in told.filters
    ]
    return pd.DataFrame(rows, columns=["filter", "milliseconds", "psnr_db"])
