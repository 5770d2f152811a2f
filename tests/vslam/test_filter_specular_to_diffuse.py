"""Eq. 3-5 on pictures made with eq. 3-1, whose diffuse part is known, and the two ways to find Λmax."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vslam.filters.stages.maximum_chromaticity import picture_chromaticity
from vslam.filters.stages.specular_to_diffuse import (
    DARKEST,
    GREY,
    GREY_MARGIN,
    repair_masked,
    specular_to_diffuse,
)
from vslam.filters.stages.srgb import decode, encode

RED = np.array([0.6, 0.25, 0.15])  # diffuse chromaticities, Σ = 1
GREEN = np.array([0.2, 0.5, 0.3])


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_true_chromaticity_gives_the_diffuse_part(seed: int) -> None:
    rng = np.random.default_rng(seed)
    chromaticity = rng.dirichlet([1.0, 1.0, 1.0], size=200)
    chromaticity = chromaticity[chromaticity.max(axis=1) > GREY + 0.01]
    diffuse = rng.uniform(0, 2, (len(chromaticity), 1)) * chromaticity  # m_d Λ
    specular = rng.uniform(0, 1, (len(chromaticity), 1))  # m_s Γ, white: the same in each channel
    found = specular_to_diffuse(diffuse + specular, chromaticity.max(axis=1))
    np.testing.assert_allclose(found, diffuse, rtol=0, atol=1e-12)


def test_by_hand() -> None:
    # I = (0.8, 0.45, 0.35) = (0.6, 0.25, 0.15) + 0.2: (0.8 − 0.6 · 1.6) / (1 − 1.8) = 0.2
    np.testing.assert_allclose(specular_to_diffuse(np.array([[0.8, 0.45, 0.35]]), 0.6), [RED], atol=1e-15)


def test_float32_stays_float32() -> None:
    linear = (RED + 0.2).astype(np.float32)[None]
    found = specular_to_diffuse(linear, 0.6)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, [RED], atol=1e-6)


@pytest.mark.parametrize("lambda_max", [1 / 3, GREY, 0.3, 0.0, float("nan")])
def test_a_grey_or_unknown_surface_is_left_alone(lambda_max: float) -> None:
    linear = np.random.default_rng(0).uniform(0, 1, (50, 3))
    np.testing.assert_array_equal(specular_to_diffuse(linear, lambda_max), linear)


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), lambda_max=st.floats(0.0, 1.0))
def test_repair_stays_between_black_and_the_recorded_value(seed: int, lambda_max: float) -> None:
    linear = np.random.default_rng(seed).uniform(0, 1, (50, 3))
    found = specular_to_diffuse(linear, lambda_max)
    assert (found >= 0).all()
    assert (found <= linear).all()


def test_the_grey_margin_is_one_grey_level_at_the_darkest_usable_level() -> None:
    def shift(level: int) -> float:
        red, green, blue = decode(np.array([level + 1, level, level], dtype=np.uint8)).astype(np.float64)
        return float(red / (red + green + blue)) - 1 / 3

    assert shift(DARKEST) <= GREY_MARGIN < shift(DARKEST - 2)


def test_the_picture_kernel_is_decode_equation_encode() -> None:
    rng = np.random.default_rng(3)
    image = rng.integers(0, 256, (20, 30, 3), dtype=np.uint8)
    mask = rng.random((20, 30)) < 0.5
    lambda_max = rng.uniform(0.3, 1, (20, 30)).astype(np.float32)
    expected = image.copy()
    expected[mask] = encode(specular_to_diffuse(decode(image[mask]), lambda_max[mask]))
    np.testing.assert_array_equal(repair_masked(image, mask, lambda_max), expected)


@pytest.mark.parametrize("size", [(1, 1), (3, 5), (7, 9), (24, 32)])
@pytest.mark.parametrize("share", [0.05, 0.5, 1.0])
def test_one_chromaticity_repairs_the_mask_as_the_equation_says(size: tuple[int, int], share: float) -> None:
    rng = np.random.default_rng(5)
    image = rng.integers(0, 256, (*size, 3), dtype=np.uint8)
    mask = rng.random(size) < share
    repaired = repair_masked(image, mask, 0.5)
    np.testing.assert_array_equal(repaired[~mask], image[~mask])
    linear = decode(image).reshape(-1, 3).astype(np.float64)
    expected = encode(specular_to_diffuse(linear, 0.5).astype(np.float32)).reshape(image.shape)
    # float32 may round to the other side of a boundary between two codes, hardly ever
    difference = np.abs(repaired.astype(int) - expected)[mask]
    assert difference.max(initial=0) <= 1 and (difference > 0).sum() <= 0.002 * difference.size
    no_gloss = mask & (linear.max(axis=1) >= 0.5 * linear.sum(axis=1) + 1e-6).reshape(size)
    np.testing.assert_array_equal(repaired[no_gloss], image[no_gloss])


def painted(chromaticity: np.ndarray, light: np.ndarray) -> np.ndarray:
    """An 8-bit picture of a flat surface: (H, W) light times a chromaticity (3,) or (H, W, 3)."""
    return encode((light[..., None] * chromaticity).astype(np.float32))


def test_one_chromaticity_of_one_surface() -> None:
    light = np.random.default_rng(0).uniform(0.5, 1.2, (60, 60))
    everywhere = np.ones((60, 60), dtype=bool)
    assert picture_chromaticity(painted(RED, light), everywhere) == pytest.approx(0.6, abs=2e-3)


def test_dark_clipped_and_masked_pixels_do_not_count() -> None:
    image = painted(RED, np.full((10, 10), 1.0))
    free = np.ones((10, 10), dtype=bool)
    image[:4] = (DARKEST - 1, 0, 0)
    image[4:7] = (255, 0, 0)
    image[7:9] = (200, 0, 0)
    free[7:9] = False
    assert picture_chromaticity(image, free) == pytest.approx(0.6, abs=2e-3)


@pytest.mark.parametrize("level", [DARKEST, 254])
def test_the_darkest_and_the_brightest_usable_level_count(level: int) -> None:
    image = np.full((5, 9, 3), (level, 0, 0), dtype=np.uint8)
    assert picture_chromaticity(image, np.ones((5, 9), dtype=bool)) == pytest.approx(1.0, abs=2e-3)


def test_without_a_usable_pixel_the_chromaticity_is_unknown() -> None:
    image = painted(RED, np.full((10, 10), 1.0))
    assert np.isnan(picture_chromaticity(image, np.zeros((10, 10), dtype=bool)))
    assert np.isnan(picture_chromaticity(image * 0, np.ones((10, 10), dtype=bool)))


def test_the_quantile_orders_the_surfaces() -> None:
    chromaticity = np.where(np.arange(100)[None, :, None] < 70, RED, GREEN)  # Λmax 0.6 on 70 %, 0.5 on 30 %
    image = painted(chromaticity, np.ones((10, 100)))
    free = np.ones((10, 100), dtype=bool)
    found = [picture_chromaticity(image, free, quantile) for quantile in (0.0, 0.29, 0.31, 1.0)]
    np.testing.assert_allclose(found, [0.5, 0.5, 0.6, 0.6], atol=3e-3)
