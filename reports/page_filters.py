"""The page of a study of filters."""

from __future__ import annotations

from reports import figures_filters, figures_strips, filters, provenance, tables_filters, terminal_filters
from reports.comparison import left_out_text
from reports.filters import Filters
from reports.kind import Kind
from reports.light_levels import levels_told
from reports.page import Page, Section
from reports.run import Run
from reports.statistics import MIN_UNITS
from reports.tables import failures
from reports.verdict_filters import harm_verdict, oracle_verdict, verdict

SHOWN = (
    "Every filter on the same picture: of all with any highlight, the one with the median share of it. "
    "White in a mask is what light affects."
)


def compose(run: Run) -> Page:
    """Draw the figures and lay out the page."""
    told = filters.read(run)
    sections = (
        Section("numbers", "All filters", tables=tables_filters.overview(told)),
        Section("cost", "Quality and time", pictures=figures_filters.pictures(told)),
        Section("harm", "Do no harm", tables=(tables_filters.harm(told),)),
        Section("where", "By scene and light", levels_told(run), tables=tables_filters.by_condition(told)),
        figures_strips.section(run, SHOWN),
        Section("failures", "Filters that failed", bullets=tuple(f.text for f in failures(run))),
        Section("reading", "How to read this", bullets=caveats(told)),
    )
    return Page(
        run.title,
        provenance.subtitle(run),
        run.description,
        verdict(told),
        tuple(s for s in (harm_verdict(told), oracle_verdict(told)) if s),
        tuple(s for s in sections if s.tables or s.pictures or s.strips or s.bullets),
        provenance.lines(run),
    )


def caveats(told: Filters) -> tuple[str, ...]:
    """What the numbers are, and are not."""
    sums = told.lit.frames
    threshold = (told.run.study.get("sensor") or {}).get("highlight_threshold", 16)
    texts = [
        f"A pixel is truly affected where specular light adds at least τ = {threshold:g} of 255 grey "
        "levels in a channel. IoU, F1 and AP are means over the pictures that have such pixels; AP is of the "
        "soft score, and doing nothing has the AP of chance.",
        "PSNR averages squared errors over pictures, not decibels. In-mask PSNR is over the truly affected "
        "pixels, the same for each filter. Recall is landmarks found over landmarks visible, in points of "
        "100.",
        f"An interval covers 95 %: a paired bootstrap over {sums.blocks} {sums.unit}, scene and place on the "
        "tour together, all levels of light of a place staying with it; each filter on the same pictures. "
        f"With fewer than {MIN_UNITS} of them, or where fewer changed, none is given. Each interval stands "
        "for itself: of many, about one in twenty misses by chance.",
        "Times are of one call on one core, the conversion into the filter's form included, on a made-up "
        "picture of coloured tiles under three highlights; what else the machine does at that time tells in "
        "them.",
        "The intervals speak for these scenes and this camera; no robot was localised.",
    ]
    if sums.left_out:
        texts.append(left_out_text(told.lit))
    return tuple(texts)


KIND = Kind(compose, terminal_filters.summary, failures, rendered=True)
