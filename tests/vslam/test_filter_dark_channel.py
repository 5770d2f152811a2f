"""The dark channel (eq. 3-2) against its definition in loops."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vslam.errors import VslamError
from vslam.filters.stages.dark_channel import dark_channel


def by_definition(image: np.ndarray, patch: int) -> np.ndarray:
    height, width, _ = image.shape
    half = patch // 2
    dark = np.zeros((height, width), dtype=np.uint8)
    for row in range(height):
        for column in range(width):
            values = [
                image[y, x, c]
                for y in range(max(row - half, 0), min(row + half + 1, height))
                for x in range(max(column - half, 0), min(column + half + 1, width))
                for c in range(3)
            ]
            dark[row, column] = min(values)
    return dark


@settings(max_examples=25, deadline=None)
@given(
    height=st.integers(1, 9),
    width=st.integers(1, 9),
    patch=st.sampled_from([1, 3, 5, 15]),
    seed=st.integers(0, 2**32 - 1),
)
def test_equals_the_double_loop(height: int, width: int, patch: int, seed: int) -> None:
    image = np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)
    np.testing.assert_array_equal(dark_channel(image, patch), by_definition(image, patch))


def test_one_dark_channel_value_darkens_its_patch_and_nothing_else() -> None:
    image = np.full((40, 40, 3), 200, dtype=np.uint8)
    image[20, 12, 1] = 7
    expected = np.full((40, 40), 200, dtype=np.uint8)
    expected[13:28, 5:20] = 7  # 15 × 15 around (20, 12)
    np.testing.assert_array_equal(dark_channel(image), expected)


@pytest.mark.parametrize("patch", [0, -3, 4])
def test_a_patch_without_a_centre_is_refused(patch: int) -> None:
    with pytest.raises(VslamError, match="odd"):
        dark_channel(np.zeros((4, 4, 3), dtype=np.uint8), patch)
