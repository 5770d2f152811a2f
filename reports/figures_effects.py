"""What each filter changed against doing nothing, with 95 % intervals, pooled and case by case."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from reports import style
from reports.cases import Case
from reports.comparison import Comparison, Condition
from reports.run import Run
from reports.statistics import Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from pandas import DataFrame


@dataclass(frozen=True)
class Effect:
    """One panel: a paired change.

    Attributes
    ----------
    key, title : str
    scale : float
        From stored unit to shown unit.
    higher_is_better : bool
    measure : callable
        (comparison, filter, condition) → Estimate.
    """

    key: str
    title: str
    scale: float
    higher_is_better: bool
    measure: Callable[[Comparison, str, Condition], Estimate]


EFFECTS = (
    Effect(
        "recall",
        "Change of landmark recall, percentage points",
        100.0,
        True,
        lambda c, f, w: c.recall_change(f, w),
    ),
    Effect("rmse_m", "Change of position RMSE, m", 1.0, False, lambda c, f, w: c.run_change(f, "rmse_m", w)),
)


def table(run: Run, cases: Sequence[Case]) -> DataFrame:
    """One row per effect, case and filter."""
    import pandas as pd

    rows = []
    for effect in EFFECTS:
        for case in cases:
            for name in run.light_filters:
                change = effect.measure(case.comparison, name, case.condition)
                value, low, high = (effect.scale * v for v in (change.value, change.low, change.high))
                rows.append(
                    (effect.key, case.label, name, value, low, high, change.units, change.unit, change.note)
                )
    columns = ["change_of", "condition", "filter", "value", "low_95", "high_95", "units", "unit", "note"]
    return pd.DataFrame(rows, columns=columns)


def draw(run: Run, cases: Sequence[Case]) -> Path | None:
    """Save the figure with its CSV, the first case set apart; None without a filter to compare."""
    if not run.light_filters:
        return None
    data = table(run, cases)
    with style.styled():
        return style.save(_figure(run, data), data, run.folder, "effects")


def _figure(run: Run, data: DataFrame) -> Figure:
    conditions = list(dict.fromkeys(data["condition"]))
    colours = style.filter_colours(run.filters)
    height = 0.16 * len(conditions) * max(len(run.light_filters), 2) + 1.1
    figure = style.new_figure(9.6, min(height, 14.0))
    axes = figure.subplots(1, len(EFFECTS), sharey=True)
    for panel, effect in zip(axes, EFFECTS, strict=True):
        _panel(panel, data[data["change_of"] == effect.key], conditions, run.light_filters, colours)
        panel.set_title(effect.title)
        hint = "further right is better →" if effect.higher_is_better else "← further left is better"
        panel.set_xlabel(hint, color=style.MUTED)
    axes[0].set_yticks(range(len(conditions)), conditions)
    axes[0].set_ylim(len(conditions) - 0.5, -0.5)
    axes[0].get_yticklabels()[0].set_fontweight("bold")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=len(labels))
    return figure


def _panel(
    panel: Axes, data: DataFrame, conditions: list[str], filters: tuple[str, ...], colours: dict[str, str]
) -> None:
    """Draw a dot and a bar per filter and condition; hollow where there is no interval."""
    panel.axvline(0.0, color=style.MUTED, linewidth=0.9)
    panel.axhline(0.5, color=style.RULE, linewidth=0.8)
    step = 0.7 / max(len(filters), 2)
    for i, name in enumerate(filters):
        rows = data[data["filter"] == name].set_index("condition").reindex(conditions)
        y = [k + (i - (len(filters) - 1) / 2) * step for k in range(len(conditions))]
        for at, low, high in zip(y, rows["low_95"], rows["high_95"], strict=True):
            if not math.isnan(low):
                panel.plot([low, high], [at, at], color=colours[name], linewidth=1.8, solid_capstyle="butt")
        known = rows["low_95"].notna().to_numpy()
        panel.scatter(rows["value"], y, s=20, color=colours[name], label=name, zorder=3)
        hollow = [at for at, k in zip(y, known, strict=True) if not k]
        panel.scatter(rows["value"][~known], hollow, s=7, color=style.PAPER, zorder=4)
    panel.locator_params(axis="x", nbins=6)
    panel.grid(axis="x")
    panel.set_axisbelow(True)
    panel.tick_params(axis="y", length=0)
    panel.spines["left"].set_visible(False)
