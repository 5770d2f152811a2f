"""The detectors against their papers' rules, and what becomes of their masks."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vslam.errors import VslamError
from vslam.filters import create
from vslam.filters.stages.endoscopic_highlights import Thresholds, highlight_evidence, without_bright_areas
from vslam.filters.stages.luminance_chromaticity import luminance_over_chromaticity
from vslam.filters.stages.srgb import decode

DETECTORS = ("arnold2010", "intensity_ratio", "mean_sd", "meslouhi2011")


def disc(radius: float, shape: tuple[int, int] = (120, 160)) -> np.ndarray:
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    return (rows - shape[0] // 2) ** 2 + (columns - shape[1] // 2) ** 2 <= radius**2


def tissue(spot: np.ndarray, level: int = 250) -> np.ndarray:
    image = np.full((*spot.shape, 3), (150, 70, 60), dtype=np.uint8)
    image[spot] = level
    return image


@pytest.mark.parametrize("name", [name for name in DETECTORS if name != "intensity_ratio"])  # white has none
def test_a_white_spot_on_tissue_is_found_and_filled(name: str) -> None:
    spot = disc(5)
    image = tissue(spot)
    result = create(name)(image)
    assert result.mask[spot].all()
    assert not result.mask[~disc(8)].any()
    assert result.score[spot].min() > result.score[~disc(8)].max()
    np.testing.assert_array_equal(result.image[~result.mask], image[~result.mask])
    if name == "arnold2010":  # widened by a pixel, so that no rim of the spot is left to fill from
        np.testing.assert_allclose(result.image, tissue(np.zeros_like(spot)), atol=3)
    left = create(name, repair="none")(image)
    np.testing.assert_array_equal(left.image, image)
    np.testing.assert_array_equal(left.mask, result.mask)


@pytest.mark.parametrize("name", DETECTORS)
def test_an_unknown_repair_is_refused(name: str) -> None:
    with pytest.raises(VslamError, match=r"paint.*inpaint or none"):
        create(name, repair="paint")


# ---- Arnold -----------------------------------------------------------------------------------------------


def test_the_first_module_by_hand() -> None:
    # even colours: each 95th percentile is the level itself, r_GE = 70 / 93 and r_BE = 60 / 93, so all three
    # conditions compare 93 with T1; module 2: τ = 1 (no spread) and the median is the picture itself: 1
    image = tissue(np.zeros((40, 50), dtype=bool))
    grey = 0.2989 * 150 + 0.5870 * 70 + 0.1140 * 60
    evidence = highlight_evidence(image, Thresholds(absolute=100, contrast=2.0))
    np.testing.assert_allclose(evidence, max(round(grey) / 100, 1 / 2), atol=0.005)


def test_the_second_module_finds_what_is_bright_for_its_surroundings() -> None:
    spot = disc(4)
    image = tissue(spot, level=170)  # below both thresholds of module 1
    evidence = highlight_evidence(image, Thresholds())
    mean, deviation = image[..., 2].mean(), image[..., 2].std()
    np.testing.assert_allclose(evidence[spot], 170 / 60 * mean / (mean + deviation), rtol=1e-4)
    assert (evidence[~spot] < 1).all()


def test_large_bright_areas_need_a_steep_contour() -> None:
    # 40 px in radius, 5027 pixels: a soft one rises by 200 levels over 100 px, 2 a pixel; a hard one at once
    rows, columns = np.mgrid[:200, :200]
    distance = np.hypot(rows - 100, columns - 100)
    soft = np.clip(250 - 2 * distance, 0, 255).astype(np.uint8)
    hard = np.where(distance <= 40, 250, 50).astype(np.uint8)
    bright = distance <= 40
    for grey, kept in ((soft, False), (hard, True)):
        image = np.repeat(grey[..., None], 3, axis=2)
        assert without_bright_areas(bright, image, Thresholds(largest=3000)).any() == kept
        assert without_bright_areas(bright, image, Thresholds(largest=6000)).any()


def test_the_mask_grows_by_one_pixel() -> None:
    point = np.zeros((9, 9), dtype=bool)
    point[4, 4] = True
    widened = without_bright_areas(point, np.zeros((9, 9, 3), dtype=np.uint8), Thresholds())
    assert widened.sum() == 5


# ---- Meslouhi ---------------------------------------------------------------------------------------------


def test_grey_is_a_highlight_from_the_luminance_of_its_own_chromaticity_on() -> None:
    # grey keeps its value (s = 1); y of D65 is 0.3290, so the first level with linear value ≥ 0.3290 counts
    levels = np.arange(256, dtype=np.uint8)
    excess = luminance_over_chromaticity(np.repeat(levels[None, :, None], 3, axis=2))[0]
    expected = decode(levels) - np.float32(0.3290)
    np.testing.assert_allclose(excess[1:], expected[1:], atol=2e-4)
    assert excess[0] == -1
    assert np.flatnonzero(excess >= 0)[0] == np.flatnonzero(decode(levels) >= 0.3290)[0] == 156


def test_colour_is_no_highlight_however_bright() -> None:
    colours = np.array([[[255, 120, 0], [0, 255, 255], [255, 60, 60], [120, 255, 120]]], dtype=np.uint8)
    assert (luminance_over_chromaticity(colours) < 0).all()


# ---- the rules of thumb -----------------------------------------------------------------------------------


@given(seed=st.integers(0, 2**32 - 1), deviations=st.floats(-1, 4))
def test_mean_and_deviation(seed: int, deviations: float) -> None:
    image = np.random.default_rng(seed).integers(0, 256, (9, 11, 3), dtype=np.uint8)
    smallest = image.astype(np.float64).min(axis=2)
    threshold = smallest.mean() + deviations * smallest.std()
    result = create("mean_sd", deviations=deviations)(image)
    clear = np.abs(smallest - threshold) > 1e-9
    np.testing.assert_array_equal(result.mask[clear], (smallest > threshold)[clear])


def test_the_intensity_ratio_masks_what_shen_and_zheng_remove() -> None:
    rows, columns = np.mgrid[:120, :160]
    gloss = 0.4 * np.exp(-((rows - 60) ** 2 + (columns - 80) ** 2) / 200)
    linear = (np.array([0.45, 0.3, 0.12]) * np.linspace(0.4, 1, 160)[:, None] + gloss[..., None]).clip(0, 1)
    image = np.rint(255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055))
    image = image.astype(np.uint8)
    found = create("intensity_ratio")(image)
    np.testing.assert_array_equal(found.mask, create("shen2013")(decode(image)).mask)
    assert 0.01 < found.mask.mean() < 0.5
    mask = found.mask.astype(np.uint8)
    np.testing.assert_array_equal(found.image, cv2.inpaint(image, mask, 3, cv2.INPAINT_TELEA))
