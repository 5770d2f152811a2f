"""What is drawn is what lies beside it as CSV, and what the run stored."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from reports import figures_dlr, figures_effects, figures_heat, figures_map, figures_strips, style, tracks
from reports.cases import by_illumination
from reports.comparison import compare
from reports.dlr import dlr_runs
from reports.illuminations import quantity
from reports.run import load
from reports.strips import strips

METRICS = {m.key: m for m in figures_heat.METRICS}


@pytest.mark.parametrize("key", METRICS)
def test_heat_map_shows_its_csv(rendered_run: Path, key: str) -> None:
    run = load(rendered_run)
    metric = METRICS[key]
    path = figures_heat.draw(run, compare(run), metric)
    assert path is not None
    saved = pd.read_csv(path.with_suffix(".csv"))
    figure = figures_heat._figure(run, saved, metric)
    names = metric.panels(run)
    assert names == (("none",) if metric.of_light else run.filters)
    scales = set()
    for name, panel in zip(names, figure.axes, strict=False):
        assert panel.get_title() == ("" if metric.of_light else style.filter_label(name))
        drawn = panel.collections[0].get_array().reshape(3, 2)
        rows = saved[saved["filter"] == name].sort_values(["sun_lux", "bulb_lm"])
        assert np.asarray(drawn).ravel() == pytest.approx(rows[metric.column].to_numpy())
        assert [t.get_text() for t in panel.texts] == [f"{v:.{metric.digits}f}" for v in rows[metric.column]]
        scales.add(panel.collections[0].get_clim())
    assert len(scales) == 1


def test_heat_map_values_come_from_the_runs(rendered_run: Path) -> None:
    run = load(rendered_run)
    data = figures_heat.table(run, compare(run), METRICS["rmse"])
    expected = run.runs.groupby(["filter", "illumination"])["rmse_m"].mean()
    for row in data.itertuples():
        assert row.rmse_m == pytest.approx(expected[(row.filter, row.illumination)])


def test_missing_cells_are_drawn_as_missing(rendered_run: Path) -> None:
    run = load(rendered_run)
    data = figures_heat.table(run, compare(run), METRICS["rmse"])
    data.loc[0, "rmse_m"] = np.nan
    figure = figures_heat._figure(run, data, METRICS["rmse"])
    assert figure.axes[0].texts[0].get_text() == "–"


def test_effects_show_their_csv(rendered_run: Path) -> None:
    run = load(rendered_run)
    path = figures_effects.draw(run, by_illumination(run, compare(run)))
    assert path is not None
    saved = pd.read_csv(path.with_suffix(".csv"))
    figure = figures_effects._figure(run, saved)
    for panel, effect in zip(figure.axes, figures_effects.EFFECTS, strict=True):
        for i, name in enumerate(run.light_filters):
            rows = saved[(saved["change_of"] == effect.key) & (saved["filter"] == name)]
            assert panel.collections[2 * i].get_offsets().data[:, 0] == pytest.approx(
                rows["value"].to_numpy()
            )
    bars = [line.get_xdata() for line in figure.axes[0].lines[2:]]
    rows = saved[saved["change_of"] == "recall"].sort_values("filter", kind="stable")
    assert np.array(bars) == pytest.approx(rows[["low_95", "high_95"]].to_numpy())


def test_map_csv_holds_paths_and_landmarks_as_stored(rendered_run: Path) -> None:
    run = load(rendered_run)
    path = figures_map.draw_rendered(run, "corridor")
    assert path is not None
    saved = pd.read_csv(path.with_suffix(".csv"), keep_default_na=False)
    true = saved[(saved["kind"] == "path") & (saved["which"] == "true")]
    assert true[["x_m", "y_m"]].to_numpy() == pytest.approx(tracks.truth(rendered_run, "corridor").xy)
    stem = "corridor--sun97000-bulb3200--seed--ekf--gated--cartesian--s0"
    marks = pd.read_csv(rendered_run / "figures" / f"landmarks--{stem}.csv").dropna()
    drawn = saved[(saved["run"] == stem) & (saved["which"] == "mapped")]
    assert drawn[["x_m", "y_m"]].to_numpy() == pytest.approx(marks[["x_est_m", "y_est_m"]].to_numpy())
    assert drawn["id"].duplicated().sum() == 4


def test_map_panels_are_chosen_by_light_and_seed(rendered_run: Path) -> None:
    run = load(rendered_run)
    path = figures_map.draw_rendered(run, "corridor")
    assert path is not None
    shown = set(pd.read_csv(path.with_suffix(".csv"))["run"].dropna())
    lights = ("sun0-bulb200", "sun97000-bulb3200")
    expected = {f"corridor--{w}--{f}--ekf--gated--cartesian--s0" for w in lights for f in run.filters}
    assert shown == expected


def test_a_diverged_path_does_not_shrink_the_map() -> None:
    true = tracks.Track(np.arange(2.0), np.array([[0.0, 0.0], [20.0, 10.0]]))
    lost = tracks.Track(np.arange(2.0), np.array([[0.0, 0.0], [1e9, -3.0]]))
    panel = figures_map.Panel("", "#000000", "", lost, None)
    assert figures_map.window(true, None, [panel]) == pytest.approx((-0.4, 30.4, -3.4, 10.4))


def test_squared_error_is_that_of_the_trajectories(dlr_run: Path) -> None:
    run = load(dlr_run)
    saved = pd.read_csv(figures_dlr.draw_squared_error(run).with_suffix(".csv"))
    for one in dlr_runs(run):
        error = (tracks.truth(dlr_run, "dlr").xy - tracks.estimate(dlr_run, one.row).xy) ** 2
        rows = saved[saved["run"] == one.label]
        assert rows[["sq_err_x_m2", "sq_err_y_m2"]].to_numpy() == pytest.approx(error)


def test_share_of_landmarks(dlr_run: Path) -> None:
    saved = pd.read_csv(figures_dlr.draw_mapped(load(dlr_run)).with_suffix(".csv"))
    assert saved["mapped_percent"].tolist() == pytest.approx([100.0, 100.0, 560 / 5.76, 560 / 5.76, 60.0])
    assert saved["text"].iloc[-1] == "60 % (332)"


def test_coordinates_match_stamps_not_rows(tmp_path: Path) -> None:
    true = tracks.Track(np.arange(5.0), np.arange(10.0).reshape(5, 2))
    some = tracks.Track(np.array([3.0, 1.0]), np.zeros((2, 2)))
    here, there = tracks.paired(true, some, "run")
    assert here.tolist() == [[6.0, 7.0], [2.0, 3.0]] and len(there) == 2


def test_contact_sheet(rendered_run: Path) -> None:
    run = load(rendered_run)
    chosen, stored = strips(run)
    assert len(chosen) == stored == 9
    assert [s.filter for s in chosen[-3:]] == ["none"] * 3
    assert [s.rank for s in chosen[:3]] == ["best", "median", "worst"]
    path = figures_strips.draw(run, chosen)
    assert path is not None and path.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("value", "unit", "expected"),
    [(0.0, "lx", "0 lx"), (800.0, "lm", "800 lm"), (97_000.0, "lx", "97 klx"), (1500.0, "lm", "1.5 klm")],
)
def test_light_levels(value: float, unit: str, expected: str) -> None:
    assert quantity(value, unit) == expected


def test_filters_keep_their_colour_and_the_baseline_is_grey() -> None:
    colours = style.filter_colours(["none", "a", "b"])
    assert colours == {"none": style.BASELINE_COLOUR, "a": style.SERIES[0], "b": style.SERIES[1]}
