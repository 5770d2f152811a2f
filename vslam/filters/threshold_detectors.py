"""Two rules of thumb that detect highlights: mean + 2.5 standard deviations, and the intensity ratio."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from vslam.errors import VslamError
from vslam.filters.detection import Detection
from vslam.filters.registry import register

# vslam.filters.stages is imported where a filter is built, not here: see vslam.filters.seed


@register(
    "mean_sd",
    summary="detects pixels whose smallest channel exceeds the mean by 2.5 standard deviations; inpaints",
    source="rule of thumb on the smallest channel (cf. Shen & Cai 2009); repair: Telea 2004",
)
@dataclass(frozen=True)
class MeanSd(Detection):
    """Detection by an outlier rule on I_min = min_c I_c of the recorded values.

    It assumes that highlights are few and that nothing else is as white.

    Attributes
    ----------
    deviations : float
        How many standard deviations above the mean of the picture.
    """

    name: ClassVar[str] = "mean_sd"
    deviations: float = 2.5

    def __post_init__(self) -> None:
        super().__post_init__()
        if not np.isfinite(self.deviations):
            raise VslamError(f"light filter 'mean_sd': deviations {self.deviations}; give a number")

    def _highlights(self, image: NDArray[np.uint8]) -> tuple[NDArray[np.bool_], NDArray[np.float32]]:
        from vslam.filters.stages.dark_channel import dark_channel

        smallest = dark_channel(image, patch=1)
        mask = smallest > smallest.mean() + self.deviations * smallest.std()
        return mask, smallest.astype(np.float32) / np.float32(255.0)


@register(
    "intensity_ratio",
    summary="detects what shen2013 calls specular; inpaints instead of separating",
    source="Shen & Zheng 2013, Applied Optics 52 (19); repair: Telea 2004",
)
@dataclass(frozen=True)
class IntensityRatio(Detection):
    """Detection by the intensity ratio (`stages.intensity_ratio`), which looks at each pixel in linear light.

    It assumes what `vslam.filters.shen_zheng.Shen2013` does, but nothing of the colour below a highlight.

    Attributes
    ----------
    residue : float
        Grey levels of 255 by which the specular part must change the recorded picture.
    """

    name: ClassVar[str] = "intensity_ratio"
    residue: float = 16.0

    def __post_init__(self) -> None:
        from vslam.filters.stages.intensity_ratio import diffuse_by_intensity_ratio  # noqa: F401
        from vslam.filters.stages.separated import check_levels

        super().__post_init__()
        check_levels(self.name, self.residue)

    def _highlights(self, image: NDArray[np.uint8]) -> tuple[NDArray[np.bool_], NDArray[np.float32]]:
        from vslam.filters.stages.intensity_ratio import diffuse_by_intensity_ratio
        from vslam.filters.stages.separated import separated
        from vslam.filters.stages.srgb import decode

        linear = decode(image)
        parts = separated(linear, diffuse_by_intensity_ratio(linear), self.residue)
        return parts.mask, parts.score
