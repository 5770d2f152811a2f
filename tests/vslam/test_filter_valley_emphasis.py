"""The valley-emphasis threshold (eq. 3-3) by hand, by definition, and against ITK."""

from fractions import Fraction

import numpy as np
import pytest
import SimpleITK
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import binary_dilation

from vslam.filters.stages.light_mask import highlight_free, light_mask
from vslam.filters.stages.valley_emphasis import grey_histogram, valley_emphasis


def histogram(**counts: int) -> np.ndarray:
    """``histogram(_3=5)``: five pixels of level 3."""
    values = np.zeros(256, dtype=np.int64)
    for level, count in counts.items():
        values[int(level[1:])] = count
    return values


def by_definition(counts: np.ndarray) -> dict[int, Fraction]:
    """The criterion of eq. 3-3 in exact fractions, for every t whose two classes exist."""
    total = int(counts.sum())
    values = {}
    for t in range(256):
        if counts[: t + 1].sum() == 0 or counts[t + 1 :].sum() == 0:
            continue
        spread = Fraction(0)
        for levels in (range(t + 1), range(t + 1, 256)):
            n = sum(int(counts[level]) for level in levels)
            mean = Fraction(sum(level * int(counts[level]) for level in levels), n)
            spread += Fraction(n, total) * mean**2
        values[t] = (1 - Fraction(int(counts[t]), total)) * spread
    return values


def test_two_spikes_are_cut_right_above_the_lower_one() -> None:
    # t = 10: (1 − 1/2)(½·10² + ½·200²); t = 11…199: the same spread times (1 − 0), all equal: the first wins
    assert valley_emphasis(histogram(_10=50, _200=50)) == 11


def test_the_emphasis_moves_the_threshold_into_the_valley() -> None:
    # levels 0, 1, 2, 3 with counts 1, 4, 1, 4 (N = 10, Σ level = 18):
    #   t=0: (1 − .1)(.1·0 + .9·(18/9)²)        = .9·3.6      = 3.24
    #   t=1: (1 − .4)(.5·(4/5)² + .5·(14/5)²)   = .6·4.24     = 2.544
    #   t=2: (1 − .1)(.6·(6/6)² + .4·3²)        = .9·4.2      = 3.78   <- largest
    # without the factor (Otsu) t = 1 would win with 4.24
    assert valley_emphasis(histogram(_0=1, _1=4, _2=1, _3=4)) == 2


@pytest.mark.parametrize("level", [0, 1, 128, 255])
def test_a_constant_picture_has_no_threshold_and_an_empty_mask(level: int) -> None:
    dark = np.full((5, 7), level, dtype=np.uint8)
    threshold = valley_emphasis(grey_histogram(dark))
    assert threshold == 255
    assert not light_mask(dark, threshold).any()


def test_an_empty_histogram_has_no_threshold() -> None:
    assert valley_emphasis(np.zeros(256, dtype=np.int64)) == 255


@settings(max_examples=40, deadline=None)
@given(st.dictionaries(st.integers(0, 255), st.integers(1, 1000), min_size=1, max_size=12))
def test_equals_the_definition_in_exact_fractions(counts: dict[int, int]) -> None:
    values = np.zeros(256, dtype=np.int64)
    for level, count in counts.items():
        values[level] = count
    expected = by_definition(values)
    if not expected:
        assert valley_emphasis(values) == 255
    else:
        # two far-apart t may tie exactly, where float64 is free to take either
        reached, best = expected[valley_emphasis(values)], max(expected.values())
        assert float(reached) == pytest.approx(float(best), rel=1e-12)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(0, 255), min_size=2, max_size=60).filter(lambda v: len(set(v)) > 1))
def test_a_threshold_always_separates_something(levels: list[int]) -> None:
    dark = np.array([levels], dtype=np.uint8)
    mask = light_mask(dark, valley_emphasis(grey_histogram(dark)))
    assert mask.any()
    assert not mask.all()


def itk_threshold(grey: np.ndarray) -> int:
    """The last grey level of ITK's lower class.

    ITK spreads 256 bins over the values that occur; where 0 and 255 occur, bin t holds grey level t alone.
    It reports the upper edge of the last bin of the lower class, (t + 1) · 255/256.
    """
    itk = SimpleITK.OtsuMultipleThresholdsImageFilter()
    itk.SetNumberOfThresholds(1)
    itk.SetNumberOfHistogramBins(256)
    itk.SetValleyEmphasis(True)
    itk.Execute(SimpleITK.GetImageFromArray(grey))
    return round(itk.GetThresholds()[0] * 256 / 255) - 1


@pytest.mark.parametrize("seed", range(12))
def test_agrees_with_itk(seed: int) -> None:
    # ITK's class means are of bin centres, (level + ½) · 255/256. The criterion is not invariant to that
    # shift, so where two levels tie to some 1e-6 ITK may take the other; these pictures have a clear valley
    rng = np.random.default_rng(seed)
    low, high = rng.uniform(20, 90), rng.uniform(130, 230)
    share = rng.uniform(0.1, 0.9)
    spread = rng.uniform(5, 25)
    bright = rng.random(120 * 160) < share
    grey = np.where(bright, high, low) + rng.normal(0, spread, bright.size)
    grey = np.clip(np.rint(grey), 0, 255).astype(np.uint8).reshape(120, 160)
    grey[0, :2] = 0, 255
    assert abs(valley_emphasis(grey_histogram(grey)) - itk_threshold(grey)) <= 1


def test_the_ring_that_erosion_cuts_off_is_not_highlight_free() -> None:
    mask = np.zeros((30, 30), dtype=bool)
    mask[15, 15] = True
    free = highlight_free(mask, 5)
    expected = np.ones((30, 30), dtype=bool)
    expected[13:18, 13:18] = False
    np.testing.assert_array_equal(free, expected)


@settings(max_examples=60, deadline=None)
@given(
    height=st.integers(1, 23),
    width=st.integers(1, 40),
    patch=st.sampled_from([1, 3, 5, 7, 15, 31]),
    every=st.integers(1, 4),
    density=st.sampled_from([0.0, 0.005, 0.1, 1.0]),
    seed=st.integers(0, 2**32 - 1),
)
def test_the_free_rows_equal_the_dilated_mask(
    height: int, width: int, patch: int, every: int, density: float, seed: int
) -> None:
    mask = np.random.default_rng(seed).random((height, width)) < density
    widened = binary_dilation(mask, np.ones((patch, patch)))
    np.testing.assert_array_equal(highlight_free(mask, patch, every), ~widened[::every])


@given(
    runs=st.lists(st.tuples(st.integers(0, 255), st.integers(1, 20)), min_size=1, max_size=30),
    start=st.integers(0, 9),
)
def test_the_histogram_counts_every_pixel(runs: list[tuple[int, int]], start: int) -> None:
    # runs of one level across, within and beside the eight bytes that are read at once, from any address
    grey = np.concatenate([np.full(length, level, dtype=np.uint8) for level, length in runs])[start:]
    np.testing.assert_array_equal(grey_histogram(grey), np.bincount(grey, minlength=256))
