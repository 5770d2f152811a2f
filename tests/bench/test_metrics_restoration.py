"""Restoration scores: by hand, against scikit-image, and in the empty and perfect cases."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

from bench.errors import BenchError
from bench.metrics.restoration import Target, evaluate, mean_psnr_db, psnr_db, ssim

NOWHERE = np.zeros((24, 32), dtype=bool)


def picture(seed: int, height: int = 24, width: int = 32) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)


def reference_ssim(one: np.ndarray, other: np.ndarray, data_range: float = 255.0) -> float:
    return structural_similarity(
        one,
        other,
        gaussian_weights=True,
        sigma=1.5,
        use_sample_covariance=False,
        data_range=data_range,
        channel_axis=-1,
    )


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    height=st.integers(11, 30),
    width=st.integers(11, 30),
    noise=st.sampled_from([0.6, 5.0, 60.0]),
    level=st.sampled_from([0, 4, 128, 250, 255]),
)
def test_agrees_with_scikit_image(seed: int, height: int, width: int, noise: float, level: int) -> None:
    # around one level, so flat dark and flat bright pictures are among them: there variances nearly cancel
    rng = np.random.default_rng(seed)
    one, other = (
        np.clip(np.rint(rng.normal(level, noise, (height, width, 3))), 0, 255).astype(np.uint8) for _ in "ab"
    )
    found = evaluate(one, other, np.ones((height, width), dtype=bool))
    assert found.ssim == pytest.approx(reference_ssim(one, other), abs=1e-9)
    if (one != other).any():
        expected = peak_signal_noise_ratio(other, one, data_range=255)
        assert found.psnr_db == pytest.approx(expected, abs=1e-9)
        assert found.psnr_in_mask_db == pytest.approx(expected, abs=1e-9)


def test_golden_values_of_flat_pictures() -> None:
    # 110 against 100: MSE = 100. No variance: SSIM is its luminance term,
    # (2 · 110 · 100 + C1) / (110² + 100² + C1) with C1 = (0.01 · 255)²
    found = evaluate(
        np.full((24, 32, 3), 110, dtype=np.uint8), np.full((24, 32, 3), 100, dtype=np.uint8), ~NOWHERE
    )
    assert found.psnr_db == found.psnr_in_mask_db
    assert found.psnr_db == pytest.approx(28.130803608679, abs=1e-12)
    assert found.ssim == pytest.approx((22000 + 2.55**2) / (22100 + 2.55**2), abs=1e-12)


def test_the_mask_picks_the_pixels() -> None:
    target = picture(0) // 2
    one = target.copy()
    mask = NOWHERE.copy()
    mask[3:6, 4:9] = True
    one[mask] += 7  # MSE 49 inside, 0 outside
    one[20, 20, 1] += 50
    found = evaluate(one, target, mask)
    assert found.psnr_in_mask_db == pytest.approx(10 * math.log10(255**2 / 49), abs=1e-12)
    assert found.psnr_db == pytest.approx(
        10 * math.log10(255**2 * 24 * 32 * 3 / (15 * 3 * 49 + 2500)), abs=1e-12
    )


def test_the_target_itself_is_perfect() -> None:
    found = evaluate(picture(1), picture(1), ~NOWHERE)
    assert found.psnr_db == found.psnr_in_mask_db == math.inf
    assert found.ssim == pytest.approx(1.0, abs=1e-12)


def test_an_empty_mask_has_no_score_inside() -> None:
    found = evaluate(picture(2), picture(3), NOWHERE)
    assert math.isnan(found.psnr_in_mask_db)
    assert math.isfinite(found.psnr_db)


def test_a_shared_target_gives_the_same_numbers() -> None:
    target, mask = picture(4), picture(5)[..., 0] > 128
    shared = Target(target)
    for seed in (6, 7):
        assert evaluate(picture(seed), shared, mask) == evaluate(picture(seed), target, mask)


def test_memory_layout_does_not_matter() -> None:
    one, target, mask = picture(8), picture(9), picture(10)[..., 0] > 128
    for a in (one, target, mask):
        a.flags.writeable = False
    view = (slice(None, None, -1), slice(None, None, 2))
    found = evaluate(one[view], target[view], mask[view])
    assert found == evaluate(one[view].copy(), target[view].copy(), mask[view].copy())


def test_data_range_scales_the_decibels() -> None:
    one, target = picture(11) // 4, picture(12) // 4
    wide, narrow = evaluate(one, target, ~NOWHERE, 255), evaluate(one, target, ~NOWHERE, 63)
    assert wide.psnr_db - narrow.psnr_db == pytest.approx(20 * math.log10(255 / 63), abs=1e-9)
    assert ssim(one, Target(target), 63) == pytest.approx(reference_ssim(one, target, 63), abs=1e-9)


def test_mean_psnr_is_that_of_all_pictures_seen_as_one() -> None:
    # MSE 100 and 0 have the mean 50; NaN (an empty mask) is left out
    mean = mean_psnr_db([psnr_db(100.0), math.inf, math.nan])
    assert mean == pytest.approx(psnr_db(50.0), abs=1e-12)
    assert mean_psnr_db([math.inf, math.inf]) == math.inf
    assert math.isnan(mean_psnr_db([math.nan]))
    assert math.isnan(mean_psnr_db([]))


@pytest.mark.parametrize(
    ("one", "target", "mask", "data_range", "message"),
    [
        (picture(0).astype(np.float32), picture(1), NOWHERE, 255, "repaired"),
        (picture(0)[..., 0], picture(1), NOWHERE, 255, "repaired"),
        (picture(0), picture(1)[:, :, :2], NOWHERE, 255, "target"),
        (picture(0, 10, 32), picture(1, 10, 32), NOWHERE[:10], 255, "11"),
        (picture(0), picture(1, 32, 24), NOWHERE, 255, "its target"),
        (picture(0), picture(1), NOWHERE.T, 255, "mask"),
        (picture(0), picture(1), NOWHERE.astype(np.uint8), 255, "mask"),
        (picture(0), picture(1), NOWHERE, 0, "data_range"),
        (picture(0), picture(1), NOWHERE, math.nan, "data_range"),
    ],
)
def test_malformed_input_is_refused(
    one: np.ndarray, target: np.ndarray, mask: np.ndarray, data_range: float, message: str
) -> None:
    with pytest.raises(BenchError, match=message) as caught:
        evaluate(one, target, mask, data_range)
    assert "\n" not in str(caught.value)
