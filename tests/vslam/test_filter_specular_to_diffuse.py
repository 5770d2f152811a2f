"""Eq. 3-5 on pictures made with eq. 3-1, whose diffuse part is known, and the two ways to find Λmax."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vslam.filters.stages.chromaticity_map import chromaticity_map
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


def test_the_map_keeps_surfaces_apart_where_one_number_cannot() -> None:
    # red left of column 80, green right of it; a highlight across the border
    chromaticity = np.where(np.arange(160)[None, :, None] < 80, RED, GREEN)
    light = np.full((120, 160), 0.8)
    highlight = np.zeros((120, 160), dtype=bool)
    highlight[40:80, 50:110] = True
    diffuse = light[..., None] * chromaticity
    image = encode((diffuse + 0.3 * highlight[..., None]).astype(np.float32))
    found = chromaticity_map(image, highlight, ~highlight)
    assert np.isnan(found[~highlight]).all()
    np.testing.assert_allclose(found[40:80, 50:80], 0.6, atol=4e-3)
    np.testing.assert_allclose(found[40:80, 80:110], 0.5, atol=4e-3)
    repaired = decode(repair_masked(image, highlight, found))
    np.testing.assert_allclose(repaired[highlight], diffuse[highlight], atol=0.01)


def test_the_map_reads_the_near_surface_of_a_hue_before_the_far_one() -> None:
    # one hue (red plus white): saturated on the left, pale on the right; a highlight on each
    pale = 0.5 * RED + 0.5 / 3
    chromaticity = np.where(np.arange(320)[None, :, None] < 160, RED, pale)
    mask = np.zeros((64, 320), dtype=bool)
    mask[28:36, 40:48] = mask[28:36, 270:278] = True
    image = encode((0.8 * chromaticity + 0.3 * mask[..., None]).astype(np.float32))
    found = chromaticity_map(image, mask, ~mask)
    np.testing.assert_allclose(found[28:36, 40:48], RED.max(), atol=5e-3)
    np.testing.assert_allclose(found[28:36, 270:278], pale.max(), atol=5e-3)


def test_a_pixel_like_its_surroundings_shows_no_highlight() -> None:
    rng = np.random.default_rng(6)
    image = encode((0.6 * RED * rng.normal(1, 0.05, (80, 80, 3))).astype(np.float32))  # a noisy red wall
    mask = np.zeros((80, 80), dtype=bool)
    mask[20:60, 20:60] = True
    found = chromaticity_map(image, mask, ~mask)
    assert np.isnan(found[mask]).mean() > 0.99  # three standard deviations
    image[30:40, 30:40] = encode((0.6 * RED + 0.3).astype(np.float32))
    np.testing.assert_allclose(chromaticity_map(image, mask, ~mask)[30:40, 30:40], 0.6, atol=0.01)


def test_the_map_knows_nothing_of_grey_pixels_and_of_hues_that_it_never_saw() -> None:
    image = painted(RED, np.ones((40, 40)))
    mask = np.zeros((40, 40), dtype=bool)
    mask[10:20, 10:20] = mask[25:35, 25:35] = True
    image[10:20, 10:20] = 180  # white paint in the mask
    image[25:35, 25:35] = (60, 60, 200)  # blue occurs nowhere else
    assert np.isnan(chromaticity_map(image, mask, ~mask)).all()


def test_white_walls_do_not_turn_black() -> None:
    # a noisy white wall inside the mask, more of it outside, and a red poster: it must stay about as bright
    rng = np.random.default_rng(5)
    light = np.full((120, 160), 1.8)
    chromaticity = np.full((120, 160, 3), 1 / 3)
    chromaticity[90:, :] = RED
    image = painted(chromaticity, light).astype(int)
    image = np.clip(image + np.rint(rng.normal(0, 2, image.shape)), 0, 255).astype(np.uint8)
    mask = np.zeros((120, 160), dtype=bool)
    mask[20:60, 40:120] = True
    repaired = repair_masked(image, mask, chromaticity_map(image, mask, ~mask))
    assert (image[mask] != repaired[mask]).any(axis=1).mean() < 0.01
