"""The plain helpers: what each is known to do, and that none claims to have found light."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from vslam.errors import VslamError
from vslam.filters import create
from vslam.filters.stages.exposure_fusion import fused
from vslam.filters.stages.srgb import decode, encode

ENHANCERS = ("clahe", "exposure_fusion", "gamma", "retinex")


@pytest.mark.parametrize("name", ENHANCERS)
@pytest.mark.parametrize("shape", [(60, 80), (1, 1), (3, 200), (7, 2)])
def test_they_touch_everything_and_detect_nothing(name: str, shape: tuple[int, int]) -> None:
    image = np.random.default_rng(0).integers(0, 256, (*shape, 3), dtype=np.uint8)
    given = decode(image) if name == "exposure_fusion" else image
    result = create(name)(given)
    assert result.mask.all()
    assert not result.score.any()
    assert result.image.shape == given.shape and result.image.dtype == given.dtype
    assert not np.shares_memory(result.image, given)


def test_gamma_is_a_power() -> None:
    image = np.arange(256, dtype=np.uint8).reshape(16, 16, 1).repeat(3, axis=2)
    expected = np.rint(255 * (np.arange(256) / 255) ** 2.2).reshape(16, 16)
    np.testing.assert_array_equal(create("gamma", exponent=2.2)(image).image[..., 1], expected)
    np.testing.assert_array_equal(create("gamma", exponent=1)(image).image, image)


def test_clahe_spreads_a_flat_histogram_and_keeps_grey_grey() -> None:
    image = np.random.default_rng(1).integers(110, 131, (96, 128, 1), dtype=np.uint8).repeat(3, axis=2)
    enhanced = create("clahe", clip=4.0)(image).image
    assert np.ptp(enhanced) > 1.5 * np.ptp(image)
    assert np.ptp(enhanced.astype(int), axis=2).max() <= 1  # L* a* b* and back


def test_retinex_divides_slow_light_out() -> None:
    # a checkerboard under an even light and under one that falls to a fifth: nearly the same afterwards
    rows, columns = np.mgrid[:120, :160]
    paint = np.where((rows // 4 + columns // 4) % 2, 90.0, 200.0)
    light = np.exp(-columns / 100)
    even, falling = (np.rint(p)[..., None].repeat(3, axis=2).astype(np.uint8) for p in (paint, paint * light))

    def difference(a: np.ndarray, b: np.ndarray) -> float:
        return float(np.abs(a.astype(float) - b.astype(float))[:, 20:-20].mean())

    retinex = create("retinex", sigma=15)
    assert difference(retinex(even).image, retinex(falling).image) < 0.2 * difference(even, falling)


def test_the_wide_surround_is_the_gaussian_that_it_stands_for() -> None:
    from scipy.ndimage import gaussian_filter

    from vslam.filters.enhancers import _surround

    rows, columns = np.mgrid[:120, :160]
    levels = (120 + 50 * np.sin(columns / 20) + 50 * np.cos(rows / 15))[..., None].repeat(3, axis=2)
    expected = gaussian_filter(levels, (40, 40, 0), mode="nearest", truncate=4)
    np.testing.assert_allclose(_surround(levels.astype(np.float32), 40.0), expected, rtol=0.05)


@pytest.mark.parametrize("shape", [(48, 64), (31, 77), (1, 5), (2, 3)])
def test_fusion_is_opencvs(shape: tuple[int, int]) -> None:
    small = np.random.default_rng(3).uniform(0, 1, (8, 8, 3)).astype(np.float32)
    picture = cv2.resize(small, shape[::-1], interpolation=cv2.INTER_CUBIC).clip(0, 1)
    bracket = [encode(picture * np.float32(2.0**stop)) for stop in (-2, 0, 2)]
    expected = cv2.createMergeMertens(1.0, 1.0, 1.0).process(bracket)
    # where all weights are nearly 0, their last bits decide
    np.testing.assert_allclose(fused(bracket), expected.clip(0, 1), atol=2e-3)


def test_fusion_lifts_what_is_dark_and_lowers_what_is_bright() -> None:
    picture = np.full((64, 96, 3), 0.01, dtype=np.float32)
    picture[:, 48:] = 0.9
    result = create("exposure_fusion", stops=3)(picture).image
    assert result[:, :40].mean() > 0.015
    assert result[:, 56:].mean() < 0.85
    assert encode(result).max() < 255


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("gamma", {"exponent": 0}),
        ("clahe", {"clip": 0}),
        ("clahe", {"tiles": 0}),
        ("retinex", {"sigma": -1}),
        ("exposure_fusion", {"stops": 0}),
    ],
)
def test_senseless_parameters_are_refused(name: str, parameters: dict[str, float]) -> None:
    with pytest.raises(VslamError, match=next(iter(parameters))):
        create(name, **parameters)
