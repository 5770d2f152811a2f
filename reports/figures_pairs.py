"""Quality against time: each filter's PSNR over its time per picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports import pairs, style
from reports.page import Picture
from reports.pairs import Pairs
from reports.run import BASELINE, Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


def pictures(run: Run, told: Pairs) -> tuple[Picture, ...]:
    """Draw and save the figure; nothing without a filter to compare."""
    data = _data(told)
    if len(data) < 2:
        return ()
    with style.styled():
        path = style.save(_figure(data), data, run.folder, "quality-time")
    caption = (
        "Mean PSNR over all pictures against the mean time of one, on a logarithmic axis. Dashed: doing "
        "nothing; a filter below the line costs time and quality."
    )
    return (Picture(path, "Quality and time", caption),)


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
    return pd.DataFrame(rows, columns=["filter", "milliseconds", "psnr_db"]).dropna()


def _figure(data: DataFrame) -> Figure:
    figure = style.new_figure(7.0, 4.2)
    axes = figure.subplots()
    for name, milliseconds, decibels in data.itertuples(index=False):
        if name == BASELINE:
            axes.axhline(decibels, color=style.MUTED, linewidth=0.9, linestyle="--")
            continue
        axes.scatter(milliseconds, decibels, s=24, color=style.SERIES[0], zorder=3)
        axes.annotate(name, (milliseconds, decibels), (4, 3), textcoords="offset points", fontsize=7.5)
    axes.set_xscale("log")
    axes.margins(x=0.15)
    axes.set_xlabel("time per picture, ms")
    axes.set_ylabel("PSNR, dB")
    axes.grid(True)
    return figure
