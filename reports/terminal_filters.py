"""A study of filters in a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.filters import IN_MASK_CHANGE, IOU, MASKED, ORACLE, PSNR_CHANGE, RECALL_CHANGE, read
from reports.run import Run
from reports.tables import failures
from reports.terminal import ARROWS, paragraphs, text_table
from reports.wording import number

if TYPE_CHECKING:
    from rich.console import RenderableType

LIT = (IOU, IN_MASK_CHANGE, PSNR_CHANGE, RECALL_CHANGE)


def summary(run: Run) -> RenderableType:
    """One filter a line; the page has the intervals."""
    from rich.console import Group

    from reports.tables_filters import ORACLE_NOTE, cell
    from reports.verdict_filters import harm_verdict, oracle_verdict, verdict

    told = read(run)
    head = [m.heading.replace(", ", "\n") for m in LIT]
    table = text_table("filter", [*head, "masked, %\nhighlight-free", "ms"])
    for name in told.names:
        shown = [cell(m, m.measure(told.lit, name), name) for m in LIT]
        masked = (
            "" if name == ORACLE else number(MASKED.measure(told.highlight_free, name).value, MASKED.digits)
        )
        milliseconds = number(told.milliseconds(name, told.sizes[0]), 1) if told.sizes else ""
        table.add_row(name, *(c.value + ARROWS[c.mark] for c in shown), masked, milliseconds)
    notes = ["▲ better, ▼ worse than doing nothing, by a paired 95 % interval.", ORACLE_NOTE]
    notes += [f"failed: {f.text}" for f in failures(run)]
    sentences = [verdict(told), harm_verdict(told), oracle_verdict(told)]
    return Group(*paragraphs(sentences, "bold"), table, *paragraphs(notes, "dim"))
