"""Any picture in front of any filter: conversions on the way there and back, and filters that misbehave."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vslam.errors import VslamError
from vslam.filters import Encoding, Filtered, PictureCalibration, PictureForm
from vslam.filters.apply import FilterFailureError, apply

LINEAR = PictureCalibration(Encoding.LINEAR)


class Noting:
    """Notes what it is given, and gives it back times ``factor`` inside ``mask`` (by default everywhere)."""

    name = "noting"

    def __init__(self, wants=PictureForm.SRGB8, factor=1.0, mask=None):
        self.wants, self.factor, self.mask = wants, factor, mask

    def __call__(self, image):
        self.given = image
        mask = np.ones(image.shape[:2], bool) if self.mask is None else self.mask
        changed = (image * self.factor).astype(image.dtype)
        return Filtered(changed, mask, np.zeros(image.shape[:2], np.float32))


def srgb(linear):
    """IEC 61966-2-1 in float64, apart from the room's tables."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def picture(dtype=np.uint8, shape=(5, 7, 3)):
    values = np.random.default_rng(0).random(shape)
    full = {np.uint8: 255, np.uint16: 65535}.get(dtype)
    return np.rint(values * full).astype(dtype) if full else values.astype(dtype)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_a_linear_filter_halves_light_whatever_the_picture_is_written_in(dtype):
    """Half the light of a picture, by the standard's formula: encoded, linear, and under warm light."""
    tolerance = {np.uint8: 0.5 / 255 + 1e-6, np.uint16: 0.5 / 65535 + 1e-6}.get(dtype, 1e-6)
    full = {np.uint8: 255, np.uint16: 65535}.get(dtype, 1)
    # darker than the weakest channel's gain allows, so that white balance clips nothing
    light = (0.5 * np.random.default_rng(1).random((6, 5, 3))).astype(np.float64)
    for calibration, write in (
        (PictureCalibration(), srgb),
        (LINEAR, lambda x: x),
        (PictureCalibration(white=(2.0, 1.6, 1.0)), srgb),
    ):
        recorded = (np.rint(write(light) * full) if full > 1 else write(light)).astype(dtype)
        halved = apply(Noting(PictureForm.LINEAR, 0.5), recorded, calibration).image / full
        decoded = light if full == 1 else None
        if decoded is not None:
            np.testing.assert_allclose(halved, write(0.5 * light), atol=tolerance)
        else:  # half of what was recorded, not of what was meant
            coarse = recorded / full
            linear = coarse if write is not srgb else ((coarse + 0.055) / 1.055) ** 2.4
            linear = np.where(coarse <= 0.04045, coarse / 12.92, linear) if write is srgb else linear
            np.testing.assert_allclose(halved, write(0.5 * linear), atol=tolerance)


def test_white_balance_makes_the_light_neutral_and_keeps_clipped_pixels_white():
    white = np.array([1.0, 0.8, 0.5])
    card = np.stack([0.4 * white, [1.0, 1.0, 1.0]])[None].astype(np.float32)
    light_filter = Noting(PictureForm.LINEAR)
    apply(light_filter, card, PictureCalibration(Encoding.LINEAR, tuple(white)))
    np.testing.assert_allclose(light_filter.given[0, 0], 0.4, rtol=1e-6)
    np.testing.assert_array_equal(light_filter.given[0, 1], 1.0)


@given(st.sampled_from(list(PictureForm)), st.sampled_from([np.uint8, np.uint16, np.float32, np.float64]))
def test_what_a_filter_leaves_alone_keeps_its_bits(form, dtype):
    recorded = picture(dtype)
    for calibration in (PictureCalibration(), LINEAR, PictureCalibration(white=(1.0, 0.7, 0.4))):
        unmasked = Noting(form, 0.25, np.zeros(recorded.shape[:2], bool))
        np.testing.assert_array_equal(apply(unmasked, recorded, calibration).image, recorded)
        if dtype != np.uint8 or form is PictureForm.LINEAR:
            same = apply(Noting(form), recorded, calibration)  # all masked, nothing changed
            np.testing.assert_array_equal(same.image, recorded)


