"""Times of day and states of lamps in reports: in their order, each in a row or column of its own."""

from __future__ import annotations

import shutil
from pathlib import Path

import pandas as pd
import pytest

from reports import figures_heat, html
from reports.comparison import compare
from reports.illuminations import Illumination, illuminations, weakest_and_strongest
from reports.run import Run, load

HOURS = {0.0: "06:00", 97_000.0: "12:00", 1000.0: "18:00"}
RECALL = next(m for m in figures_heat.METRICS if m.key == "recall")


@pytest.fixture(scope="module")
def day(rendered_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Run:
    """The usual run, told as a day; its brighter bulbs as the dim ones, half of them broken."""
    folder = tmp_path_factory.mktemp("day") / "run"
    shutil.copytree(rendered_run, folder)
    for name in ("frames", "runs"):
        table = pd.read_parquet(folder / f"{name}.parquet")
        table["time"] = table["sun_lux"].map(HOURS)
        table.loc[table["bulb_lm"] == 3200, "lamps"] = "half"
        table["bulb_lm"] = 200.0
        table.to_parquet(folder / f"{name}.parquet")
    return load(folder)


def test_conditions_go_through_the_day(day: Run) -> None:
    lights = illuminations(day)
    assert [light.time for light in lights] == ["06:00", "06:00", "12:00", "12:00", "18:00", "18:00"]
    assert [light.lamps for light in lights] == ["all", "half"] * 3
    assert lights[3].label == "12:00, sun 97 klx, bulbs 200 lm, lamps half"


def test_the_strongest_light_is_not_the_latest(day: Run) -> None:
    assert [light.time for light in weakest_and_strongest(day)] == ["06:00", "12:00"]


def test_heat_maps_have_a_row_for_each_time_and_a_column_for_each_state(day: Run, rendered_run: Path) -> None:
    data = figures_heat.table(day, compare(day), RECALL)
    panel = figures_heat._figure(day, data, RECALL).axes[0]
    assert [t.get_text() for t in panel.get_yticklabels()] == ["06:00, 0 lx", "12:00, 97 klx", "18:00, 1 klx"]
    assert [t.get_text() for t in panel.get_xticklabels()] == ["200 lm", "200 lm, half"]
    usual = load(rendered_run)
    told = figures_heat.table(usual, compare(usual), RECALL).set_index(["filter", "illumination"])
    drawn = panel.collections[0].get_array().reshape(3, 2)
    for row, sun in enumerate((0, 97_000, 1000)):
        for column, bulb in enumerate((200, 3200)):
            assert drawn[row, column] == told.loc[("none", f"sun{sun}-bulb{bulb}"), "recall_percent"]


def test_light_levels_that_read_alike_stay_apart() -> None:
    """1000 and 1001 lx are both "1 klx" to a person."""
    one, other = (Illumination("", lux, 800.0, "all", 0.0, str(lux)) for lux in (1000.0, 1001.0))
    assert one.label == other.label and one.daylight != other.daylight


def test_exposures_of_a_bracket_are_told_apart(rendered_run: Path, tmp_path: Path) -> None:
    """The usual run, told as if its brighter bulbs had been the dim ones at a shorter exposure."""
    folder = tmp_path / "run"
    shutil.copytree(rendered_run, folder)
    for name in ("frames", "runs"):
        table = pd.read_parquet(folder / f"{name}.parquet")
        table.loc[table["bulb_lm"] == 3200, "exposure_ev"] = -1.5
        table["bulb_lm"] = 200.0
        table.to_parquet(folder / f"{name}.parquet")
    run = load(folder)
    labels = [light.label for light in illuminations(run)]
    assert labels[:2] == ["sun 0 lx, bulbs 200 lm, −1.5 EV", "sun 0 lx, bulbs 200 lm"]
    data = figures_heat.table(run, compare(run), RECALL)
    panel = figures_heat._figure(run, data, RECALL).axes[0]
    assert [t.get_text() for t in panel.get_xticklabels()] == ["200 lm, −1.5 EV", "200 lm"]


def test_the_page_speaks_of_times(day: Run) -> None:
    text = html.build(day.folder).read_text(encoding="utf-8")
    assert "Time of day with its sun (on a surface facing it) against the light of each bulb" in text
    assert "12:00, sun 97 klx, bulbs 200 lm, lamps half" in text
