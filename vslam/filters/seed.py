"""The dissertation's light filter, eqs. 3-2 … 3-5, with every choice that it leaves open as a parameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.filters.base import Filtered, PictureForm, check_picture
from vslam.filters.registry import register

# vslam.filters.stages is imported where a filter is built, not here: it brings numba, which takes longer
# to import than listing the names may take. Its kernels are compiled then, not on the first picture.

_SOURCE = "dissertation, eqs. 3-2 … 3-5 (He 2009, Ng 2006, Tan & Ikeuchi 2005)"


@register(
    "seed",
    summary="dark channel, valley emphasis, specular to diffuse with one Λmax per picture",
    source=_SOURCE,
)
@dataclass(frozen=True)
class Seed:
    """The filter as the dissertation writes it; where it says nothing, the choice is named here.

    It assumes white light, highlights larger than the patch that are brighter in their darkest channel than
    anything else, two classes of dark-channel values, and, with one Λmax per picture, surfaces of one
    chromaticity. White paint is a highlight to it.

    Attributes
    ----------
    patch : int
        Side of the dark channel's patch (eq. 3-2), pixels, odd.
    threshold : str or int
        Of the mask (eq. 3-4): "valley-emphasis" (eq. 3-3), "otsu" (Otsu 1979), or a fixed grey level 0…255.
    chromaticity : str
        Λmax of eq. 3-5: the "maximum" or the "median" of the highlight-free pixels for the whole picture, or
        "per-pixel" by bilateral propagation (Yang 2010).
    linear : bool
        Whether eq. 3-5 is computed in linear light, as it must be to hold, or on the recorded codes.
    passes : int
        Of the propagation, with "per-pixel".

    Raises
    ------
    VslamError
        When a parameter has no meaning.
    """

    name: ClassVar[str] = "seed"
    wants: ClassVar[PictureForm] = PictureForm.SRGB8
    patch: int = 15
    threshold: str | int = "valley-emphasis"
    chromaticity: str = "median"
    linear: bool = True
    passes: int = 2

    def __post_init__(self) -> None:
        from vslam.filters.stages.dark_channel import check_patch
        from vslam.filters.stages.repair import PER_PIXEL, QUANTILES, THRESHOLDS

        check_patch(self.patch)
        if isinstance(self.threshold, str):
            self._check("threshold", self.threshold, tuple(THRESHOLDS), " or a grey level")
        elif isinstance(self.threshold, bool) or not 0 <= self.threshold <= 255:
            raise VslamError(f"light filter {self.name!r}: threshold {self.threshold} is outside 0…255")
        self._check("chromaticity", self.chromaticity, (*QUANTILES, PER_PIXEL))
        if self.passes < 1:
            raise VslamError(f"light filter {self.name!r}: passes {self.passes}; give at least 1")

    def __call__(self, image: NDArray[np.uint8]) -> Filtered:
        """Detect and repair."""
        from vslam.filters.stages.repair import Choices, repair

        check_picture(image)
        return repair(image, Choices(self.patch, self.threshold, self.chromaticity, self.linear, self.passes))

    def _check(self, parameter: str, value: str, known: tuple[str, ...], more: str = "") -> None:
        if value not in known:
            raise VslamError(
                f"light filter {self.name!r}: {parameter} {value!r} is unknown; give {', '.join(known)}{more}"
            )


@register(
    "seed_per_pixel",
    summary="the same with a patch of one pixel and one Λmax per pixel",
    source=_SOURCE + "; Λmax of Yang 2010",
)
@dataclass(frozen=True)
class SeedPerPixel(Seed):
    """The dissertation's filter with the two choices that cost it most made otherwise.

    A patch of one pixel keeps the outline of a highlight, and surfaces may have several colours. It still
    masks white paint, but eq. 3-5 says nothing there and leaves it white.

    Attributes
    ----------
    patch : int
        Side of the dark channel's patch (eq. 3-2), pixels, odd.
    threshold : str or int
        Of the mask, as `Seed` has it.
    chromaticity : str
        Λmax of eq. 3-5, as `Seed` has it.
    linear : bool
        Whether eq. 3-5 is computed in linear light.
    passes : int
        Of the propagation, with "per-pixel".
    """

    name: ClassVar[str] = "seed_per_pixel"
    patch: int = 1
    chromaticity: str = "per-pixel"
