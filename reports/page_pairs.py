"""The page of a study of picture pairs."""

from __future__ import annotations

from reports import figures_pairs, figures_strips, pairs, provenance, terminal_pairs
from reports.kind import Kind
from reports.page import Cell, Page, Section, Table, TableRow
from reports.pairs import DETECTION, REPAIR, Measure, Pairs
from reports.run import BASELINE, Run
from reports.style import write_csv
from reports.wording import interval, number, plural

MARK_NOTE = (
    "With a value its 95 % interval over the pictures. ▲ better, ▼ worse than doing nothing: the interval "
    "of the paired difference excludes zero."
)


def compose(run: Run) -> Page:
    """Draw the figures and lay out the page."""
    told = pairs.read(run)
    sections = (
        Section("repair", "How close to the diffuse picture", tables=(repair_table(run, told),)),
        Section("cost", "Quality and time", pictures=figures_pairs.pictures(run, told)),
        Section("masks", "Which pixels are called affected", tables=mask_tables(run, told)),
        figures_strips.section(run),
        Section("failures", "Filters that failed", bullets=tuple(f.text for f in pairs.failures(run))),
        Section("reading", "How to read this", bullets=caveats(run)),
    )
    return Page(
        run.title,
        provenance.subtitle(run),
        run.description,
        verdict(told),
        (),
        tuple(s for s in sections if s.tables or s.pictures or s.strips or s.bullets),
        provenance.lines(run),
    )


def verdict(told: Pairs) -> str:
    """Which filter comes closest, and how many are worse than doing nothing."""
    count = told.pictures["picture"].nunique()
    others = [name for name in told.filters if name != BASELINE]
    if not others:
        return "This run holds no light filter, so there is nothing to compare."
    measure = REPAIR[0]
    means = {name: pairs.mean(told.pictures, name, measure.key).value for name in told.filters}
    best = max(told.filters, key=lambda name: means[name] if means[name] == means[name] else -1.0)
    worse = [name for name in others if means[name] < means[BASELINE]]
    return (
        f"Over {plural(count, 'picture')}, doing nothing has {number(means[BASELINE])} dB, and "
        + (
            "no filter is closer to the diffuse pictures; "
            if best == BASELINE
            else f"“{best}” is closest with {number(means[best])} dB; "
        )
        + f"{len(worse)} of {plural(len(others), 'filter')} do worse than nothing on average."
    )


def repair_table(run: Run, told: Pairs) -> Table:
    """One filter a line; saved as ``figures/pairs.csv``."""
    rows = [
        TableRow(name, tuple(_cell(told.pictures, name, m) for m in REPAIR), quiet=name == BASELINE)
        for name in told.filters
    ]
    return _saved(run, "pairs", "Mean over the pictures", REPAIR, rows, (MARK_NOTE,))


def mask_tables(run: Run, told: Pairs) -> tuple[Table, ...]:
    """A table for each true mask."""
    return tuple(_mask_table(run, told, truth, k) for k, truth in enumerate(told.truths))


def _mask_table(run: Run, told: Pairs, truth: str, number_of: int) -> Table:
    scored = told.masks[told.masks["truth"] == truth]
    rows = [
        TableRow(name, tuple(_cell(scored, name, m, marked=False) for m in DETECTION), quiet=name == BASELINE)
        for name in told.filters
    ]
    share = number(100 * float(scored["true_share"].mean()), 1)
    notes = (f"{share} % of the pixels are affected. An empty mask has IoU 0 and BER 0.5.",)
    return _saved(run, f"masks-{number_of}", truth, DETECTION, rows, notes)


def _cell(table, name: str, measure: Measure, marked: bool = True) -> Cell:  # type: ignore[no-untyped-def]
    value = pairs.mean(table, name, measure.key)
    effect = pairs.change(table, name, measure.key) if marked and name != BASELINE else None
    told = pairs.mark(measure, effect) if effect is not None and measure.key != "filter_ms" else ""
    return Cell(number(value.value, measure.digits), interval(value, measure.digits), told)


def _saved(
    run: Run,
    stem: str,
    caption: str,
    measures: tuple[Measure, ...],
    rows: list[TableRow],
    notes: tuple[str, ...],
) -> Table:
    import pandas as pd

    head = tuple(m.heading for m in measures)
    (run.folder / "figures").mkdir(exist_ok=True)
    data = [(r.label, *(c.value for c in r.cells)) for r in rows]
    csv = f"figures/{stem}.csv"
    write_csv(pd.DataFrame(data, columns=["filter", *head]), run.folder / csv)
    return Table(caption, "filter", head, tuple(rows), notes, csv)


def caveats(run: Run) -> tuple[str, ...]:
    """What the numbers are, and are not."""
    held = "linear light" if run.study.get("linear") else "sRGB codes"
    return (
        f"All numbers but ΔE2000 are computed on {held}, as the files hold them; numbers from linear and "
        "from encoded pictures differ by decibels and must not be compared.",
        "PSNR is the mean of the pictures' decibels, as the field reports it; perfect pictures (∞ dB) are "
        "left out of that mean. In-mask PSNR tells methods apart, the whole frame's hardly does.",
        "SSIM is Wang's 2004 form, the mean of the channels; MATLAB's 3-D form takes the channels for a "
        "third axis of space and is what most tables hold.",
        "LMSE leaves each window of 20 × 20 pixels its best factor (Grosse 2009): 0 is perfect, 1 is black.",
        "A pixel is affected where it exceeds the diffuse one by more than the residue in a channel.",
        "The time is that of one call on each picture, its conversion into the filter's form included.",
    )


KIND = Kind(compose, terminal_pairs.summary, pairs.failures, filtered=False)
