"""Shen & Cai 2009: modified specular-free picture."""

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
    "shen2009",
    summary="takes the smallest channel above an offset, scaled at the rim of the largest highlight",
    source="Shen & Cai 2009, Applied Optics 48 (14), modified specular-free image",
)
@dataclass(frozen=True)
class Shen2009(Separation):
    """Separation by an offset to the smallest channel (`stages.modified_specular_free`).

    It assumes linear light, white-balanced; that diffuse surfaces are saturated or dark enough for their
    smallest channel to stay below the threshold (pale ones are darkened); and that the surface around the
    largest highlight is the one under it.

    Attributes
    ----------
    degree : float
        η of the threshold mean + η standard deviations of the smallest channel.
    """

    name: ClassVar[str] = "shen2009"
    degree: float = 0.5

    def __post_init__(self) -> None:
        from vslam.filters.stages.modified_specular_free import diffuse_by_offset  # noqa: F401

        super().__post_init__()
        if not 0.0 <= self.degree < np.inf:
            raise VslamError(f"light filter 'shen2009': degree {self.degree}; give 0 or more")

    def _diffuse(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        from vslam.filters.stages.modified_specular_free import diffuse_by_offset

        return diffuse_by_offset(image, self.degree)
