"""Meslouhi et al. 2011: highlights of colposcopic pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from vslam.filters.detection import Detection
from vslam.filters.registry import register

# vslam.filters.stages is imported where a filter is built, not here: see vslam.filters.seed


@register(
    "meslouhi2011",
    summary="detects pixels whose luminance exceeds their chromaticity; inpaints",
    source="Meslouhi et al. 2011, Cent. Eur. J. Comp. Sci. 1 (3); repair: Telea 2004",
)
@dataclass(frozen=True)
class Meslouhi2011(Detection):
    """Detection by luminance against chromaticity (`stages.luminance_chromaticity`); the repair is not the
    paper's.

    It assumes the recorded, encoded values and highlights that are nearly white. Whatever is white and
    brighter than a third of the sensor's range is a highlight to it.
    """

    name: ClassVar[str] = "meslouhi2011"

    def __post_init__(self) -> None:
        from vslam.filters.stages.luminance_chromaticity import luminance_over_chromaticity  # noqa: F401

        super().__post_init__()

    def _highlights(self, image: NDArray[np.uint8]) -> tuple[NDArray[np.bool_], NDArray[np.float32]]:
        from vslam.filters.stages.luminance_chromaticity import luminance_over_chromaticity

        excess = luminance_over_chromaticity(image)
        return excess >= 0.0, (excess + np.float32(1.0)) / np.float32(2.0)
