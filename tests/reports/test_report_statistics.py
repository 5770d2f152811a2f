"""Intervals: cases worked out by hand, and how often they hold the truth."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import t

from reports import statistics as s


def sums_of(values: np.ndarray) -> np.ndarray:
    return np.stack([values, np.ones_like(values)])


def test_ratio_is_sum_over_sum_and_not_the_mean_of_ratios() -> None:
    hits, visible = [1.0, 9.0, 0.0, 5.0, 5.0, 5.0], [1.0, 90.0, 1.0, 10.0, 10.0, 10.0]
    assert s.estimate(s.ratio, np.array([hits, visible]), "blocks").value == pytest.approx(25 / 122)


def test_paired_change_that_is_the_same_in_each_unit_has_no_width() -> None:
    base = np.arange(1.0, 9.0)
    ten = np.full(8, 10.0)
    change = s.estimate(s.ratio_change, np.array([base + 1.0, ten, base, ten]), "blocks")
    assert change.value == pytest.approx(0.1)
    assert (change.low, change.high) == pytest.approx((0.1, 0.1))
    assert change.excludes_zero


def test_pairing_removes_what_units_have_in_common() -> None:
    rng = np.random.default_rng(1)
    place = rng.normal(0.0, 5.0, 20)
    ours, base = place + 0.3 + 0.01 * rng.normal(size=20), place
    one = np.ones(20)
    paired = s.estimate(s.ratio_change, np.array([ours, one, base, one]), "seeds")
    alone = s.estimate(s.ratio, sums_of(ours), "seeds")
    assert paired.excludes_zero
    assert (paired.high - paired.low) < 0.01 * (alone.high - alone.low)


def test_six_units_are_the_fewest_a_sign_test_allows() -> None:
    assert s.MIN_UNITS == 6
    assert 2 / 2**s.MIN_UNITS < 1 - s.CONFIDENCE < 2 / 2 ** (s.MIN_UNITS - 1)


def test_too_few_units_get_a_value_and_a_reason_but_no_interval() -> None:
    few = s.estimate(s.ratio, sums_of(np.arange(5.0) + 1.0), "seeds")
    assert few.value == 3.0
    assert not few.has_interval and not few.excludes_zero
    assert few.note == "too few seeds for an interval (5 < 6)"


def test_units_without_measurement_do_not_count() -> None:
    sums = np.array([[1.0, 2, 3, 4, 5, 0, 0], [1.0, 1, 1, 1, 1, 0, 0]])
    assert s.estimate(s.ratio, sums, "seeds").units == 5


def test_nothing_measured_is_nan_and_says_so() -> None:
    nothing = s.estimate(s.ratio, np.zeros((2, 9)), "seeds")
    assert math.isnan(nothing.value) and nothing.note == "nothing to measure"


def test_a_few_changed_units_among_many_are_not_called_certain() -> None:
    """Five of forty blocks changed, all upwards: a sign test says p = 0.06, and no interval is given."""
    ours, ten = np.full(40, 5.0), np.full(40, 10.0)
    ours[:5] += 1.0
    sums = np.array([ours, ten, np.full(40, 5.0), ten])
    few = s.estimate(s.ratio_change, sums, "blocks", ours != 5.0)
    assert few.value == pytest.approx(5 / 400)
    assert few.note == "only 5 of 40 blocks changed, too few for an interval"
    assert s.estimate(s.ratio_change, sums, "blocks").excludes_zero  # what the plain bootstrap would say


def test_no_changed_unit_is_no_change_at_all() -> None:
    five, ten = np.full(40, 5.0), np.full(40, 10.0)
    same = s.estimate(s.ratio_change, np.array([five, ten, five, ten]), "blocks", np.zeros(40, bool))
    assert same.value == same.low == same.high == 0.0


def test_interval_of_a_mean_is_as_wide_as_students_t() -> None:
    values = np.random.default_rng(2).normal(size=12)
    got = s.estimate(s.ratio, sums_of(values), "seeds")
    half = t.ppf(0.975, 11) * values.std(ddof=1) / math.sqrt(12)
    assert (got.high - got.low) / 2 == pytest.approx(half, rel=0.15)


def test_intervals_hold_the_truth_about_as_often_as_they_say() -> None:
    """300 samples of 8 normal values; ±3 standard errors of a 95 % proportion is 0.912 … 0.988."""
    rng = np.random.default_rng(3)
    held = 0
    for _ in range(300):
        got = s.estimate(s.ratio, sums_of(rng.normal(1.0, 1.0, 8)), "seeds")
        held += got.low <= 1.0 <= got.high
    assert 0.912 <= held / 300 <= 0.988


def test_same_numbers_same_interval() -> None:
    sums = sums_of(np.random.default_rng(4).normal(size=30))
    assert s.estimate(s.ratio, sums, "seeds") == s.estimate(s.ratio, sums, "seeds")


def test_decibels_pool_errors() -> None:
    """20 dB and 40 dB together: mean error (0.01 + 0.0001)/2, so 22.97 dB, not 30."""
    error, count = np.array([0.01 + 0.0001]), np.array([2.0])
    assert s.decibel(error, count)[0] == pytest.approx(22.967, abs=1e-3)
    assert s.decibel_change(np.array([0.001]), np.array([0.01]))[0] == pytest.approx(10.0)
