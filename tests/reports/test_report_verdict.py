"""The sentence must say harm when it was harm, help when it was help, and neither when nobody can tell."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from reports.comparison import compare
from reports.run import load
from reports.statistics import Estimate
from reports.verdict import effect, mask_verdict, verdict
from reports.wording import NBSP, telling_digits

Make = Callable[..., Path]


def sentence(folder: Path) -> str:
    run = load(folder)
    return verdict(run, compare(run)).replace(NBSP, " ")


def one(make: Make, recall: float, rmse: float, **more: object) -> str:
    """The verdict on one filter that changes recall and RMSE by so much."""
    return sentence(
        make(
            filters=("none", "seed"),
            recall={"seed": recall},
            rmse={"seed": rmse},
            strips=False,
            tracks=False,
            **more,
        )
    )


def test_harm(rendered: Make) -> None:
    text = one(rendered, -0.2, 0.2)
    assert "the filter “seed” did harm: the robot found fewer of the visible landmarks (−" in text
    assert "position RMSE rose (+0." in text
    assert "helped" not in text


def test_help(rendered: Make) -> None:
    text = one(rendered, 0.1, -0.2)
    assert "the filter “seed” helped: the robot found more of the visible landmarks (+" in text
    assert "position RMSE fell (−0." in text
    assert "harm" not in text


def test_no_effect(rendered: Make) -> None:
    text = one(rendered, 0.0, 0.0)
    assert "had no effect that this run can tell apart from zero" in text
    assert "95 % interval −" in text and "… +" in text
    assert "harm" not in text and "helped" not in text


def test_one_better_one_worse(rendered: Make) -> None:
    assert "helped detection and harmed position" in one(rendered, 0.1, 0.2)


def test_harm_to_detection_alone(rendered: Make) -> None:
    text = one(rendered, -0.2, 0.0)
    assert "did harm" in text
    assert "position RMSE shows no change that can be told apart from zero" in text


def test_too_few_seeds_say_so_instead_of_an_interval(rendered: Make) -> None:
    text = one(rendered, -0.2, 0.2, seeds=3)
    assert "too few seeds for an interval (3 < 6)" in text
    assert "the change in position RMSE has no interval" in text


def test_too_small_to_judge(rendered: Make) -> None:
    assert "cannot be judged from this run" in one(rendered, -0.2, 0.2, seeds=2, frames=4)


def test_failed_runs_are_told(rendered: Make) -> None:
    text = one(rendered, 0.0, 0.0, failed=(("seed", 1),))
    assert "6 of 48 with the filter and 0 of 48 without" in text


def test_a_run_of_failures_alone(rendered: Make) -> None:
    text = one(rendered, 0.0, 0.0, failed=tuple(("seed", k) for k in range(8)))
    assert "nothing to measure" in text and "48 of 48" in text


def test_no_filter(rendered: Make) -> None:
    assert "nothing to compare" in sentence(rendered(filters=("none",), strips=False, tracks=False))


def test_it_is_one_sentence(rendered_run: Path) -> None:
    text = sentence(rendered_run)
    assert text.endswith(".") and text.count(". ") == 0
    assert "“seed”" in text and "“seed_per_pixel”" in text


def test_masks_beside_an_empty_mask(rendered_run: Path) -> None:
    run = load(rendered_run)
    text = mask_verdict(run, compare(run))
    assert "an empty mask (IoU 0) is already right on 9" in text
    assert "fewer than the empty mask" in text
    assert text.endswith(".") and text.count(". ") == 0


def test_an_interval_that_excludes_zero_does_not_print_as_zero() -> None:
    assert telling_digits(Estimate(0.0013, 0.00012, 0.0027), 1, 100.0) == 2
    assert telling_digits(Estimate(0.013, 0.012, 0.027), 1, 100.0) == 1
    assert telling_digits(Estimate(0.0, -0.00001, 0.00001), 1) == 1


@pytest.mark.parametrize(
    ("low", "value", "high", "expected"),
    [
        (0.1, 0.2, 0.3, "helped"),
        (-0.3, -0.2, -0.1, "harmed"),
        (-0.1, 0.2, 0.3, "unclear"),
        (0.0, 0.0, 0.0, "same"),
        (float("nan"), 0.2, float("nan"), "untested"),
    ],
)
def test_effect(low: float, value: float, high: float, expected: str) -> None:
    assert effect(Estimate(value, low, high), higher_is_better=True) == expected
    mirrored = {"helped": "harmed", "harmed": "helped"}.get(expected, expected)
    assert effect(Estimate(value, low, high), higher_is_better=False) == mirrored
