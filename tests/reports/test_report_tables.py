"""The headline table: baselines beside the filters, failures counted, NaN shown as missing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from reports import headline, tables
from reports.cases import by_illumination
from reports.comparison import compare
from reports.run import load
from reports.statistics import Estimate
from reports.wording import MISSING, NBSP, interval, listing, number

Make = Callable[..., Path]


def rows_of(folder: Path) -> dict[str, tables.Row]:
    run = load(folder)
    return {row.label: row for row in tables.headline(run, compare(run))}


def column(key: str) -> tables.Column:
    return next(c for c in tables.COLUMNS if c.key == key)


def test_both_baselines_stand_first_and_share_the_filter_none(rendered_run: Path) -> None:
    rows = rows_of(rendered_run)
    assert list(rows) == ["all-negative mask", "do nothing", "seed", "seed_per_pixel"]
    assert rows["all-negative mask"].filter == rows["do nothing"].filter == "none"
    assert rows["all-negative mask"].cells["iou"].value == 0.0
    assert "rmse" not in rows["all-negative mask"].cells and "iou" not in rows["do nothing"].cells
    assert set(rows["seed"].cells) == {c.key for c in tables.COLUMNS}


def test_failed_runs_are_counted_and_named(rendered: Make) -> None:
    folder = rendered(failed=(("seed", 0), ("seed", 1)), strips=False, tracks=False)
    rows = rows_of(folder)
    assert (rows["seed"].failed, rows["seed"].runs) == (12, 48)
    assert rows["do nothing"].failed == 0
    (failure,) = tables.failures(load(folder))
    assert failure == tables.Failure(
        "seed", "SLAM run", "the covariance lost positive definiteness at step 31", 12
    )


def test_nan_becomes_a_dash(rendered: Make) -> None:
    folder = rendered(failed=tuple(("seed", k) for k in range(8)), strips=False, tracks=False)
    assert tables.cell_text(column("rmse"), rows_of(folder)["seed"]) == (MISSING, "")


def test_marks_follow_the_paired_difference(rendered_run: Path) -> None:
    rows = rows_of(rendered_run)
    assert tables.mark(column("rmse"), rows["seed"]) == "worse"
    assert tables.mark(column("recall"), rows["seed"]) == "worse"
    assert tables.mark(column("psnr_in_mask_change"), rows["seed"]) == "better"
    assert tables.mark(column("rmse"), rows["seed_per_pixel"]) == ""
    assert tables.mark(column("rmse"), rows["do nothing"]) == ""


def test_saved_table_holds_each_condition_and_number(rendered_run: Path) -> None:
    run = load(rendered_run)
    comparison = compare(run)
    pooled, folded = headline.tables(run, by_illumination(run, comparison))
    saved = pd.read_csv(rendered_run / headline.CSV)
    assert saved["condition"].nunique() == 1 + 6
    assert len(folded.rows) == 6 * 4
    row = saved.query("condition == 'all illuminations' and row == 'seed' and metric == 'rmse'").iloc[0]
    expected = comparison.run_metric("seed", "rmse_m")
    assert (row["value"], row["low_95"], row["high_95"]) == pytest.approx(
        (expected.value, expected.low, expected.high)
    )
    shown = next(r for r in pooled.rows if r.label == "RMSE, m").cells[2]
    assert shown.value == f"{expected.value:.3f}"


def test_each_number_with_a_unit_shows_it(rendered_run: Path) -> None:
    run = load(rendered_run)
    labels = [row.label for row in headline.tables(run, by_illumination(run, compare(run)))[0].rows]
    assert {"PSNR, dB", "RMSE, m", "landmark recall, %", "filter time, ms"} <= set(labels)


@pytest.mark.parametrize(
    ("value", "signed", "expected"),
    [
        (1.234, False, "1.23"),
        (-0.5, True, "−0.50"),
        (0.5, True, "+0.50"),
        (-0.001, True, "0.00"),
        (np.nan, False, MISSING),
        (np.inf, False, "∞"),
        (-np.inf, False, "−∞"),
    ],
)
def test_number(value: float, signed: bool, expected: str) -> None:
    assert number(value, 2, signed=signed) == expected


def test_interval_is_empty_without_width() -> None:
    assert interval(Estimate(1.0, 0.5, 1.5), 1) == f"0.5{NBSP}…{NBSP}1.5"
    assert interval(Estimate(1.0, 1.0, 1.0), 1) == interval(Estimate(1.0), 1) == ""


def test_listing() -> None:
    assert listing(["a"]) == "a" and listing(["a", "b", "c"]) == "a, b and c"
