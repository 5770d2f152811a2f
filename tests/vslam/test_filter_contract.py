"""What holds for every registered filter and every kind of picture: hypothesis over all of them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vslam.errors import VslamError
from vslam.filters import Encoding, Filtered, PictureCalibration, create, names, registry
from vslam.filters.apply import apply

TYPES = {np.uint8: 255, np.uint16: 65535, np.float32: 1, np.float64: 1}
CALIBRATIONS = (
    PictureCalibration(),
    PictureCalibration(Encoding.LINEAR),
    PictureCalibration(white=(1.0, 0.8, 0.5)),
)


def check(name: str, picture: np.ndarray, calibration: PictureCalibration = CALIBRATIONS[0]) -> Filtered:
    """Run a filter and check what every filter promises."""
    before = picture.copy()
    light_filter = create(name)
    result, again = (apply(light_filter, picture, calibration) for _ in range(2))
    np.testing.assert_array_equal(picture, before)
    assert (result.image.dtype, result.image.shape) == (picture.dtype, picture.shape)
    assert (result.mask.dtype, result.mask.shape) == (np.bool_, picture.shape[:2])
    assert (result.score.dtype, result.score.shape) == (np.float32, picture.shape[:2])
    assert not np.shares_memory(result.image, picture)
    assert np.isfinite(result.image).all() and np.isfinite(result.score).all()
    assert result.image.min() >= 0 and result.image.max() <= TYPES[picture.dtype.type]
    assert result.score.min() >= 0 and result.score.max() <= 1
    np.testing.assert_array_equal(result.image[~result.mask], picture[~result.mask])
    for one, other in zip(vars(result).values(), vars(again).values(), strict=True):
        np.testing.assert_array_equal(one, other)
    return result


@st.composite
def pictures(draw: st.DrawFn) -> np.ndarray:
    """Pictures of every kind that is allowed: areas of colours, black and saturated ones among them."""
    height, width = draw(st.integers(1, 14)), draw(st.integers(1, 14))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    tiles = rng.random((height, width, draw(st.sampled_from((1, 3)))))
    tiles[rng.random((height, width)) < draw(st.sampled_from((0.0, 0.3, 1.0)))] = draw(
        st.sampled_from((0, 1))
    )
    values = np.kron(tiles, np.ones((draw(st.sampled_from((1, 3))),) * 2 + (1,)))
    dtype = draw(st.sampled_from(tuple(TYPES)))
    full = TYPES[dtype]
    picture = (np.rint(values * full) if full > 1 else values).astype(dtype)
    if picture.shape[2] == 1 and draw(st.booleans()):
        picture = picture[:, :, 0]
    layout = draw(st.sampled_from(("contiguous", "fortran", "flipped", "every second", "read-only")))
    if layout == "fortran":
        return np.asfortranarray(picture)
    if layout == "flipped":
        return picture[::-1, ::-1]
    if layout == "every second":
        return np.repeat(picture, 2, axis=1)[:, ::2]
    picture.flags.writeable = layout == "contiguous"
    return picture


@pytest.mark.parametrize("name", names())
@settings(max_examples=12, deadline=None)
@given(picture=pictures(), calibration=st.sampled_from(CALIBRATIONS))
def test_every_filter_keeps_its_promises(
    name: str, picture: np.ndarray, calibration: PictureCalibration
) -> None:
    check(name, picture, calibration)


@pytest.mark.parametrize("name", names())
@pytest.mark.parametrize("level", [0, 255])
@pytest.mark.parametrize("size", [(1, 1), (1, 9), (24, 32)])
def test_black_white_and_tiny_pictures_are_pictures(name: str, level: int, size: tuple[int, int]) -> None:
    check(name, np.full((*size, 3), level, dtype=np.uint8))


@pytest.mark.parametrize("name", names())
def test_memory_layout_does_not_matter(name: str) -> None:
    picture = np.random.default_rng(1).integers(0, 256, (6, 8, 3), dtype=np.uint8)
    picture = np.kron(picture, np.ones((8, 8, 1), dtype=np.uint8))
    for view in (picture[::-1, ::2], picture.transpose(1, 0, 2), np.asfortranarray(picture)):
        result, expected = check(name, view), check(name, np.ascontiguousarray(view))
        np.testing.assert_array_equal(result.image, expected.image)
        np.testing.assert_array_equal(result.mask, expected.mask)


@pytest.mark.parametrize("name", names())
def test_a_filter_called_directly_refuses_another_form_in_one_line(name: str) -> None:
    for picture in (np.zeros((4, 4), np.uint8), np.zeros((4, 4, 3), np.int32), [[[0, 0, 0]]]):
        with pytest.raises(VslamError) as caught:
            create(name)(picture)
        assert "\n" not in str(caught.value)


def test_a_new_filter_of_the_registry_is_tested_here() -> None:
    # the parameters above are made when this file is read: what is registered must be known by then
    assert names() == tuple(sorted(registry._found()))
