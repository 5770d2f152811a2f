"""Pictures as they come, and the forms that filters want: decoding, white balance, and the way back.

White balance is a camera's: gains of at least 1, clipped at 1, so that what the sensor clipped stays white.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from vslam.filters.base import Encoding, PictureCalibration, PictureForm

# vslam.filters.stages.srgb is imported where it is needed: it brings numba (see vslam.filters.seed)

_FULL = {np.dtype(np.uint8): 255, np.dtype(np.uint16): 65535}


def has_form(picture: NDArray[Any], calibration: PictureCalibration, form: PictureForm) -> bool:
    """Whether a picture of three channels already is what the filter wants."""
    return calibration.balanced and (
        (form is PictureForm.SRGB8 and calibration.encoding is Encoding.SRGB and picture.dtype == np.uint8)
        or (
            form is PictureForm.LINEAR
            and calibration.encoding is Encoding.LINEAR
            and picture.dtype == np.float32
        )
    )


def to_form(
    picture: NDArray[Any], calibration: PictureCalibration, form: PictureForm
) -> NDArray[np.uint8] | NDArray[np.float32]:
    """Convert a picture into the form that a filter wants.

    Parameters
    ----------
    picture : (..., 3) uint8, uint16, float32 or float64
        Floats in 0…1.
    calibration : PictureCalibration
        Of ``picture``.

    Returns
    -------
    (..., 3) uint8 or float32
        ``picture`` itself where it already has the form.
    """
    if form is PictureForm.SRGB8:
        if calibration.encoding is Encoding.SRGB and calibration.balanced:
            return _as_uint8(picture)
        from vslam.filters.stages.srgb import encode

        return encode(_balanced(picture, calibration))
    return _balanced(picture, calibration)


def from_form(
    values: NDArray[Any], form: PictureForm, calibration: PictureCalibration, dtype: DTypeLike
) -> NDArray[Any]:
    """Convert a filter's answer back into the encoding, white and type of the picture: `to_form` undone.

    Parameters
    ----------
    values : (..., 3) uint8 or float32
        In ``form``.
    dtype : uint8, uint16, float32 or float64

    Returns
    -------
    (..., 3) of ``dtype``
    """
    if form is PictureForm.SRGB8:
        if calibration.encoding is Encoding.SRGB and calibration.balanced:
            return _quantised(values / 255.0, dtype)
        from vslam.filters.stages.srgb import decode

        values = decode(values)
    if not calibration.balanced:
        values = values / _gains(calibration)
    if calibration.encoding is Encoding.LINEAR:
        return _quantised(values, dtype)
    from vslam.filters.stages import srgb

    if np.dtype(dtype) == np.uint8:
        return srgb.encode(values)
    return _quantised(srgb.encode_exactly(values), dtype)


def _balanced(picture: NDArray[Any], calibration: PictureCalibration) -> NDArray[np.float32]:
    """Linear light in 0…1 with grey as grey."""
    linear = _linear(picture, calibration.encoding)
    if calibration.balanced:
        return linear
    return np.minimum(linear * _gains(calibration), np.float32(1.0))


def _linear(picture: NDArray[Any], encoding: Encoding) -> NDArray[np.float32]:
    if encoding is Encoding.LINEAR:
        return np.asarray(picture / np.float32(_FULL.get(picture.dtype, 1)), dtype=np.float32)
    from vslam.filters.stages import srgb

    if picture.dtype == np.uint8:
        return srgb.decode(picture)
    return srgb.decode_exactly(picture / _FULL.get(picture.dtype, 1)).astype(np.float32)


def _gains(calibration: PictureCalibration) -> NDArray[np.float32]:
    white = np.array(calibration.white)
    return (white.max() / white).astype(np.float32)


def _as_uint8(picture: NDArray[Any]) -> NDArray[np.uint8]:
    if picture.dtype == np.uint8:
        return picture
    return np.rint(picture * (255.0 / _FULL.get(picture.dtype, 1))).astype(np.uint8)


def _quantised(values: NDArray[Any], dtype: DTypeLike) -> NDArray[Any]:
    """0…1 as numbers of a type."""
    full = _FULL.get(np.dtype(dtype))
    if full is None:
        return values.astype(dtype)
    return np.rint(values.astype(np.float64) * full).astype(dtype)
