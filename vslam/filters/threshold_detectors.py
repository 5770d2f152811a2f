"""Two rules of thumb that detect highlights: mean + 2.5 standard deviations, and the intensity ratio."""

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
    "mean_sd",
    summary="detects pixels whose smallest channel exceeds the mean by 2.5 standard deviations; inpaints",
    source="rule of thumb on the smallest channel (cf. Shen & Cai 2009); repair: Telea 2004",
)
@dataclass(frozen=True)
class MeanSd:
    """Detection by an outlier rule on I_min = min_c I_c of the recorded values.

    It assumes that highlights are few and that nothing else is as white.

    Attributes
    ----------
    deviations : float
        How many standard deviations above the mean of the picture.
    repair : str
        What becomes of the mask: "inpaint" (Telea 2004, OpenCV) or "none".

    Raises
    ------
    VslamError
        When a parameter has no meaning.
    """

    name: ClassVar[str] = "mean_sd"
    wants: ClassVar[PictureForm] = PictureForm.SRGB8
    deviations: float = 2.5
    repair: str = "inpaint"

    def __post_init__(self) -> None:
        from vslam.filters.stages.detected import check_repair

        check_repair(self.name, self.repair)
        if not np.isfinite(self.deviations):
            raise VslamError(f"light filter 'mean_sd': deviations {self.deviations}; give a number")

    def __call__(self, image: NDArray[np.uint8]) -> Filtered:
        """Detect, then repair."""
        from vslam.filters.stages.dark_channel import dark_channel
        from vslam.filters.stages.detected import detected

        check_picture(image)
        smallest = dark_channel(image, patch=1)
        mask = smallest > smallest.mean() + self.deviations * smallest.std()
        return detected(image, mask, smallest.astype(np.float32) / np.float32(255.0), self.repair)


@register(
    "intensity_ratio",
    summary="detects what shen2013 calls specular; inpaints instead of separating",
    source="Shen & Zheng 2013, Applied Optics 52 (19); repair: Telea 2004",
)
@dataclass(frozen=True)
class IntensityRatio:
    """Detection by the intensity ratio (`stages.intensity_ratio`), which looks at each pixel in linear light.

    It assumes what `vslam.filters.shen_zheng.Shen2013` does, but nothing of the colour below a highlight.

    Attributes
    ----------
    residue : float
        Grey levels of 255 by which the specular part must change the recorded picture.
    repair : str
        What becomes of the mask: "inpaint" (Telea 2004, OpenCV) or "none".

    Raises
    ------
    VslamError
        When a parameter has no meaning.
    """

    name: ClassVar[str] = "intensity_ratio"
    wants: ClassVar[PictureForm] = PictureForm.SRGB8
    residue: float = 16.0
    repair: str = "inpaint"

    def __post_init__(self) -> None:
        from vslam.filters.stages.detected import check_repair
        from vslam.filters.stages.intensity_ratio import diffuse_by_intensity_ratio  # noqa: F401
        from vslam.filters.stages.separated import check_levels

        check_repair(self.name, self.repair)
        check_levels(self.name, self.residue)

    def __call__(self, image: NDArray[np.uint8]) -> Filtered:
        """Detect, then repair."""
        from vslam.filters.stages.detected import detected
        from vslam.filters.stages.intensity_ratio import diffuse_by_intensity_ratio
        from vslam.filters.stages.separated import separated
        from vslam.filters.stages.srgb import decode

        check_picture(image)
        linear = decode(image)
        parts = separated(linear, diffuse_by_intensity_ratio(linear), self.residue)
        return detected(image, parts.mask, parts.score, self.repair)
