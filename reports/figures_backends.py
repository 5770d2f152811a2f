"""Figures of compared back-ends: the position error of every repetition beside the bound."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from reports import backends, style
from reports.run import Run

WIDE = 10.0
"""Ratio of the largest to the smallest error beyond which the axis is logarithmic."""


def draw_spread(run: Run, scene: str) -> Path:
    """Save the RMSE of each back-end on a drive, a dot per repetition, and the Cramér–Rao bound."""
    data = backends.frame(run, scene)
    shown = [g for g in backends.groups(run, scene) if len(g.rows)]
    with style.styled():
        figure = style.new_figure(9.6, 0.32 * len(shown) + 1.1)
        panel = figure.subplots()
        for y, group in enumerate(shown):
            values = group.values("rmse_m")
            panel.plot(values, np.full(len(values), y), "o", color=group.colour, alpha=0.55, markersize=4)
            panel.plot(values.mean(), y, "|", color=style.INK, markersize=13, markeredgewidth=1.6)
        bound = backends.bound_m(run, scene)
        if np.isfinite(bound):
            label = f"Cramér–Rao bound {bound:.3f} m"
            panel.axvline(bound, color=style.INK, linewidth=0.9, linestyle=(0, (4, 3)), label=label)
            figure.legend(loc="outside upper right", fontsize=8)
        panel.set_yticks(range(len(shown)), [g.label for g in shown])
        panel.set_ylim(len(shown) - 0.5, -0.5)
        panel.set_xlabel("position RMSE, m (a dot: one repetition; bar: mean)")
        if data["rmse_m"].max() > WIDE * data["rmse_m"].min():
            panel.set_xscale("log")
            panel.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        else:
            panel.set_xlim(0, None)
        panel.grid(axis="x")
        panel.tick_params(axis="y", length=0)
        return style.save(figure, data, run.folder, f"backends-rmse--{scene}")
