"""Tan & Ikeuchi 2005: specular-free picture and iterative logarithmic differentiation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.filters.registry import register
from vslam.filters.separation import Separation

# vslam.filters.stages is imported where a filter is built, not here: see vslam.filters.seed


@register(
    "tan2005",
    summary="lifts maximum chromaticity from neighbour to neighbour where log derivatives differ",
    source="Tan & Ikeuchi 2005, IEEE TPAMI 27 (2), specular-to-diffuse and logarithmic differentiation",
)
@dataclass(frozen=True)
class Tan2005(Separation):
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
    """

    name: ClassVar[str] = "tan2005"
    noise: float = 0.001

    def __post_init__(self) -> None:
        from vslam.filters.stages.logarithmic_differentiation import diffuse_by_differentiation  # noqa: F401

        super().__post_init__()
        if not 0.0 <= self.noise < 1.0:
            raise VslamError(f"light filter 'tan2005': noise {self.noise} is outside 0…1")

    def _diffuse(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        from vslam.filters.stages.logarithmic_differentiation import diffuse_by_differentiation

        return diffuse_by_differentiation(image, self.noise)
