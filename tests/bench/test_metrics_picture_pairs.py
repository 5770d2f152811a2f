"""Scores of picture pairs: by hand, by brute force, against scikit-image; perfect and malformed input."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from skimage.color import deltaE_ciede2000, rgb2lab
from skimage.metrics import structural_similarity

from bench.errors import BenchError
from bench.metrics.picture_pairs import delta_e, evaluate, lmse, ssim, ssim_volume


def picture(seed: int, height: int = 24, width: int = 32) -> np.ndarray:
    return np.random.default_rng(seed).random((height, width, 3))


def everywhere(image: np.ndarray) -> np.ndarray:
    return np.ones(image.shape[:2], bool)


def test_a_perfect_picture_has_the_best_scores():
    target = picture(0)
    found = evaluate(target.copy(), target, everywhere(target), linear=True)
    assert found.psnr_db == found.psnr_in_mask_db == math.inf
    assert found.ssim == pytest.approx(1.0) and found.ssim_volume == pytest.approx(1.0)
    assert found.lmse == pytest.approx(0.0, abs=1e-12) and found.delta_e == 0.0


def test_golden_values_of_flat_pictures():
    # 0.5 against 0.4: MSE 0.01; no variance, so SSIM is its luminance term; a factor mends all of it
    one, other = np.full((24, 32, 3), 0.5), np.full((24, 32, 3), 0.4)
    found = evaluate(one, other, everywhere(one), linear=True)
    assert found.psnr_db == pytest.approx(20.0, abs=1e-12)
    expected = (2 * 0.2 + 1e-4) / (0.25 + 0.16 + 1e-4)
    assert found.ssim == pytest.approx(expected, abs=1e-12)
    assert found.ssim_volume == pytest.approx(expected, abs=1e-12)
    assert found.lmse == pytest.approx(0.0, abs=1e-12)


def test_the_mask_picks_the_pixels():
    target = np.full((24, 32, 3), 0.25)
    one, mask = target.copy(), np.zeros((24, 32), bool)
    mask[3:6, 4:9] = True
    one[mask] += 0.1
    one[20, 20, 1] += 0.5
    assert evaluate(one, target, mask, True).psnr_in_mask_db == pytest.approx(20.0, abs=1e-9)
    assert math.isnan(evaluate(one, target, np.zeros_like(mask), True).psnr_in_mask_db)


@given(st.integers(0, 1000))
@settings(max_examples=20, deadline=None)
def test_ssim_is_scikit_images(seed):
    one = picture(seed, 20, 17)
    other = np.clip(one + np.random.default_rng(seed + 1).normal(0, 0.1, one.shape), 0, 1)
    kwargs = {"gaussian_weights": True, "sigma": 1.5, "use_sample_covariance": False, "data_range": 1.0}
    expected = structural_similarity(one, other, channel_axis=-1, **kwargs)
    assert ssim(one, other) == pytest.approx(expected, abs=1e-9)


def test_the_volume_form_is_matlabs_definition():
    # one pixel by hand: an 11 × 11 × 11 Gaussian over edge-repeated data
    one, other = picture(1, 5, 4), picture(2, 5, 4)
    bell = np.exp(-0.5 * (np.arange(-5, 6) / 1.5) ** 2)
    weights = np.einsum("i,j,k->ijk", bell, bell, bell) / bell.sum() ** 3
    total = 0.0
    for index in np.ndindex(one.shape):
        i, j, k = (np.clip(np.arange(c - 5, c + 6), 0, n - 1) for c, n in zip(index, one.shape, strict=True))
        x, y = one[np.ix_(i, j, k)], other[np.ix_(i, j, k)]
        mx, my = (weights * x).sum(), (weights * y).sum()
        vx, vy = (weights * x**2).sum() - mx**2, (weights * y**2).sum() - my**2
        cov = (weights * x * y).sum() - mx * my
        total += (2 * mx * my + 1e-4) * (2 * cov + 9e-4) / ((mx**2 + my**2 + 1e-4) * (vx + vy + 9e-4))
    assert ssim_volume(one, other) == pytest.approx(total / one.size, abs=1e-12)


def local_error(target: np.ndarray, estimate: np.ndarray) -> float:
    """Grosse et al. 2009, window by window."""
    left = energy = 0.0
    for r in range(0, target.shape[0] - 20 + 1, 10):
        for c in range(0, target.shape[1] - 20 + 1, 10):
            t, x = (a[r : r + 20, c : c + 20] for a in (target, estimate))
            factor = (t * x).sum() / (x * x).sum()
            left += ((t - factor * x) ** 2).sum()
            energy += (t * t).sum()
    return left / energy


def test_lmse_is_the_definition_window_by_window():
    target, estimate = picture(3, 45, 52), picture(4, 45, 52)
    assert lmse(estimate, target) == pytest.approx(local_error(target, estimate), rel=1e-9)


def test_lmse_of_black_is_one_and_a_factor_costs_nothing():
    target = picture(5, 30, 30)
    assert lmse(np.zeros_like(target), target) == 1.0
    assert lmse(0.5 * target, target) == pytest.approx(0.0, abs=1e-12)
    assert math.isnan(lmse(target, np.zeros_like(target)))


@pytest.mark.parametrize("linear", [True, False])
def test_delta_e_is_scikit_images(linear):
    one, other = picture(6), picture(7)

    def encoded(light):  # IEC 61966-2-1
        return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)

    lab = [rgb2lab(encoded(p) if linear else p) for p in (one, other)]
    assert delta_e(one, other, linear) == pytest.approx(deltaE_ciede2000(*lab).mean(), rel=1e-3)


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (10, 10)])
def test_small_pictures_have_scores(shape):
    one, other = picture(8, *shape), picture(9, *shape)
    found = evaluate(one, other, everywhere(one), linear=True)
    assert math.isnan(found.ssim) and np.isfinite([found.psnr_db, found.lmse, found.ssim_volume]).all()


@pytest.mark.parametrize(
    ("repaired", "mask", "expected"),
    [
        (picture(0).astype(np.float32), None, "float32"),
        (picture(0, 23), None, "target"),
        (picture(0) + 0.5, None, "0…1"),
        (np.full((24, 32, 3), np.nan), None, "nan"),
        (picture(0)[:0], None, "give"),
        (picture(0), np.ones((24, 32)), "mask"),
        (picture(0), np.ones((3, 3), bool), "mask"),
    ],
)
def test_malformed_input_raises(repaired, mask, expected):
    with pytest.raises(BenchError, match=expected):
        evaluate(repaired, picture(1), everywhere(picture(1)) if mask is None else mask, linear=True)
