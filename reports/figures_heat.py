"""Heat maps: a metric over sun or time of day × bulb, one panel for each filter, on one colour scale."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from reports import style
from reports.comparison import Comparison
from reports.illuminations import COLUMNS, STEADY, illuminations, quantity, stops
from reports.run import BASELINE, Run
from reports.wording import MISSING, number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap, Normalize
    from matplotlib.figure import Figure
    from pandas import DataFrame

FloatArray = NDArray[np.float64]

PANELS_PER_ROW = 4


@dataclass(frozen=True)
class HeatMetric:
    """What a heat map shows.

    Attributes
    ----------
    key, column, title, unit : str
        ``column`` is its name in the CSV.
    digits : int
        Decimals in the cells.
    higher_is_better : bool
    top : float or None
        End of the colour scale, which starts at 0, so that colours mean the same in each report; None for
        the largest value of the run.
    measure : callable
        (comparison, filter, illumination) → value in ``unit``.
    of_light : bool
        Whether it tells of the pictures and not of a filter: one panel serves them all.
    """

    key: str
    column: str
    title: str
    unit: str
    digits: int
    higher_is_better: bool
    top: float | None
    measure: Callable[[Comparison, str, str], float]
    of_light: bool = False

    def panels(self, run: Run) -> tuple[str, ...]:
        """The filters that have a panel."""
        return (BASELINE,) if self.of_light else run.filters


METRICS = (
    HeatMetric(
        "true-share",
        "true_share_percent",
        "Pixels that specular light affects",
        "%",
        1,
        True,
        None,
        lambda c, f, w: 100 * c.mask(f, "true_share", w).value,
        of_light=True,
    ),
    HeatMetric(
        "recall",
        "recall_percent",
        "Landmark recall",
        "%",
        0,
        True,
        100.0,
        lambda c, f, w: 100 * c.recall(f, w).value,
    ),
    HeatMetric("iou", "iou", "Mask IoU", "", 3, True, 1.0, lambda c, f, w: c.mask(f, "iou", w).value),
    HeatMetric(
        "rmse",
        "rmse_m",
        "Position RMSE",
        "m",
        3,
        False,
        None,
        lambda c, f, w: c.run_metric(f, "rmse_m", w).value,
    ),
    HeatMetric(
        "nav-success",
        "nav_success_percent",
        "Navigation success",
        "%",
        0,
        True,
        100.0,
        lambda c, f, w: 100 * c.run_metric(f, "nav_success", w).value,
    ),
)


def table(run: Run, comparison: Comparison, metric: HeatMetric) -> DataFrame:
    """One row per filter and illumination, by time of day and dark to bright."""
    import pandas as pd

    lights = illuminations(run)
    rows = [
        (name, *astuple(light), metric.measure(comparison, name, light.name))
        for name in metric.panels(run)
        for light in lights
    ]
    return pd.DataFrame(rows, columns=["filter", *COLUMNS, metric.column])


def draw(run: Run, comparison: Comparison, metric: HeatMetric) -> Path | None:
    """Save one heat map with its CSV; None where the run does not measure it."""
    data = table(run, comparison, metric)
    if not np.isfinite(data[metric.column]).any():
        return None
    with style.styled():
        return style.save(_figure(run, data, metric), data, run.folder, f"heat--{metric.key}")


def _figure(run: Run, data: DataFrame, metric: HeatMetric) -> Figure:
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    lights = illuminations(run)
    days = list(dict.fromkeys(light.daylight for light in lights))
    columns = list(dict.fromkeys(light.column for light in lights))
    finite = data[metric.column][np.isfinite(data[metric.column])]
    norm = Normalize(0.0, metric.top or float(finite.max()) or 1.0)
    colours = colormaps["cividis" if metric.higher_is_better else "cividis_r"]
    names = metric.panels(run)
    across = min(PANELS_PER_ROW, len(names))
    down = math.ceil(len(names) / across)
    figure = style.new_figure(9.6 if len(names) > 1 else 4.2, down * (0.75 + 0.34 * len(days)) + 0.35)
    axes = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True).ravel()
    slope = 30.0 if any(state != STEADY or ev for _, state, ev in columns) else 0.0
    for panel, name in zip(axes, names, strict=False):
        measured = data[data["filter"] == name].set_index("illumination")[metric.column]
        values = np.full((len(days), len(columns)), np.nan)
        for light in lights:
            values[days.index(light.daylight), columns.index(light.column)] = measured[light.name]
        _panel(panel, values, metric, norm, colours)
        panel.set_title("" if metric.of_light else style.filter_label(name))
        panel.set_xticks(np.arange(len(columns)) + 0.5, [_column(*c) for c in columns], rotation=slope)
        panel.set_yticks(np.arange(len(days)) + 0.5, [_day(*d) for d in days])
    for panel in axes[len(names) :]:
        panel.set_axis_off()
    figure.supxlabel("each bulb", fontsize=9, color=style.INK)
    figure.supylabel("time of day, sun" if days[0][0] else "sun", fontsize=9, color=style.INK)
    bar = figure.colorbar(ScalarMappable(norm, colours), ax=list(axes), shrink=0.9, pad=0.02, aspect=14)
    bar.outline.set_visible(False)
    bar.ax.set_title(metric.unit, fontsize=9, fontweight="normal", loc="left")
    return figure


def _day(time: str, sun_lux: float) -> str:
    return f"{time}, {quantity(sun_lux, 'lx')}" if time else quantity(sun_lux, "lx")


def _column(bulb_lm: float, state: str, ev: float) -> str:
    parts = [quantity(bulb_lm, "lm"), state if state != STEADY else "", stops(ev) if ev else ""]
    return ", ".join(filter(None, parts))


def _panel(panel: Axes, values: FloatArray, metric: HeatMetric, norm: Normalize, colours: Colormap) -> None:
    """Draw one grid of cells with the value written into each."""
    rows, columns = values.shape
    shown = np.ma.masked_invalid(values)
    panel.pcolormesh(shown, norm=norm, cmap=colours, edgecolors=style.PAPER, linewidth=1.0)
    panel.set(xlim=(0, columns), ylim=(0, rows))
    for (row, column), value in np.ndenumerate(values):
        text = MISSING if math.isnan(value) else number(value, metric.digits)
        panel.text(column + 0.5, row + 0.5, text, ha="center", va="center", color=_on(value, norm, colours))
    panel.tick_params(length=0)
    for spine in panel.spines.values():
        spine.set_visible(False)


def _on(value: float, norm: Normalize, colours: Colormap) -> str:
    """Black or white, whichever reads better on the cell (relative luminance, WCAG 2)."""
    if math.isnan(value):
        return style.MUTED
    rgb = np.array(colours(norm(value))[:3])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    luminance = float(linear @ [0.2126, 0.7152, 0.0722])
    return "#000000" if (luminance + 0.05) / 0.05 > 1.05 / (luminance + 0.05) else "#fefefe"
