"""A study of picture pairs in a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports import pairs
from reports.pairs import DETECTION, REPAIR
from reports.run import BASELINE, Run
from reports.terminal import ARROWS, paragraphs, text_table
from reports.wording import number

if TYPE_CHECKING:
    from rich.console import RenderableType


def summary(run: Run) -> RenderableType:
    """Means over the pictures: how close each filter comes, and how good its mask is."""
    from rich.console import Group

    from reports.page_pairs import verdict

    told = pairs.read(run)
    repair = text_table("filter", [m.heading.replace(", ", "\n") for m in REPAIR])
    for name in told.filters:
        cells = []
        for m in REPAIR:
            effect = pairs.change(told.pictures, name, m.key) if name != BASELINE else None
            arrow = ARROWS[pairs.mark(m, effect)] if effect and m.key != "filter_ms" else ""
            cells.append(number(pairs.mean(told.pictures, name, m.key).value, m.digits) + arrow)
        repair.add_row(name, *cells)
    tables = [repair]
    for truth in told.truths:
        scored = told.masks[told.masks["truth"] == truth]
        masks = text_table(f"mask: {truth}", [m.heading for m in DETECTION])
        for name in told.filters:
            masks.add_row(name, *(number(pairs.mean(scored, name, m.key).value, m.digits) for m in DETECTION))
        tables.append(masks)
    notes = ["▲ better, ▼ worse than doing nothing, by a paired 95 % interval over the pictures."]
    notes += [f"failed: {f.text}" for f in pairs.failures(run)]
    return Group(*paragraphs([verdict(told)], "bold"), *tables, *paragraphs(notes, "dim"))
