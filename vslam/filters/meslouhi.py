"""Meslouhi et al. 2011: highlights of colposcopic pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from vslam.filters.base import Filtered, PictureForm, check_picture
from vslam.filters.registry import register

# vslam.filters.stages is imported where a filter is built, not here: see vslam.filters.seed


@register(
    "meslouhi2011",
    summary="detects pixels whose luminance exceeds their chromaticity; inpaints",
    source="Meslouhi et al. 2011, Cent. Eur. J. Comp. Sci. 1 (3); repair: Telea 2004",
)
@dataclass(frozen=True)
class Meslouhi2011:
    """Detection by luminance against chromaticity (`stages.luminance_chromaticity`); the repair is not the
    paper's.

    It assumes the recorded, encoded values and highlights that are nearly white. Whatever is white and
    brighter than a third of the sensor's range is a highlight to it.

    Attributes
    ----------
    repair : str
        What becomes of the mask: "inpaint" (Telea 2004, OpenCV) or "none".

    Raises
    ------
    VslamError
        When a parameter has no meaning.
    """

    name: ClassVar[str] = "meslouhi2011"
    wants: ClassVar[PictureForm] = PictureForm.SRGB8
    repair: str = "inpaint"

    def __post_init__(self) -> None:
        from vslam.filters.stages.detected import check_repair
        from vslam.filters.stages.luminance_chromaticity import luminance_over_chromaticity  # noqa: F401

        check_repair(self.name, self.repair)

    def __call__(self, image: NDArray[np.uint8]) -> Filtered:
        """Detect, then repair."""
        from vslam.filters.stages.detected import detected
        from vslam.filters.stages.luminance_chromaticity import luminance_over_chromaticity

        check_picture(image)
        excess = luminance_over_chromaticity(image)
        return detected(image, excess >= 0.0, (excess + np.float32(1.0)) / np.float32(2.0), self.repair)
