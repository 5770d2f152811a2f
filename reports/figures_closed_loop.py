"""Figures of drives: success over light and filter, chosen drives on the map, exploration over time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from reports import style, tracks
from reports.closed_loop import EXPLORE, drives, share
from reports.run import Run, records

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PLACE_RULE = (
    "For each light and filter the first episode of the task, whatever became of it; solid: where the robot "
    "truly was, dashed: where it believed to be."
)


def stem(row: dict[str, Any]) -> str:
    """File stem of what a run stored of a drive."""
    parts = [str(row[key]) for key in ("scene", "illumination", "filter", "task")]
    return "--".join([*parts, f"e{row['episode']}"])


def draw_success(run: Run, task: str) -> Path:
    """Save the share of successes of each light and filter, with Wilson's intervals."""
    import pandas as pd

    own, rows = drives(run), []
    for light in own.lights:
        for name in own.filters:
            value = share(own.of(task, name, light.name), "success")
            rows.append((light.name, light.label, name, value.value, value.low, value.high, value.units))
    columns = ["illumination", "light", "filter", "success", "low", "high", "drives"]
    data, colours = pd.DataFrame(rows, columns=columns), style.filter_colours(own.filters)
    with style.styled():
        figure = style.new_figure(9.6, 0.34 * len(rows) + 0.9)
        panel = figure.subplots()
        for y, row in enumerate(records(data)):
            hue = colours[row["filter"]]
            panel.plot([100 * row["low"], 100 * row["high"]], [y, y], color=hue, linewidth=1.6)
            panel.plot(100 * row["success"], y, "o", color=hue, markersize=6)
        labels = [f"{r['light']} · {style.filter_label(r['filter'])}" for r in records(data)]
        panel.set_yticks(range(len(rows)), labels, fontsize=8)
        panel.invert_yaxis()
        panel.set(xlim=(-2, 102), xlabel="drives that succeeded, %")
        panel.grid(axis="x")
        return style.save(figure, data, run.folder, f"drive-success-{task}")


def draw_map(run: Run, task: str) -> Path | None:
    """Save true and believed way of the task's first episode under each light with each filter."""
    import pandas as pd

    own, colours = drives(run), style.filter_colours(drives(run).filters)
    parts, first = [], int(own.table[own.table["task"] == task]["episode"].min())
    chosen = own.table[(own.table["task"] == task) & (own.table["episode"] == first)]
    rows = {(row["illumination"], row["filter"]): row for row in records(chosen)}
    drawn = {
        key: row for key, row in rows.items() if (run.folder / "trajectories" / f"{stem(row)}.tum").exists()
    }
    if not drawn:
        return None
    grid = tracks.occupancy(run.folder, str(next(iter(drawn.values()))["scene"]))
    with style.styled():
        down, across = len(own.lights), len(own.filters)
        figure = style.new_figure(9.6, 2.9 * down * min(1.0, 3 / across) + 0.4)
        panels = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
        for i, light in enumerate(own.lights):
            for j, name in enumerate(own.filters):
                panel, row = panels[i, j], drawn.get((light.name, name))
                panel.set_aspect("equal")
                panel.set_title(f"{style.filter_label(name)}, {light.label}", fontsize=7)
                _draw_walls(panel, grid)
                if row is None:
                    continue
                for which, prefix, dashes in (("true", "truth--", "-"), ("believed", "", (0, (3, 2)))):
                    xy = tracks.read_tum(run.folder / "trajectories" / f"{prefix}{stem(row)}.tum").xy
                    hue = style.INK if which == "true" else colours[name]
                    panel.plot(*xy.T, color=hue, linewidth=1.1, linestyle=dashes)
                    panel.plot(*xy[:1].T, "o", color=hue, markersize=3)
                    parts.append(
                        pd.DataFrame({"drive": stem(row), "which": which, "x_m": xy[:, 0], "y_m": xy[:, 1]})
                    )
                told = f"{row['outcome']}, {row['path_m']:.0f} m, largest error {row['error_max_m']:.2f} m"
                panel.set_xlabel(told, fontsize=7)
        return style.save(figure, pd.concat(parts, ignore_index=True), run.folder, f"drive-map-{task}")


def draw_exploration(run: Run) -> Path | None:
    """Save the share of free space seen over robot time, one line a drive."""
    import pandas as pd

    own, parts = drives(run), []
    colours = style.filter_colours(own.filters)
    for row in records(own.table[own.table["task"] == EXPLORE]):
        path = run.folder / "figures" / f"explored--{stem(row)}.csv"
        if path.exists():
            curve = tracks.read_csv(path, ("seconds", "explored"))
            parts.append(
                curve.assign(illumination=row["illumination"], filter=row["filter"], episode=row["episode"])
            )
    if not parts:
        return None
    data = pd.concat(parts, ignore_index=True)
    with style.styled():
        figure = style.new_figure(9.6, 2.6)
        panels = figure.subplots(1, len(own.lights), squeeze=False, sharey=True)[0]
        for panel, light in zip(panels, own.lights, strict=True):
            for (name, _), curve in data[data["illumination"] == light.name].groupby(["filter", "episode"]):
                panel.plot(curve["seconds"], 100 * curve["explored"], color=colours[str(name)], linewidth=1.1)
            panel.set_title(light.label, fontsize=8)
            panel.set(xlabel="robot time, s", ylim=(0, 102))
            panel.grid(axis="y")
        panels[0].set_ylabel("free space explored, %")
        for name in own.filters:
            panels[0].plot([], [], color=colours[name], label=style.filter_label(name))
        panels[0].legend(fontsize=7, loc="lower right")
        return style.save(figure, data, run.folder, "drive-explored")


def _draw_walls(panel: Axes, grid: tracks.Occupancy | None) -> None:
    if grid is None:
        return
    shade = np.zeros((*grid.blocked.shape, 4), dtype=np.uint8)
    shade[grid.blocked] = (128, 134, 140, 70)
    panel.imshow(shade, extent=grid.extent, origin="lower", interpolation="nearest")
