"""Apply a light filter to any picture, and hold the filter to its contract."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.filters.base import Filtered, LightFilter, PictureCalibration, PictureForm, wanted_form
from vslam.filters.forms import from_form, has_form, to_form

AS_RECORDED = PictureCalibration()
"""sRGB, white-balanced: what the suite's sensor records."""

_TYPES = tuple(np.dtype(t) for t in (np.uint8, np.uint16, np.float32, np.float64))
_LONGEST_REASON = 300  # characters: a reason is a line of a table


class FilterFailureError(VslamError):
    """A filter raised, or its answer breaks the contract of `LightFilter`.

    Attributes
    ----------
    name : str
        Of the filter.
    reason : str
        One line.
    """

    def __init__(self, name: str, reason: str) -> None:
        self.name, self.reason = name, " ".join(reason.split())[:_LONGEST_REASON]
        super().__init__(f"light filter {name!r} failed: {self.reason}")

    def __reduce__(self) -> tuple[type[FilterFailureError], tuple[str, str]]:
        """Pickle by the two parts, for worker processes."""
        return FilterFailureError, (self.name, self.reason)


def apply(
    light_filter: LightFilter, picture: NDArray[Any], calibration: PictureCalibration = AS_RECORDED
) -> Filtered:
    """Filter a picture of any usual kind.

    The filter gets the picture in the form it wants, read-only. Whatever it answers, pixels outside its mask,
    and masked ones whose value it left alone, keep the picture's numbers to the bit: a mask of zero pixels
    changes nothing, and a picture of 16 bits loses nothing where a filter of 8 bits saw no highlight.

    Parameters
    ----------
    light_filter : LightFilter
    picture : (H, W), (H, W, 1) or (H, W, 3); uint8, uint16, float32 or float64
        Floats in 0…1; any memory layout, from one pixel on. Grey is shown to the filter as equal channels,
        and its answer's mean is taken.
    calibration : PictureCalibration
        Encoding and white point of ``picture``; grey pictures have no white point.

    Returns
    -------
    Filtered
        The image has the shape, type and calibration of ``picture``, in new memory.

    Raises
    ------
    VslamError
        When ``picture`` is none of the above, holds NaN or infinity, or leaves 0…1.
    FilterFailureError
        When the filter raises or its answer is not as `LightFilter` says.
    """
    _check(picture)
    if picture.ndim == 2 or picture.shape[2] == 1:
        calibration = PictureCalibration(calibration.encoding)
    form = _form(light_filter)
    given = _given(picture, calibration, form)
    answer = _answer(light_filter, given)
    _check_answer(light_filter, answer, given)
    return Filtered(_merged(picture, given, answer, calibration, form), answer.mask, answer.score)


def name_of(light_filter: object) -> str:
    """The filter's name; that of its class where it has none."""
    return str(getattr(light_filter, "name", type(light_filter).__name__))


def _check(picture: NDArray[Any]) -> None:
    if not isinstance(picture, np.ndarray):
        raise VslamError(f"light filter: the picture is a {type(picture).__name__}; give a NumPy array")
    shape = picture.shape
    if len(shape) not in (2, 3) or (len(shape) == 3 and shape[2] not in (1, 3)):
        raise VslamError(
            f"light filter: the picture has the shape {shape}; give (H, W), (H, W, 1) or (H, W, 3)"
        )
    if picture.size == 0:
        raise VslamError(f"light filter: the picture of shape {shape} is empty; give at least one pixel")
    if picture.dtype not in _TYPES:
        raise VslamError(
            f"light filter: the picture is {picture.dtype}; give uint8, uint16, float32 or float64"
        )
    if picture.dtype.kind == "f":
        low, high = picture.min(), picture.max()
        if not (np.isfinite(low) and np.isfinite(high)):
            raise VslamError("light filter: the picture holds NaN or infinity; give finite numbers in 0…1")
        if low < 0.0 or high > 1.0:
            raise VslamError(f"light filter: the picture spans {low:g}…{high:g}; give floats in 0…1")


def _form(light_filter: LightFilter) -> PictureForm:
    try:
        return wanted_form(light_filter)
    except VslamError as error:
        raise FilterFailureError(name_of(light_filter), str(error).removeprefix("light filter: ")) from None


def _given(picture: NDArray[Any], calibration: PictureCalibration, form: PictureForm) -> NDArray[Any]:
    """(H, W, 3) in the filter's form: contiguous, and read-only, so that writing to it raises."""
    if picture.ndim == 2:
        picture = picture[:, :, None]
    colour = np.broadcast_to(picture, (*picture.shape[:2], 3))
    given = np.ascontiguousarray(to_form(colour, calibration, form)).view()
    given.flags.writeable = False
    return given


def _answer(light_filter: LightFilter, given: NDArray[Any]) -> Filtered:
    try:
        return light_filter(given)
    except FilterFailureError:
        raise
    except Exception as error:
        raise FilterFailureError(name_of(light_filter), f"{type(error).__name__}: {error}") from error


def _check_answer(light_filter: LightFilter, answer: Filtered, given: NDArray[Any]) -> None:
    problem = _problem(answer, given)
    if problem:
        raise FilterFailureError(name_of(light_filter), problem)


def _problem(answer: Filtered, given: NDArray[Any]) -> str:
    """What is wrong with an answer, or nothing."""
    if not isinstance(answer, Filtered):
        return f"it gave a {type(answer).__name__}, not a Filtered"
    size = given.shape[:2]
    wanted = (("image", given.dtype, given.shape), ("mask", np.bool_, size), ("score", np.float32, size))
    for part, dtype, shape in wanted:
        array = getattr(answer, part)
        if not isinstance(array, np.ndarray):
            return f"its {part} is a {type(array).__name__}, not an array"
        if array.shape != shape:
            return f"its {part} has the shape {array.shape}, not {shape}"
        if array.dtype != dtype:
            return f"its {part} is {array.dtype}, not {np.dtype(dtype)}"
    for part in ("image", "score") if given.dtype.kind == "f" else ("score",):
        array = getattr(answer, part)
        low, high = array.min(), array.max()  # NaN where there is one
        if not (low >= 0.0 and high <= 1.0):
            return f"its {part} spans {low:g}…{high:g}, not 0…1"
    return ""


def _merged(
    picture: NDArray[Any],
    given: NDArray[Any],
    answer: Filtered,
    calibration: PictureCalibration,
    form: PictureForm,
) -> NDArray[Any]:
    """The picture with the filter's answer inside the mask."""
    merged = picture.copy(order="C")
    if picture.shape == given.shape and has_form(picture, calibration, form):
        import cv2

        cv2.copyTo(
            np.ascontiguousarray(answer.image), np.ascontiguousarray(answer.mask).view(np.uint8), merged
        )
        return merged
    masked = np.flatnonzero(answer.mask)
    before, after = given.reshape(-1, 3)[masked], answer.image.reshape(-1, 3)[masked]
    changed = (before != after).any(axis=1)
    if not changed.any():
        return merged
    values = from_form(after[changed], form, calibration, picture.dtype)
    flat = merged.reshape(-1, 1 if picture.ndim == 2 else picture.shape[2])
    if flat.shape[1] == 1:
        values = _grey(values)
    flat[masked[changed]] = values
    return merged


def _grey(values: NDArray[Any]) -> NDArray[Any]:
    """The mean of three channels, (n, 1)."""
    mean = values.mean(axis=1, keepdims=True, dtype=np.float64)
    return np.rint(mean) if values.dtype.kind == "u" else mean
