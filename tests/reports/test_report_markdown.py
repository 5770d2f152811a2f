"""Tables of a page as Markdown."""

from __future__ import annotations

from reports.markdown import lines, render
from reports.page import Cell, Page, Section, Table, TableRow


def _table(*rows: TableRow) -> Table:
    return Table("How far", "filter", ("RMSE, m", "a|b"), rows, ("A note.",))


def test_every_cell_stands_in_its_column_with_mark_and_interval() -> None:
    row = TableRow(
        "seed", (Cell("0.034", "0.030\N{NO-BREAK SPACE}…\N{NO-BREAK SPACE}0.040", "worse"), Cell())
    )
    assert lines(_table(row)).splitlines() == [
        "| filter | RMSE, m | a&#124;b |",
        "| --- | --- | --- |",
        "| seed | 0.034 ▼ (0.030 … 0.040) |  |",
    ]


def test_groups_are_a_column_and_stand_once() -> None:
    rows = [
        TableRow("none", (Cell("1"), Cell("2")), group="office"),
        TableRow("seed", (Cell("3"), Cell("4"))),
    ]
    told = [line.split("|")[1].strip() for line in lines(_table(*rows)).splitlines()]
    assert told == ["", "---", "office", ""]
    assert len({line.count("|") for line in lines(_table(*rows)).splitlines()}) == 1


def test_a_page_is_its_verdict_and_its_tables_with_notes() -> None:
    table = _table(TableRow("none", (Cell("1"), Cell("2"))))
    page = Page("Title", "", "", "It helped.", (), (Section("a", "Numbers", tables=(table,)),))
    parts = render(page).split("\n\n")
    assert parts == ["# Title", "It helped.", "## How far", lines(table), "A note.\n"]
