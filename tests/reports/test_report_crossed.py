"""Intervals over a table whose rows and columns both are random: illuminations and seeds."""

from __future__ import annotations

import numpy as np
import pytest

from reports.statistics import MIN_UNITS, crossed, estimate, ratio


def _table(rng: np.random.Generator, rows: int, columns: int, row_sd: float, column_sd: float) -> np.ndarray:
    effects = rng.normal(0, row_sd, (rows, 1)) + rng.normal(0, column_sd, (1, columns))
    return effects + rng.normal(0, 0.1, (rows, columns))


def test_the_value_is_the_plain_mean_and_gaps_do_not_count() -> None:
    values = np.arange(80.0).reshape(8, 10)
    values[3, 4] = np.nan
    assert crossed(values, "lights", "seeds").value == pytest.approx(np.nanmean(values))


def test_what_only_rows_share_is_not_taken_for_certain() -> None:
    """All seeds of a light share an error: over seeds alone the interval would be almost a point."""
    rng = np.random.default_rng(1)
    values = _table(rng, 9, 10, row_sd=1.0, column_sd=0.0)
    both = crossed(values, "lights", "seeds")
    sums = np.stack([values.sum(axis=0), np.full(10, 9.0)])
    seeds_alone = estimate(ratio, sums, "seeds")
    assert both.high - both.low > 5 * (seeds_alone.high - seeds_alone.low)


def test_it_covers_the_truth_as_often_as_it_says() -> None:
    """Conservative is allowed (Owen 2007), careless is not: 200 tables around a true mean of 0."""
    rng = np.random.default_rng(2)
    tables = [_table(rng, 9, 10, row_sd=0.5, column_sd=0.5) for _ in range(200)]
    hits = sum(e.low <= 0.0 <= e.high for e in (crossed(t, "lights", "seeds") for t in tables))
    assert hits >= 180  # 95 % of 200 less three standard deviations of a binomial


def test_the_width_is_that_of_two_way_random_effects() -> None:
    """Rows alone vary: the standard error is row_sd / √rows; the interval is t-wide, or a little more."""
    rng = np.random.default_rng(3)
    values = rng.normal(0, 1, (40, 1)) + np.zeros((1, 40))
    interval = crossed(values, "lights", "seeds")
    expected = 2 * 2.02 * values.std(ddof=1) / np.sqrt(40)
    assert interval.high - interval.low == pytest.approx(expected, rel=0.1)


def test_few_lights_fall_back_to_seeds_and_say_so() -> None:
    values = np.random.default_rng(4).normal(0, 1, (MIN_UNITS - 1, 10))
    assert crossed(values, "lights", "seeds").unit == "seeds"


def test_a_pair_that_never_differs_is_certainly_zero() -> None:
    same = crossed(np.zeros((9, 10)), "lights", "seeds", paired=True)
    assert (same.value, same.low, same.high) == (0.0, 0.0, 0.0)


def test_too_few_changed_lights_give_no_interval() -> None:
    values = np.zeros((9, 10))
    values[:3] = 1.0
    few = crossed(values, "lights", "seeds", paired=True)
    assert not few.has_interval and "3 of 9" in few.note


def test_nothing_measured_is_said() -> None:
    assert crossed(np.full((9, 10), np.nan), "lights", "seeds").note == "nothing to measure"
