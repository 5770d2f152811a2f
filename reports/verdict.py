"""The answer in one sentence, whatever it is."""

from __future__ import annotations

import math
from collections.abc import Mapping

from reports.comparison import Comparison
from reports.run import BASELINE, Run
from reports.statistics import Estimate
from reports.wording import NBSP, interval, listing, number, plural, telling_digits

HELPED, HARMED, UNCLEAR, SAME, UNTESTED = "helped", "harmed", "unclear", "same", "untested"
FAILED = "failed on every picture"

RECALL_WORDS = {
    "name": "landmarks found of those visible",
    HELPED: "the robot found more of the visible landmarks",
    HARMED: "the robot found fewer of the visible landmarks",
    UNCLEAR: "landmarks found show no change that can be told apart from zero",
    SAME: "the robot found just as many landmarks",
    UNTESTED: "the change in landmarks found has no interval",
}
RMSE_WORDS = {
    "name": "position RMSE",
    HELPED: "position RMSE fell",
    HARMED: "position RMSE rose",
    UNCLEAR: "position RMSE shows no change that can be told apart from zero",
    SAME: "position RMSE stayed exactly the same",
    UNTESTED: "the change in position RMSE has no interval",
}


def effect(change: Estimate, *, higher_is_better: bool) -> str:
    """What a paired change says: helped, harmed, unclear (cannot be told from zero), same or untested."""
    if not change.has_interval:
        return UNTESTED
    if change.value == change.low == change.high == 0.0:
        return SAME
    if not change.excludes_zero:
        return UNCLEAR
    return HELPED if (change.value > 0.0) == higher_is_better else HARMED


def verdict(run: Run, comparison: Comparison) -> str:
    """One sentence: what each filter did to landmark detection and to the position error."""
    if not run.light_filters:
        return (
            "This run holds no light filter, only the pictures as recorded, so there is nothing to compare."
        )
    parts = [
        _on_filter(name, comparison) if name in comparison.filters else f"the filter “{name}” {FAILED}"
        for name in run.light_filters
    ]
    where = plural(run.frames["illumination"].nunique(), "illumination")
    if len(run.scenes) > 1:
        where += f" of {plural(len(run.scenes), 'scene')}"
    return f"Compared with doing nothing, over {where}, {'; '.join(parts)}."


def _on_filter(name: str, comparison: Comparison) -> str:
    recall, rmse = comparison.recall_change(name), comparison.run_change(name, "rmse_m")
    on_recall = effect(recall, higher_is_better=True)
    on_rmse = effect(rmse, higher_is_better=False)
    said = not {HELPED, HARMED} & {on_recall, on_rmse} and on_recall == on_rmse
    parts = (
        _words(RECALL_WORDS, on_recall, said) + _bracket(recall, "percentage points", 1, scale=100.0),
        _words(RMSE_WORDS, on_rmse, said) + _bracket(rmse, "m", 3),
    )
    overall = _overall(on_recall, on_rmse)
    by_light = _by_light(name, comparison)
    return f"the filter “{name}” {overall}: {listing(list(parts))}{by_light}{_failures(name, comparison)}"


def _by_light(name: str, comparison: Comparison) -> str:
    """Under how many lights detection changed one way or the other, where it changed at all."""
    lights = comparison.frames.axes[1]
    effects = [effect(comparison.recall_change(name, light), higher_is_better=True) for light in lights]
    gained, lost = effects.count(HELPED), effects.count(HARMED)
    if len(lights) < 2 or not gained + lost:
        return ""
    return f"; light by light, detection gained under {gained} and lost under {lost} of {len(lights)}"


def _overall(recall: str, rmse: str) -> str:
    effects = {recall, rmse}
    if {HELPED, HARMED} <= effects:
        good, bad = ("detection", "position") if recall == HELPED else ("position", "detection")
        return f"helped {good} and harmed {bad}"
    if HARMED in effects:
        return "did harm"
    if HELPED in effects:
        return "helped"
    if effects == {SAME}:
        return "changed nothing"
    if effects == {UNTESTED}:
        return "cannot be judged from this run"
    return "had no effect that this run can tell apart from zero"


def _words(words: Mapping[str, str], kind: str, said: bool) -> str:
    """What happened to one number; just its name where the sentence has already said so."""
    return f"{words['name'] if said else words[kind]} "


def _bracket(change: Estimate, unit: str, digits: int, *, scale: float = 1.0) -> str:
    """The change as "(+0.20 m, 95 % interval +0.19 … +0.21)", or why there is no interval."""
    if math.isnan(change.value):
        return f"({change.note})"
    digits = telling_digits(change, digits, scale)
    value = f"{number(change.value * scale, digits, signed=True)}{NBSP}{unit}"
    if not change.has_interval:
        return f"({value}; {change.note})"
    bounds = interval(change, digits, scale=scale, signed=True)
    return f"({value}, 95{NBSP}% interval {bounds})" if bounds else f"({value})"


def _failures(name: str, comparison: Comparison) -> str:
    ours, total = comparison.runs.failed(name)
    base, base_total = comparison.runs.failed(BASELINE)
    if not ours and not base:
        return ""
    return (
        f", not counting the SLAM runs that failed and have no error to compare, {ours} of {total} with the "
        f"filter and {base} of {base_total} without"
    )


def mask_verdict(run: Run, comparison: Comparison) -> str:
    """One sentence: how good the masks are next to a mask that is empty."""
    if not run.light_filters:
        return ""
    truth = comparison.mask(BASELINE, "true_share").value
    empty = comparison.right_pixels(BASELINE).value
    parts = [
        _mask_words(name, comparison, empty) if name in comparison.filters else f"“{name}” {FAILED}"
        for name in run.light_filters
    ]
    return (
        f"Light truly affects {number(100 * truth, 1)} % of the pixels, so an empty mask (IoU 0) is already "
        f"right on {number(100 * empty, 1)} % of them; {'; '.join(parts)}."
    )


def _mask_words(name: str, comparison: Comparison, empty: float) -> str:
    iou = comparison.mask(name, "iou")
    masked = comparison.mask(name, "masked_share").value
    right = comparison.right_pixels(name).value
    bounds = f", 95 % interval {interval(iou)}" if iou.has_interval else ""
    standing = "fewer" if right < empty else "more" if right > empty else "as many"
    than = "as" if standing == "as many" else "than"
    return (
        f"“{name}” marks {number(100 * masked, 1)} %, overlaps the truth with IoU {number(iou.value)}"
        f"{bounds}, and is right on {number(100 * right, 1)} %, {standing} {than} the empty mask"
    )
