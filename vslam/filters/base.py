"""What every light filter takes and gives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError


@dataclass(frozen=True, eq=False)
class Filtered:
    """A picture after the light filter.

    Attributes
    ----------
    image : (H, W, 3) uint8
        The repaired picture, sRGB-encoded RGB; equal to the input outside ``mask``.
    mask : (H, W) bool
        True = affected by light (eq. 3-4).
    score : (H, W) float32
        Soft evidence of a highlight, 0…1, for metrics that need no threshold.
    """

    image: NDArray[np.uint8]
    mask: NDArray[np.bool_]
    score: NDArray[np.float32]


class LightFilter(Protocol):
    """A light filter: a callable with a name. It neither changes its input nor remembers earlier pictures."""

    @property
    def name(self) -> str:
        """The name it is registered under."""
        ...

    def __call__(self, image: NDArray[np.uint8]) -> Filtered:
        """Filter one picture.

        Parameters
        ----------
        image : (H, W, 3) uint8
            sRGB-encoded RGB, white-balanced by the colour of the light, so that highlights are neutral.

        Raises
        ------
        VslamError
            When ``image`` has another shape or type.
        """
        ...


def check_picture(image: NDArray[np.uint8]) -> None:
    """Refuse what is not a picture.

    Raises
    ------
    VslamError
        When ``image`` is not a non-empty (H, W, 3) array of uint8.
    """
    if not isinstance(image, np.ndarray):
        raise VslamError(
            f"light filter: the picture is a {type(image).__name__}; give an (H, W, 3) uint8 array"
        )
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or image.size == 0:
        raise VslamError(
            f"light filter: the picture is {image.dtype} {image.shape}; give (H, W, 3) uint8 sRGB"
        )
