"""Figures of compared back-ends: the position error of every repetition beside the bound."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from reports import drives, style
from reports.run import Run


def draw_spread(run: Run, scene: str) -> Path:
    """Save the RMSE of each back-end on a drive, a dot per repetition, and the Cramér–Rao bound."""
    data = drives.frame(run, scene)
    shown = [g for g in drives.groups(run, scene) if len(g.rows)]
    with style.styled():
        figure = style.new_figure(9.6, 0.32 * len(shown) + 1.1)
        panel = figure.subplots()
        for y, group in enumerate(shown):
            values = group.values("rmse_m")
            panel.plot(values, np.full(len(values), y), "o", color=group.colour, alpha=0.55, markersize=4)
            panel.plot(values.mean(), y, "|", color=style.INK, markersize=13, markeredgewidth=1.6)
        bound = drives.bound_m(run, scene)
        if np.isfinite(bound):
            label = f"Cramér–Rao bound {bound:.3f} m"
            panel.axvline(bound, color=style.INK, linewidth=0.9, linestyle=(0, (4, 3)), label=label)
            panel.legend(loc="lower right", fontsize=8)
        panel.set_yticks(range(len(shown)), [g.label for g in shown])
        panel.invert_yaxis()
        panel.set(xscale="log", xlabel="position RMSE, m (a dot: one repetition; bar: mean)")
        panel.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        panel.xaxis.set_minor_formatter(lambda value, _: f"{value:g}" if f"{value:e}"[0] in "25" else "")
        panel.grid(axis="x")
        panel.tick_params(axis="y", length=0)
        return style.save(figure, data, run.folder, f"drives-rmse--{scene}")
