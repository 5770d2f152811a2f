"""What people try first: enhancements of the whole picture that look for no highlight.

They call every pixel affected and score none, and say nothing of what is light and what is paint.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.filters.base import Filtered, PictureForm, check_picture
from vslam.filters.registry import register

# OpenCV and vslam.filters.stages are imported where they are needed: see vslam.filters.seed


class Enhancement(ABC):
    """A filter that enhances the whole picture."""

    wants: ClassVar[PictureForm] = PictureForm.SRGB8

    def __call__(self, image: NDArray[Any]) -> Filtered:
        """Enhance."""
        check_picture(image, self.wants)
        shape = image.shape[:2]
        everywhere, nowhere = np.ones(shape, dtype=np.bool_), np.zeros(shape, dtype=np.float32)
        return Filtered(self._enhanced(image), everywhere, nowhere)

    @abstractmethod
    def _enhanced(self, image: NDArray[Any]) -> NDArray[Any]:
        """The enhanced picture, in the form that is wanted."""


@register(
    "clahe",
    summary="evens out local contrast of the lightness; detects nothing",
    source="Zuiderveld 1994, Graphics Gems IV (contrast limited adaptive histogram equalisation); OpenCV",
)
@dataclass(frozen=True)
class Clahe(Enhancement):
    """CLAHE of CIE L*, colours kept.

    Attributes
    ----------
    clip : float
        Clip limit, in multiples of an even histogram's bin.
    tiles : int
        Tiles along each side of the picture.

    Raises
    ------
    VslamError
        When a parameter has no meaning.
    """

    name: ClassVar[str] = "clahe"
    clip: float = 2.0
    tiles: int = 8

    def __post_init__(self) -> None:
        if not self.clip > 0 or self.tiles < 1:
            raise VslamError(f"light filter 'clahe': clip {self.clip}, tiles {self.tiles}; give more than 0")

    def _enhanced(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        import cv2

        lab = cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_RGB2LAB)
        lab[..., 0] = cv2.createCLAHE(self.clip, (self.tiles, self.tiles)).apply(lab[..., 0])
        return np.asarray(cv2.cvtColor(lab, cv2.COLOR_LAB2RGB), dtype=np.uint8)


@register(
    "gamma",
    summary="raises the recorded values to a power; detects nothing",
    source="power law; Gonzalez & Woods, Digital Image Processing, section 3.2",
)
@dataclass(frozen=True)
class Gamma(Enhancement):
    """A power law of the recorded values over 255.

    Attributes
    ----------
    exponent : float
        Above 1 darkens the middle and spreads the bright end, below 1 does the opposite.

    Raises
    ------
    VslamError
        When the exponent is not positive.
    """

    name: ClassVar[str] = "gamma"
    exponent: float = 1.5

    def __post_init__(self) -> None:
        if not 0.0 < self.exponent < np.inf:
            raise VslamError(f"light filter 'gamma': exponent {self.exponent}; give a positive number")

    def _enhanced(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        import cv2

        codes = np.rint(255.0 * (np.arange(256) / 255.0) ** self.exponent).astype(np.uint8)
        return np.asarray(cv2.LUT(np.ascontiguousarray(image), codes), dtype=np.uint8)


@register(
    "retinex",
    summary="divides by a wide blur of the picture (single-scale retinex); detects nothing",
    source="Jobson, Rahman & Woodell 1997, IEEE TIP 6 (3), eq. 1 (centre/surround retinex)",
)
@dataclass(frozen=True)
class Retinex(Enhancement):
    """R = log I − log(F ∗ I) of each channel, F a Gaussian.

    It is shown from 3 standard deviations below its mean to 3 above. It assumes that light changes slowly
    over the picture and paint quickly.

    Attributes
    ----------
    sigma : float
        Of the surround F, pixels; the paper's choice for its pictures is 80.

    Raises
    ------
    VslamError
        When sigma is not positive.
    """

    name: ClassVar[str] = "retinex"
    sigma: float = 80.0

    def __post_init__(self) -> None:
        if not 0.0 < self.sigma < np.inf:
            raise VslamError(f"light filter 'retinex': sigma {self.sigma}; give a positive number")

    def _enhanced(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        levels = image.astype(np.float32) + np.float32(1.0)  # log 0 is none
        response = np.log(levels) - np.log(_surround(levels, self.sigma))
        middle, spread = float(response.mean()), 3.0 * float(response.std())
        if spread < 1e-4:  # nothing to see: a picture of one value
            return image.copy()
        shown = np.clip((response - middle) / (2.0 * spread) + 0.5, 0.0, 1.0)
        return np.rint(255.0 * shown).astype(np.uint8)


@register(
    "exposure_fusion",
    summary="fuses a bracket made from the one picture; detects nothing",
    source="Mertens, Kautz & Van Reeth 2007, Pacific Graphics, eqs. 1 … 4; the bracket is computed",
)
@dataclass(frozen=True)
class ExposureFusion(Enhancement):
    """Exposure fusion of a synthetic bracket: the linear picture times powers of two, clipped and encoded.

    A real bracket would show what lies under clipped highlights. This one has no more light than the one
    picture: it evens out brightness.

    Attributes
    ----------
    stops : float
        Distance of the darker and the brighter picture from the recorded one.

    Raises
    ------
    VslamError
        When the distance is not positive.
    """

    name: ClassVar[str] = "exposure_fusion"
    wants: ClassVar[PictureForm] = PictureForm.LINEAR
    stops: float = 2.0

    def __post_init__(self) -> None:
        from vslam.filters.stages.exposure_fusion import fused  # noqa: F401
        from vslam.filters.stages.srgb import encode  # noqa: F401

        if not 0.0 < self.stops <= 8.0:
            raise VslamError(f"light filter 'exposure_fusion': stops {self.stops} is outside 0…8")

    def _enhanced(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        from vslam.filters.stages.exposure_fusion import fused
        from vslam.filters.stages.srgb import decode_exactly, encode

        bracket = [encode(image * np.float32(2.0**stop)) for stop in (-self.stops, 0.0, self.stops)]
        return decode_exactly(fused(bracket)).astype(np.float32)


def _surround(levels: NDArray[np.float32], sigma: float) -> NDArray[np.float32]:
    """F ∗ levels; a wide Gaussian is computed on a smaller picture, where it looks the same."""
    import cv2

    height, width = levels.shape[:2]
    shrink = max(int(sigma / 8.0), 1)
    small = cv2.resize(
        levels, (max(width // shrink, 1), max(height // shrink, 1)), interpolation=cv2.INTER_AREA
    )
    blurred = cv2.GaussianBlur(small, (0, 0), sigma / shrink, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(cv2.resize(blurred, (width, height), interpolation=cv2.INTER_LINEAR), dtype=np.float32)
