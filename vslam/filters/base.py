"""What every light filter takes and gives."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError


class PictureForm(Enum):
    """The form of picture that a filter takes and gives; `vslam.filters.apply` converts any other into it."""

    SRGB8 = "sRGB, 8 bit"
    """(H, W, 3) uint8, sRGB-encoded RGB, white-balanced."""
    LINEAR = "linear light"
    """(H, W, 3) float32, linear RGB in 0…1 (1 = where the sensor clips), white-balanced."""


class Encoding(Enum):
    """How the numbers of a picture relate to light."""

    SRGB = "sRGB"
    """IEC 61966-2-1: what cameras and image files hold as a rule."""
    LINEAR = "linear"
    """In proportion to light: raw numbers, or a picture that was linearised."""


@dataclass(frozen=True)
class PictureCalibration:
    """What is known of the picture that a filter is to be applied to.

    Attributes
    ----------
    encoding : Encoding
        Of its numbers.
    white : (3,) floats
        Linear RGB, positive, in any unit, that a grey card shows in this picture: the colour Γ of eq. 3-1.
        (1, 1, 1) is a picture that is white-balanced already.

    Raises
    ------
    VslamError
        When ``white`` is not three positive finite numbers.
    """

    encoding: Encoding = Encoding.SRGB
    white: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        if len(self.white) != 3 or not all(0.0 < value < np.inf for value in self.white):
            raise VslamError(
                f"picture calibration: white {self.white} is no colour; give three positive numbers"
            )

    @property
    def balanced(self) -> bool:
        """Whether grey is already grey in the picture."""
        return self.white[0] == self.white[1] == self.white[2]


@dataclass(frozen=True, eq=False)
class Filtered:
    """A picture after the light filter.

    Attributes
    ----------
    image : (H, W, 3), or as the picture was where `vslam.filters.apply` gives it
        The repaired picture, of the shape and type of the input; equal to it outside ``mask``.
    mask : (H, W) bool
        True = affected by light (eq. 3-4). A filter that enhances the whole picture and detects nothing calls
        every pixel affected, with score 0.
    score : (H, W) float32
        Soft evidence of a highlight, 0…1, for metrics that need no threshold.
    """

    image: NDArray[Any]
    mask: NDArray[np.bool_]
    score: NDArray[np.float32]


class LightFilter(Protocol):
    """A light filter: a callable with a name. It neither changes its input nor remembers earlier pictures.

    A class attribute ``wants`` (`PictureForm`) says what picture it takes; a filter without one takes
    `PictureForm.SRGB8`. Callers go through `vslam.filters.apply.apply`, which converts any picture into
    that form and the answer back, and holds the filter to this contract.
    """

    @property
    def name(self) -> str:
        """The name it is registered under."""
        ...

    def __call__(self, image: NDArray[Any]) -> Filtered:
        """Filter one picture.

        Parameters
        ----------
        image : (H, W, 3), uint8 or float32 as ``wants`` says
            RGB, white-balanced by the colour of the light, so that highlights are neutral. From
            `vslam.filters.apply.apply` it is C-contiguous and read-only.

        Returns
        -------
        Filtered
            Its image in the same form: uint8, or finite float32 in 0…1.

        Raises
        ------
        VslamError
            When ``image`` has another shape or type.
        """
        ...


_SHOWN = {
    PictureForm.SRGB8: (np.uint8, "uint8 sRGB"),
    PictureForm.LINEAR: (np.float32, "float32 linear light"),
}


def check_picture(image: NDArray[Any], form: PictureForm = PictureForm.SRGB8) -> None:
    """Refuse what is not a picture of a form.

    Raises
    ------
    VslamError
        When ``image`` is not a non-empty (H, W, 3) array of the form's type.
    """
    dtype, text = _SHOWN[form]
    if not isinstance(image, np.ndarray):
        raise VslamError(
            f"light filter: the picture is a {type(image).__name__}; give an (H, W, 3) array of {text}"
        )
    if image.dtype != dtype or image.ndim != 3 or image.shape[2] != 3 or image.size == 0:
        raise VslamError(f"light filter: the picture is {image.dtype} {image.shape}; give (H, W, 3) {text}")


def wanted_form(light_filter: object) -> PictureForm:
    """The form that a filter, or its class, wants.

    Raises
    ------
    VslamError
        When its ``wants`` is no `PictureForm`.
    """
    form = getattr(light_filter, "wants", PictureForm.SRGB8)
    if not isinstance(form, PictureForm):
        raise VslamError(f"light filter: wants {form!r} is no PictureForm; give PictureForm.SRGB8 or LINEAR")
    return form
