"""Tan & Ikeuchi 2005: specular-free picture and iterative logarithmic differentiation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.filters.base import Filtered, PictureForm, check_picture
from vslam.filters.registry import register

# vslam.filters.stages is imported where a filter is built, not here: see vslam.filters.seed


@register(
    "tan2005",
    summary="lifts maximum chromaticity from neighbour to neighbour where log derivatives differ",
    source="Tan & Ikeuchi 2005, IEEE TPAMI 27 (2), specular-to-diffuse and logarithmic differentiation",
)
@dataclass(frozen=True)
class Tan2005:
    """Separation by comparing the picture with its specular-free form (`stages.logarithmic_differentiation`).

    It assumes linear light, white-balanced, no clipping and no noise; that every surface has a colour and
    shows at least one pixel without highlight; and that chromaticity jumps where a surface ends. One noisy
    pixel of high chromaticity darkens the whole surface around it: on the field's pictures it does worse
    than nothing.

    Attributes
    ----------
    noise : float
        Differences of maximum chromaticity up to this count as none. The paper has 0; its authors' code 0.01,
        which on smooth highlights stops almost everything.
    residue : float
        Grey levels of 255 by which the specular part must change the recorded picture to be masked.

    Raises
    ------
    VslamError
        When a parameter has no meaning.
    """

    name: ClassVar[str] = "tan2005"
    wants: ClassVar[PictureForm] = PictureForm.LINEAR
    noise: float = 0.001
    residue: float = 16.0

    def __post_init__(self) -> None:
        from vslam.filters.stages.logarithmic_differentiation import diffuse_by_differentiation  # noqa: F401
        from vslam.filters.stages.separated import check_levels

        check_levels(self.name, self.residue)
        if not 0.0 <= self.noise < 1.0:
            raise VslamError(f"light filter 'tan2005': noise {self.noise} is outside 0…1")

    def __call__(self, image: NDArray[np.float32]) -> Filtered:
        """Separate."""
        from vslam.filters.stages.logarithmic_differentiation import diffuse_by_differentiation
        from vslam.filters.stages.separated import separated

        check_picture(image, self.wants)
        return separated(image, diffuse_by_differentiation(image, self.noise), self.residue)
