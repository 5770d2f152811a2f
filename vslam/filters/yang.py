"""Yang, Wang & Ahuja 2010: bilateral propagation of the maximum diffuse chromaticity."""

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
    "yang2010",
    summary="spreads maximum chromaticity under a bilateral filter, then specular to diffuse",
    source="Yang, Wang & Ahuja 2010, ECCV, eqs. 5 and 10, algorithm 1; bilateral grid of Chen 2007",
)
@dataclass(frozen=True)
class Yang2010(Separation):
    """Separation with a Λmax for each pixel (`stages.bilateral_propagation`).

    It assumes linear light, white-balanced and unclipped; that Λmax is smooth within a surface; and that
    surfaces near each other differ in the colour left when all white is taken out. Grey surfaces, to which
    eq. 3-5 does not apply, stay as they are.

    Attributes
    ----------
    passes : int
        Of the propagation, at most.
    """

    name: ClassVar[str] = "yang2010"
    passes: int = 2

    def __post_init__(self) -> None:
        from vslam.filters.stages.bilateral_propagation import propagated_chromaticity  # noqa: F401

        super().__post_init__()
        if self.passes < 1:
            raise VslamError(f"light filter 'yang2010': passes {self.passes}; give at least 1")

    def _diffuse(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        from vslam.filters.stages.bilateral_propagation import propagated_chromaticity, with_chromaticity

        return with_chromaticity(image, propagated_chromaticity(image, self.passes))
