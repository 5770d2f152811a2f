"""The tables of a study of filters, and their data beside them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from reports.comparison import Comparison
from reports.filters import (
    AP,
    F1,
    IN_MASK,
    IN_MASK_CHANGE,
    IOU,
    MASKED,
    ORACLE,
    PSNR_CHANGE,
    RECALL_CHANGE,
    Filters,
    Measure,
)
from reports.page import Cell, Table, TableRow
from reports.run import BASELINE, Run
from reports.statistics import Estimate
from reports.style import write_csv
from reports.tables import MARK_NOTE
from reports.wording import interval, number, telling_digits

ORACLE_NOTE = (
    f"“{ORACLE}” is no filter: it is given the true mask and the true diffuse picture, and shows what there "
    "is to gain."
)


def overview(told: Filters) -> tuple[Table, Table]:
    """One filter a line, all pooled: masks and times, then repair; saved as ``figures/filters.csv``."""
    before, after = (IOU, F1, AP), (IN_MASK, IN_MASK_CHANGE, PSNR_CHANGE, RECALL_CHANGE)
    head = (
        *(m.heading for m in before),
        f"{MASKED.heading} (highlight-free)",
        *(m.heading for m in after),
        *(f"ms, {width} × {height}" for width, height in told.sizes),
    )
    rows, stored = [], []
    for name in told.names:
        of_free = told.highlight_free if name in told.highlight_free.filters else None
        values = [(m, m.measure(told.lit, name)) for m in before]
        values.append((MASKED, MASKED.measure(of_free, name) if of_free else Estimate(float("nan"))))
        values += [(m, m.measure(told.lit, name)) for m in after]
        times = [told.milliseconds(name, size) for size in told.sizes]
        cells = [*(cell(m, v, name) for m, v in values), *(Cell(_milliseconds(t)) for t in times)]
        rows.append(_row(name, cells))
        stored += [(name, title, v) for title, (_, v) in zip(head, values, strict=False)]
        stored += [(name, title, Estimate(t)) for title, t in zip(head[len(values) :], times, strict=True)]
    _save(told.run, "filters", stored)
    last = len(before) + 1 + len(after)
    of_mask, of_repair = (*range(len(before) + 1), *range(last, len(head))), range(len(before) + 1, last)
    notes = ("All scenes and levels of light pooled.", MARK_NOTE, ORACLE_NOTE)

    def part(caption: str, columns: Sequence[int], told_below: tuple[str, ...] = ()) -> Table:
        lines = tuple(_row(r.label, [r.cells[k] for k in columns]) for r in rows)
        some = tuple(head[k] for k in columns)
        return Table(caption, "filter", some, lines, told_below, "figures/filters.csv")

    return part("Masks, and time", of_mask), part("Repair, and landmarks found", of_repair, notes)


def harm(told: Filters) -> Table:
    """What each filter does where there is nothing to do; saved as ``figures/harm.csv``."""
    parts: list[tuple[str, Measure, Comparison]] = [
        (f"{m.heading}: highlight-free", m, told.highlight_free) for m in (MASKED, RECALL_CHANGE, PSNR_CHANGE)
    ]
    if told.neutral is not None:
        parts += [(f"{m.heading}: white and grey objects", m, told.neutral) for m in (MASKED, PSNR_CHANGE)]
    head = (*(title for title, _, _ in parts), "frame PSNR change, dB: worst scene and level")
    rows, stored = [], []
    for name in told.names:
        if name == ORACLE:
            continue
        values = [(m, m.measure(comparison, name)) for _, m, comparison in parts]
        worst, where = told.worst_psnr_change(name)
        shown = Cell(number(worst.value, PSNR_CHANGE.digits, signed=True), where if name != BASELINE else "")
        rows.append(_row(name, [*(cell(m, v, name) for m, v in values), shown]))
        stored += [(name, title, v) for title, (_, v) in zip(head, values, strict=False)]
        stored.append((name, head[-1], worst))
    _save(told.run, "harm", stored)
    notes = (
        "Highlight-free: the same pictures with all specular light removed, at the same exposure and with "
        "the same noise; whatever is masked there is masked wrongly.",
        MARK_NOTE,
    )
    return Table("Where there is nothing to repair", "filter", head, tuple(rows), notes, "figures/harm.csv")


def by_condition(told: Filters) -> tuple[Table, ...]:
    """A table for each of four measures: filters by scenes, and by levels of light."""
    return tuple(_by_condition(told, m) for m in (IOU, IN_MASK_CHANGE, PSNR_CHANGE, RECALL_CHANGE))


def _by_condition(told: Filters, measure: Measure) -> Table:
    of_scene: list[tuple[str, Callable[[str], Estimate]]] = [
        (scene, lambda name, c=comparison: measure.measure(c, name))  # type: ignore[misc]
        for scene, comparison in told.by_scene.items()
    ]
    of_level: list[tuple[str, Callable[[str], Estimate]]] = [
        (f"light: {level}", lambda name, w=level: measure.measure(told.lit, name, w))  # type: ignore[misc]
        for level in told.levels
    ]
    columns = of_scene + of_level
    rows, stored = [], []
    for name in told.names:
        values = [(title, of(name)) for title, of in columns]
        rows.append(_row(name, [cell(measure, v, name) for _, v in values]))
        stored += [(name, f"{measure.heading}: {title}", v) for title, v in values]
    stem = f"by-condition-{measure.key.replace('_', '-')}"
    _save(told.run, stem, stored)
    head = tuple(title for title, _ in columns)
    return Table(measure.heading, "filter", head, tuple(rows), (), f"figures/{stem}.csv", folded=True)


def cell(measure: Measure, value: Estimate, name: str) -> Cell:
    """A number with its interval, marked where it is a change that can be told from zero."""
    if measure.change and name == BASELINE:
        return Cell()
    digits = telling_digits(value, measure.digits) if measure.change else measure.digits
    mark = ("better" if value.value > 0 else "worse") if measure.change and value.excludes_zero else ""
    text = number(value.value, digits, signed=measure.change)
    return Cell(text, interval(value, digits, signed=measure.change), mark)


def _milliseconds(value: float) -> str:
    return number(value, 2 if value < 10 else 0)


def _row(name: str, cells: Sequence[Cell]) -> TableRow:
    return TableRow(name, tuple(cells), quiet=name in (BASELINE, ORACLE))


def _save(run: Run, stem: str, stored: Sequence[tuple[str, str, Estimate]]) -> None:
    import pandas as pd

    (run.folder / "figures").mkdir(exist_ok=True)
    lines = [(name, title, v.value, v.low, v.high, v.units, v.unit, v.note) for name, title, v in stored]
    head = ["filter", "measure", "value", "low_95", "high_95", "resampled", "resampled_unit", "note"]
    write_csv(pd.DataFrame(lines, columns=head), run.folder / f"figures/{stem}.csv")
