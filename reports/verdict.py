"""The answer in one sentence, whatever it is."""

from __future__ import annotations

from reports.comparison import Comparison
from reports.run import BASELINE, Run
from reports.statistics import Estimate
from reports.wording import interval, listing, number, plural

HELPED, HARMED, UNCLEAR, SAME, UNTESTED = "helped", "harmed", "unclear", "same", "untested"


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
    parts = [_on_filter(name, comparison) for name in run.light_filters]
    conditions = run.frames["illumination"].nunique()
    return f"Compared with doing nothing, over {plural(conditions, 'illumination')}, {'; '.join(parts)}."


def _on_filter(name: str, comparison: Comparison) -> str:
    recall, rmse = comparison.recall_change(name), comparison.run_change(name, "rmse_m")
    on_recall = effect(recall, higher_is_better=True)
    on_rmse = effect(rmse, higher_is_better=False)
    details = f"{_recall_words(recall, on_recall)}, and {_rmse_words(rmse, on_rmse)}"
    return f"the filter {name} {_overall(on_recall, on_rmse)}: {details}{_failures(name, comparison)}"


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
        return "cannot be judged from so small a run"
    return "had no effect that this run can tell apart from zero"


def _recall_words(change: Estimate, kind: str) -> str:
    moved = {HELPED: "more", HARMED: "fewer"}
    shown = _bracket(change, "percentage points", 1, scale=100.0)
    if kind in moved:
        return f"it let the robot find {moved[kind]} of the visible landmarks ({shown})"
    return f"{_still(kind)} the share of visible landmarks found ({shown})"


def _rmse_words(change: Estimate, kind: str) -> str:
    moved = {HELPED: "smaller", HARMED: "larger"}
    shown = _bracket(change, "m", 3)
    if kind in moved:
        return f"the position error (RMSE) became {moved[kind]} ({shown})"
    return f"{_still(kind)} the position error (RMSE) ({shown})"


def _still(kind: str) -> str:
    words = {
        UNCLEAR: "no change that can be told apart from zero in",
        SAME: "no change at all in",
        UNTESTED: "no tested change in",
    }
    return words[kind]


def _bracket(change: Estimate, unit: str, digits: int, *, scale: float = 1.0) -> str:
    value = f"{number(change.value * scale, digits, signed=True)} {unit}"
    if change.has_interval:
        return f"{value}, 95 % interval {interval(change, digits, scale=scale, signed=True)}"
    return f"{value}, {change.note}" if change.value == change.value else change.note


def _failures(name: str, comparison: Comparison) -> str:
    ours, total = comparison.runs.failed(name)
    base, base_total = comparison.runs.failed(BASELINE)
    if not ours and not base:
        return ""
    return (
        f" ({ours} of {total} SLAM runs failed with it and {base} of {base_total} without; "
        "these have no error to compare)"
    )


def mask_verdict(run: Run, comparison: Comparison) -> str:
    """One sentence: how good the masks are next to a mask that is empty."""
    if not run.light_filters:
        return ""
    truth = comparison.mask(BASELINE, "true_share").value
    empty = comparison.right_pixels(BASELINE).value
    parts = [_mask_words(name, comparison, empty) for name in run.light_filters]
    return (
        f"Light truly affects {number(100 * truth, 1)} % of the pixels, so an empty mask (IoU 0) is already "
        f"right on {number(100 * empty, 1)} % of them; {listing(parts)}."
    )


def _mask_words(name: str, comparison: Comparison, empty: float) -> str:
    iou = comparison.mask(name, "iou")
    masked = comparison.mask(name, "masked_share").value
    right = comparison.right_pixels(name).value
    bounds = f", 95 % interval {interval(iou)}" if iou.has_interval else ""
    standing = "fewer" if right < empty else "more" if right > empty else "as many"
    than = "as" if standing == "as many" else "than"
    return (
        f"{name} marks {number(100 * masked, 1)} %, overlaps the truth with IoU {number(iou.value)}{bounds}, "
        f"and is right on {number(100 * right, 1)} %, {standing} {than} the empty mask"
    )
