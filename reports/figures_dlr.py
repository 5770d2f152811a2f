"""The dissertation's figures over the DLR log: squared errors, coordinates, share of landmarks mapped."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from reports import dissertation, style, tracks
from reports.dlr import DlrRun, dlr_runs
from reports.run import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

AXES = ("x", "y")
LARGEST = {"x": dissertation.PROPOSED.sq_err_x_max, "y": dissertation.PROPOSED.sq_err_y_max}
FLOOR_M2 = 1e-5
"""Squared errors below this (3 mm) are drawn at it: the axis is logarithmic, and the start is exact."""


def over_iterations(run: Run) -> DataFrame:
    """True and estimated coordinates and squared errors (3-40, 3-41), one row per run and iteration."""
    import pandas as pd

    parts = []
    for one in (r for r in dlr_runs(run) if r.ok):
        true = tracks.truth(run.folder, str(one.row["scene"]))
        estimated = tracks.estimate(run.folder, one.row)
        here, there = tracks.paired(true, estimated, tracks.stem(one.row))
        columns = {"run": one.label, "iteration": np.arange(len(here))}
        for i, axis in enumerate(AXES):
            columns |= {f"{axis}_true_m": here[:, i], f"{axis}_est_m": there[:, i]}
            columns[f"sq_err_{axis}_m2"] = (here[:, i] - there[:, i]) ** 2
        parts.append(pd.DataFrame(columns))
    return pd.concat(parts, ignore_index=True)


def draw_squared_error(run: Run) -> Path:
    """Save the squared error of each axis over iterations (4-3A/B)."""
    data = over_iterations(run)
    data = data[["run", "iteration", *(f"sq_err_{axis}_m2" for axis in AXES)]]
    with style.styled():
        figure = style.new_figure(9.6, 5.4)
        for panel, axis in zip(figure.subplots(2, 1, sharex=True), AXES, strict=True):
            for one in _good(run):
                rows = data[data["run"] == one.label]
                error = rows[f"sq_err_{axis}_m2"].clip(lower=FLOOR_M2)
                panel.plot(rows["iteration"], error, color=one.colour, linewidth=1.0, label=one.label)
            line = {"color": style.INK, "linewidth": 0.9, "linestyle": (0, (4, 3))}
            panel.axhline(LARGEST[axis], label="dissertation's largest (simulated sensor)", **line)
            panel.set(yscale="log", ylabel=f"squared error {axis.upper()}, m²")
            panel.grid(axis="y")
        panel.set_xlabel("iteration")
        _legend(figure)
        return style.save(figure, data, run.folder, "dlr-squared-error")


def draw_coordinates(run: Run) -> Path:
    """Save x and y, true against estimated, over iterations (4-2A/B)."""
    data = over_iterations(run)
    data = data[["run", "iteration", *(f"{a}_{w}_m" for a in AXES for w in ("true", "est"))]]
    with style.styled():
        figure = style.new_figure(9.6, 5.0)
        good = _good(run)
        for panel, axis in zip(figure.subplots(2, 1, sharex=True), AXES, strict=True):
            first = data[data["run"] == good[0].label]
            panel.plot(
                first["iteration"], first[f"{axis}_true_m"], color=style.INK, linewidth=2.2, label="true"
            )
            for one in good:
                rows = data[data["run"] == one.label]
                estimate = rows[f"{axis}_est_m"]
                panel.plot(rows["iteration"], estimate, color=one.colour, linewidth=0.9, label=one.label)
            panel.set_ylabel(f"{axis}, m")
            panel.grid(axis="y")
        panel.set_xlabel("iteration")
        _legend(figure)
        return style.save(figure, data, run.folder, "dlr-coordinates")


def draw_mapped(run: Run) -> Path:
    """Save the share of the log's landmarks that ends up in the map (4-1C), duplicates apart."""
    data = mapped(run)
    colours = {one.label: one.colour for one in _good(run)}
    with style.styled():
        figure = style.new_figure(9.6, 0.42 * len(data) + 1.0)
        panel = figure.subplots()
        at = range(len(data))
        hues = [colours.get(name, style.BASELINE_COLOUR) for name in data["run"]]
        panel.barh(at, data["mapped_percent"], color=hues, height=0.6)
        panel.barh(
            at,
            data["duplicates_percent"],
            left=data["mapped_percent"],
            height=0.6,
            fill=False,
            edgecolor=hues,
        )
        ends = (data["mapped_percent"] + data["duplicates_percent"].fillna(0.0)).tolist()
        for y, (end, text) in enumerate(zip(ends, data["text"].tolist(), strict=True)):
            panel.text(end + 1.0, y, text, va="center", fontsize=8)
        panel.set_yticks(at, data["run"])
        panel.invert_yaxis()
        panel.set_xlabel("share of all landmarks, % (outline: duplicates on top)")
        panel.set_xlim(0, 1.25 * max(ends))
        panel.tick_params(axis="y", length=0)
        return style.save(figure, data, run.folder, "dlr-mapped")


def mapped(run: Run) -> DataFrame:
    """Share mapped and duplicates of each run, percent of all landmarks; the dissertation's share last."""
    import pandas as pd

    rows = []
    for one in _good(run):
        total, found, again = (one.row[f"landmarks_{k}"] for k in ("total", "mapped", "duplicated"))
        text = f"{found} of {total}" + (f", {again} duplicates" if again else "")
        rows.append((one.label, 100 * found / max(total, 1), 100 * again / max(total, 1), text))
    theirs = dissertation.PROPOSED
    rows.append(("dissertation (simulated)", 100 * dissertation.LANDMARK_SHARE, np.nan, theirs.landmarks))
    return pd.DataFrame(rows, columns=["run", "mapped_percent", "duplicates_percent", "text"])


def _good(run: Run) -> list[DlrRun]:
    return [one for one in dlr_runs(run) if one.ok]


def _legend(figure: Figure) -> None:
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncols=3, fontsize=8)
