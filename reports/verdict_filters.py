"""The answer of a study of filters in a few sentences, whatever it is."""

from __future__ import annotations

from reports.filters import (
    IN_MASK_CHANGE,
    IOU,
    MASKED,
    ORACLE,
    PSNR_CHANGE,
    RECALL_CHANGE,
    Filters,
    Measure,
)
from reports.statistics import Estimate
from reports.wording import interval, listing, number, plural

HARMLESS_MASKED, HARMLESS_RECALL, HARMLESS_NEUTRAL_DB = 0.2, 0.5, -0.1
"""Masked per cent and points of recall on highlight-free pictures, decibels on white and grey objects: what
may be called no harm."""


def verdict(told: Filters) -> str:
    """Which filter finds and which repairs highlights best, and how many make pictures or robots worse."""
    names = told.light_filters
    if not names:
        return "This run holds no light filter, so there is nothing to compare."
    pictures = len(told.run.frames.drop_duplicates(["scene", "illumination", "frame"]))
    psnr = {name: PSNR_CHANGE.measure(told.lit, name) for name in names}
    recall = {name: RECALL_CHANGE.measure(told.lit, name) for name in names}
    return (
        f"Over {plural(pictures, 'picture')} of {plural(len(told.scenes), 'scene')}, "
        f"{_best(told, IOU, 'finds highlights best')}; {_best(told, IN_MASK_CHANGE, 'restores them most')}. "
        f"{_split(psnr, 'the whole picture closer to the diffuse one', 'further from it')}; "
        f"{_split(recall, 'landmark recall up', 'down')}."
    )


def harm_verdict(told: Filters) -> str:
    """Which filters leave alone what has no highlight."""
    if not told.light_filters:
        return ""
    harmless = [name for name in told.light_filters if _harmless(told, name)]
    limits = (
        f"at most {HARMLESS_MASKED} % masked of highlight-free pictures, landmark recall there changed by at "
        f"most {HARMLESS_RECALL} points"
    )
    limits += f", at most {-HARMLESS_NEUTRAL_DB} dB lost on white and grey objects" if told.neutral else ""
    if not harmless:
        return f"No filter stays within what may be called no harm: {limits}."
    quoted = listing([f"“{name}”" for name in harmless])
    return f"Of {plural(len(told.light_filters), 'filter')}, {len(harmless)} do no harm ({limits}): {quoted}."


def oracle_verdict(told: Filters) -> str:
    """What the truth itself would give the landmark detector."""
    if ORACLE not in told.lit.filters:
        return ""
    gain = RECALL_CHANGE.measure(told.lit, ORACLE)
    return (
        "With the true mask and the true diffuse picture, landmark recall would change by "
        f"{_told(RECALL_CHANGE, gain)}: what a perfect light filter would give."
    )


def _harmless(told: Filters, name: str) -> bool:
    masked = MASKED.measure(told.highlight_free, name).value
    recall = RECALL_CHANGE.measure(told.highlight_free, name).value
    neutral = PSNR_CHANGE.measure(told.neutral, name).value if told.neutral else 0.0
    return masked <= HARMLESS_MASKED and abs(recall) <= HARMLESS_RECALL and not neutral < HARMLESS_NEUTRAL_DB


def _best(told: Filters, measure: Measure, what: str) -> str:
    values = {name: measure.measure(told.lit, name) for name in told.light_filters}
    order = sorted((n for n in values if values[n].value == values[n].value), key=lambda n: -values[n].value)
    if not order:
        return f"no filter has a number for {measure.title}"
    second = ""
    if len(order) > 1:
        shown = number(values[order[1]].value, measure.digits, signed=measure.change)
        second = f", ahead of “{order[1]}” with {shown}"
    return f"“{order[0]}” {what} ({measure.title} {_told(measure, values[order[0]])}{second})"


def _split(changes: dict[str, Estimate], up: str, down: str) -> str:
    better = sum(c.excludes_zero and c.value > 0 for c in changes.values())
    worse = sum(c.excludes_zero and c.value < 0 for c in changes.values())
    return f"{better} of {plural(len(changes), 'filter')} bring {up}, {worse} {down}"


def _told(measure: Measure, value: Estimate) -> str:
    bounds = interval(value, measure.digits, signed=measure.change)
    unit = f" {measure.unit}" if measure.unit else ""
    shown = number(value.value, measure.digits, signed=measure.change)
    return f"{shown}{unit}" + (f" [{bounds}]" if bounds else "")
