"""Quality against time: what each filter reaches over what it costs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from reports import style
from reports.run import BASELINE, Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


def draw(run: Run, data: DataFrame, axis: str, stem: str, time: str = "time per picture, ms") -> Path | None:
    """Save the figure; None without a filter to compare.

    Parameters
    ----------
    data : DataFrame
        Columns ``filter``, ``milliseconds`` and the quality; rows that lack one are left out.
    axis : str
        Quality and unit.
    """
    data = data.dropna()
    if len(data) < 2:
        return None
    with style.styled():
        return style.save(_figure(data, axis, time), data, run.folder, stem)


def _figure(data: DataFrame, axis: str, time: str) -> Figure:
    figure = style.new_figure(7.0, 4.2)
    axes = figure.subplots()
    for name, milliseconds, quality in data.itertuples(index=False):
        if name == BASELINE:
            axes.axhline(quality, color=style.MUTED, linewidth=0.9, linestyle="--")
            continue
        axes.scatter(milliseconds, quality, s=24, color=style.SERIES[0], zorder=3)
        axes.annotate(name, (milliseconds, quality), (4, 3), textcoords="offset points", fontsize=7.5)
    axes.set_xscale("log")
    axes.margins(x=0.15)
    axes.set_xlabel(time)
    axes.set_ylabel(axis)
    axes.grid(True)
    return figure
