"""Shen & Zheng 2013, and Yamamoto & Nakazawa 2019, which mends it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from vslam.filters.registry import register
from vslam.filters.separation import Separation

# vslam.filters.stages is imported where a filter is built, not here: see vslam.filters.seed


@register(
    "shen2013",
    summary="clusters pixels by chromaticity; one ratio of largest channel to range each",
    source="Shen & Zheng 2013, Applied Optics 52 (19); clusters and median of Souza et al. 2018, SIBGRAPI",
)
@dataclass(frozen=True)
class Shen2013(Separation):
    """Separation by the intensity ratio of clusters (`stages.intensity_ratio`).

    It assumes linear light, white-balanced; that three colours are enough for the bright part of the picture
    (Souza 2018's number); and that at least half of each cluster's pixels are diffuse. Clusters without
    colour stay as they are.
    """

    name: ClassVar[str] = "shen2013"

    def __post_init__(self) -> None:
        from vslam.filters.stages.intensity_ratio import diffuse_by_intensity_ratio  # noqa: F401

        super().__post_init__()

    def _diffuse(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        from vslam.filters.stages.intensity_ratio import diffuse_by_intensity_ratio

        return diffuse_by_intensity_ratio(image)


@register(
    "yamamoto2019",
    summary="shen2013, its failures found by a high-emphasis filter and taken from similar pixels",
    source="Yamamoto & Nakazawa 2019, ITE Trans. MTA 7 (2), on Shen & Zheng 2013",
)
@dataclass(frozen=True)
class Yamamoto2019(Separation):
    """Separation by `Shen2013` and its correction (`stages.error_correction`).

    It assumes what `Shen2013` does; that a failure is an edge in the diffuse part that the picture lacks; and
    that a pixel of the same look and a better separation lies close by.
    """

    name: ClassVar[str] = "yamamoto2019"

    def __post_init__(self) -> None:
        from vslam.filters.stages.error_correction import corrected  # noqa: F401
        from vslam.filters.stages.intensity_ratio import diffuse_by_intensity_ratio  # noqa: F401

        super().__post_init__()

    def _diffuse(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        from vslam.filters.stages.error_correction import corrected
        from vslam.filters.stages.intensity_ratio import diffuse_by_intensity_ratio

        return corrected(image, diffuse_by_intensity_ratio(image))
