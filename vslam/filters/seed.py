"""The dissertation's light filter, eqs. 3-2 … 3-5, with one Λmax per picture or with one per pixel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.filters.base import Filtered, check_picture
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
    """The filter as the dissertation writes it.

    Attributes
    ----------
    patch : int
        Side of the dark channel's patch, pixels, odd.
    quantile : float
        Which quantile of the highlight-free pixels' chromaticity serves as Λmax, 0…1; 0.5 is the median.

    Raises
    ------
    VslamError
        When a parameter has no meaning.
    """

    name: ClassVar[str] = "seed"
    patch: int = 15
    quantile: float = 0.5

    def __post_init__(self) -> None:
        from vslam.filters.stages.dark_channel import check_patch
        from vslam.filters.stages.repair import repair_with_one_chromaticity  # noqa: F401

        check_patch(self.patch)
        if not 0.0 <= self.quantile <= 1.0:
            raise VslamError(f"light filter 'seed': quantile {self.quantile} is outside 0…1")

    def __call__(self, image: NDArray[np.uint8]) -> Filtered:
        """Detect and repair."""
        from vslam.filters.stages.repair import repair_with_one_chromaticity

        check_picture(image)
        return repair_with_one_chromaticity(image, self.patch, self.quantile)


@register(
    "seed_per_pixel",
    summary="dark channel, valley emphasis, specular to diffuse with Λmax filled in per pixel",
    source=_SOURCE
    + "; Λmax by normalised convolution (Knutsson & Westin 1993) on a bilateral grid (Chen 2007)",
)
@dataclass(frozen=True)
class SeedPerPixel:
    """The same detector; Λmax of each pixel comes from the highlight-free pixels of its hue around it.

    Attributes
    ----------
    patch : int
        Side of the dark channel's patch, pixels, odd.

    Raises
    ------
    VslamError
        When the patch has no centre.
    """

    name: ClassVar[str] = "seed_per_pixel"
    patch: int = 15

    def __post_init__(self) -> None:
        from vslam.filters.stages.dark_channel import check_patch
        from vslam.filters.stages.repair import repair_with_chromaticity_map  # noqa: F401

        check_patch(self.patch)

    def __call__(self, image: NDArray[np.uint8]) -> Filtered:
        """Detect and repair."""
        from vslam.filters.stages.repair import repair_with_chromaticity_map

        check_picture(image)
        return repair_with_chromaticity_map(image, self.patch)
