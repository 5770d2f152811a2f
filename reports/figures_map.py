"""The map: true and estimated path, true and mapped landmarks (dissertation's figure 4-1A)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports import style, tracks
from reports.dlr import dlr_runs
from reports.illuminations import weakest_and_strongest
from reports.run import OK, Run, records
from reports.tracks import Occupancy, Track

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from pandas import DataFrame

PANELS_PER_ROW = 3
TRUE, ESTIMATED, MAPPED = "true", "estimated", "mapped"


@dataclass(frozen=True, eq=False)
class Panel:
    """One run on the map.

    Attributes
    ----------
    title, colour, run : str
        ``run`` is the file stem.
    track : Track or None
        None where the run failed.
    landmarks : DataFrame or None
    note : str
        Why there is no track.
    """

    title: str
    colour: str
    run: str
    track: Track | None
    landmarks: DataFrame | None
    note: str = ""


def draw_rendered(run: Run, scene: str) -> Path | None:
    """Save the map of a scene: each filter in the weakest and the strongest light, lowest seed.

    The runs are chosen by light and seed, never by their result.
    """
    colours = style.filter_colours(run.filters)
    rows = run.runs[run.runs["scene"] == scene]
    panels = []
    for light in weakest_and_strongest(run):
        for name in run.filters:
            chosen = rows[(rows["illumination"] == light.name) & (rows["filter"] == name)]
            if len(chosen):
                row = records(chosen.sort_values("seed", kind="stable"))[0]
                panels.append(
                    _panel_of(run, row, f"{style.filter_label(name)}\n{light.label}", colours[name])
                )
    return _save(run, scene, panels, min(PANELS_PER_ROW, len(run.filters)))


def draw_dlr(run: Run, scene: str) -> Path | None:
    """Save the map of the log: one panel for each run over it."""
    panels = [_panel_of(run, r.row, r.label, r.colour) for r in dlr_runs(run) if r.row["scene"] == scene]
    return _save(run, scene, panels, 2)


def _panel_of(run: Run, row: Mapping[str, Any], title: str, colour: str) -> Panel:
    if row["status"] != OK:
        return Panel(title, colour, tracks.stem(row), None, None, str(row["status"]))
    rmse = f"RMSE {row['rmse_m']:.2f} m, seed {row['seed']}"
    return Panel(
        f"{title}\n{rmse}",
        colour,
        tracks.stem(row),
        tracks.estimate(run.folder, row),
        tracks.landmarks(run.folder, row),
    )


def _save(run: Run, scene: str, panels: Sequence[Panel], across: int) -> Path | None:
    if not any(p.track is not None for p in panels):
        return None
    true = tracks.truth(run.folder, scene)
    data = table(true, panels)
    with style.styled():
        figure = _figure(true, tracks.occupancy(run.folder, scene), panels, across)
        return style.save(figure, data, run.folder, f"map--{scene}")


def table(true: Track, panels: Sequence[Panel]) -> DataFrame:
    """Everything drawn, one point per row: run, kind (path or landmark), which (true …), id, x, y."""
    import pandas as pd

    parts = [_points("", "path", TRUE, range(len(true.xy)), true.xy)]
    for panel in panels:
        if panel.track is None or panel.landmarks is None:
            continue
        marks = panel.landmarks
        parts.append(_points(panel.run, "path", ESTIMATED, range(len(panel.track.xy)), panel.track.xy))
        for which, columns in ((TRUE, ["x_true_m", "y_true_m"]), (MAPPED, ["x_est_m", "y_est_m"])):
            xy = marks[columns].to_numpy(np.float64)
            seen = np.isfinite(xy).all(axis=1)
            parts.append(_points(panel.run, "landmark", which, marks["id"][seen], xy[seen]))
    return pd.concat(parts, ignore_index=True)


def _points(run: str, kind: str, which: str, ids: Any, xy: NDArray[np.float64]) -> DataFrame:
    import pandas as pd

    return pd.DataFrame(
        {"run": run, "kind": kind, "which": which, "id": ids, "x_m": xy[:, 0], "y_m": xy[:, 1]}
    )


def _figure(true: Track, grid: Occupancy | None, panels: Sequence[Panel], across: int) -> Figure:
    down = math.ceil(len(panels) / across)
    x0, x1, y0, y1 = window(true, grid, panels)
    height = 0.84 * (9.6 / across) * (y1 - y0) / (x1 - x0)
    figure = style.new_figure(9.6, down * (height + 0.85) + 0.5)
    axes = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True).ravel()
    for panel, content in zip(axes, panels, strict=False):
        _draw_panel(panel, true, grid, content)
        panel.set(xlim=(x0, x1), ylim=(y0, y1))
    for panel in axes[len(panels) :]:
        panel.set_axis_off()
    figure.supxlabel("x, m", fontsize=9, color=style.INK)
    figure.supylabel("y, m", fontsize=9, color=style.INK)
    _legend(figure)
    return figure


def window(true: Track, grid: Occupancy | None, panels: Sequence[Panel]) -> tuple[float, float, float, float]:
    """What the map shows, (x_min, x_max, y_min, y_max) in metres.

    The true place, and the estimates as far as they lie within half its size around it: a run that diverged
    must not shrink the rest to a dot.
    """
    places = [true.xy]
    places += [
        p.landmarks[["x_true_m", "y_true_m"]].to_numpy(np.float64) for p in panels if p.landmarks is not None
    ]
    if grid is not None:
        places.append(np.array(grid.extent).reshape(2, 2).T)
    known = np.concatenate(places)
    low, high = np.nanmin(known, axis=0), np.nanmax(known, axis=0)
    margin = 0.02 * (high - low).max()
    reach = np.maximum(0.5 * (high - low), margin)
    estimates = [p.track.xy for p in panels if p.track is not None]
    reached = np.concatenate([*estimates, known])
    low = np.maximum(np.nanmin(reached, axis=0), low - reach) - margin
    high = np.minimum(np.nanmax(reached, axis=0), high + reach) + margin
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def _draw_panel(panel: Axes, true: Track, grid: Occupancy | None, content: Panel) -> None:
    if grid is not None:
        shade = np.zeros((*grid.blocked.shape, 4), dtype=np.uint8)
        shade[grid.blocked] = (128, 134, 140, 70)
        panel.imshow(shade, extent=grid.extent, origin="lower", interpolation="nearest")
    panel.plot(*true.xy.T, color=style.INK, linewidth=0.9, zorder=3)
    panel.set_title(content.title, fontsize=8)
    panel.set_aspect("equal")
    if content.track is None or content.landmarks is None:
        panel.text(0.5, 0.5, content.note, transform=panel.transAxes, ha="center", va="center", wrap=True)
        return
    marks = content.landmarks.drop_duplicates("id")
    panel.scatter(marks["x_true_m"], marks["y_true_m"], s=12, **RING)
    panel.scatter(
        content.landmarks["x_est_m"],
        content.landmarks["y_est_m"],
        s=5,
        color=content.colour,
        linewidth=0,
        zorder=4,
    )
    panel.plot(*content.track.xy.T, color=content.colour, linewidth=1.1, zorder=3)


RING: dict[str, Any] = {"facecolors": "none", "edgecolors": style.MUTED, "linewidth": 0.6, "zorder": 2}


def _legend(figure: Figure) -> None:
    from matplotlib.lines import Line2D

    hollow: dict[str, Any] = {"marker": "o", "linestyle": "none", "markerfacecolor": "none", "markersize": 4}
    full: dict[str, Any] = {
        "marker": "o",
        "linestyle": "none",
        "markersize": 3,
        "color": style.BASELINE_COLOUR,
    }
    handles = [
        Line2D([], [], color=style.INK, linewidth=0.9, label="true path"),
        Line2D([], [], color=style.BASELINE_COLOUR, linewidth=1.6, label="estimated path"),
        Line2D([], [], markeredgecolor=style.MUTED, label="true landmark", **hollow),
        Line2D([], [], label="mapped landmark (duplicates too)", **full),
    ]
    figure.legend(handles=handles, loc="outside upper right", ncols=4, fontsize=8)