def test_grey_pictures_are_shown_as_equal_channels_and_come_back_grey():
    grey = picture(shape=(4, 6))
    for shape in ((4, 6), (4, 6, 1)):
        light_filter = Noting(factor=0.5)
        result = apply(light_filter, grey.reshape(shape))
        assert light_filter.given.shape == (4, 6, 3)
        np.testing.assert_array_equal(light_filter.given, np.repeat(grey[:, :, None], 3, axis=2))
        np.testing.assert_array_equal(result.image, (grey * 0.5).astype(np.uint8).reshape(shape))


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (np.full((3, 3, 3), np.nan), "NaN or infinity"),
        (np.array([[0.5, np.inf]]), "NaN or infinity"),
        (np.full((3, 3), 1.5), "spans 1.5…1.5"),
        (np.full((3, 3), -0.5, np.float32), "floats in 0…1"),
        (np.zeros((3, 3, 2), np.uint8), r"shape \(3, 3, 2\)"),
        (np.zeros((3, 3, 4), np.uint8), r"shape \(3, 3, 4\)"),
        (np.zeros(5, np.uint8), "shape"),
        (np.zeros((0, 3, 3), np.uint8), "empty"),
        (np.zeros((3, 3), np.int32), "int32"),
        (np.zeros((3, 3), bool), "bool"),
        ([[1, 2]], "list"),
    ],
)
def test_what_is_no_picture_is_refused_in_one_line(bad, words):
    with pytest.raises(VslamError, match=words) as caught:
        apply(Noting(), bad)
    assert "\n" not in str(caught.value)
    assert not isinstance(caught.value, FilterFailureError)  # the picture is to blame, not the filter


def answer(image=None, mask=None, score=None):
    blank = Filtered(np.zeros((5, 7, 3), np.uint8), np.zeros((5, 7), bool), np.zeros((5, 7), np.float32))
    given = {"image": image, "mask": mask, "score": score}
    return Filtered(**(vars(blank) | {k: v for k, v in given.items() if v is not None}))


def _raises(image):
    raise RuntimeError("out of\nluck")


def _writes(image):
    image[0, 0] = 0
    return answer(image)


@pytest.mark.parametrize(
    ("call", "reason"),
    [
        (_raises, "RuntimeError: out of luck"),
        (_writes, "ValueError: assignment destination is read-only"),
        (lambda image: image, "it gave a ndarray, not a Filtered"),
        (lambda image: answer(image[:2]), r"its image has the shape \(2, 7, 3\), not \(5, 7, 3\)"),
        (lambda image: answer(image / 255), "its image is float64, not uint8"),
        (lambda image: answer(image, mask=np.zeros((5, 7), np.uint8)), "its mask is uint8, not bool"),
        (lambda image: answer(image, mask=np.zeros((7, 5), bool)), "its mask has the shape"),
        (lambda image: answer(image, score=np.zeros((5, 7))), "its score is float64, not float32"),
        (lambda image: answer(image, score=np.full((5, 7), 2, np.float32)), "its score spans 2…2, not 0…1"),
        (lambda image: answer(image, score=np.full((5, 7), np.nan, np.float32)), "its score spans nan"),
        (lambda image: answer(image, score=[0]), "its score is a list, not an array"),
    ],
)
def test_a_filter_that_misbehaves_is_named_with_the_reason(call, reason):
    class Plugin:
        name = "plug-in"

        def __call__(self, image):
            return call(image)

    with pytest.raises(FilterFailureError, match=reason) as caught:
        apply(Plugin(), picture())
    assert caught.value.name == "plug-in"
    assert str(caught.value) == f"light filter 'plug-in' failed: {caught.value.reason}"
    assert "\n" not in str(caught.value)
    again = pickle.loads(pickle.dumps(caught.value))  # from a worker process
    assert (again.name, again.reason) == (caught.value.name, caught.value.reason)


@pytest.mark.parametrize("form", list(PictureForm))
def test_what_a_filter_is_given_cannot_be_written_to(form):
    light_filter = Noting(form)
    apply(light_filter, picture())
    with pytest.raises(ValueError, match="read-only"):
        light_filter.given[0, 0] = 0


@pytest.mark.parametrize("value", [np.nan, 1.5, -0.1])
def test_a_linear_answer_out_of_range_is_a_failure(value):
    with pytest.raises(FilterFailureError, match="its image spans"):
        apply(Noting(PictureForm.LINEAR, value / 0.5), np.full((3, 3, 3), 0.5), LINEAR)


def test_a_filter_that_wants_what_does_not_exist_is_a_failure():
    with pytest.raises(FilterFailureError, match="wants 'sRGB' is no PictureForm"):
        apply(Noting("sRGB"), picture())


def test_a_white_point_is_three_positive_numbers():
    for white in ((1, 0, 1), (1, 1), (1, 1, np.nan)):
        with pytest.raises(VslamError, match="no colour"):
            PictureCalibration(white=white)
