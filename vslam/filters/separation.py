"""What filters that separate a picture into diffuse and specular light have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from vslam.filters.base import Filtered, PictureForm, check_picture

# vslam.filters.stages is imported where a filter is built, not here: see vslam.filters.seed


@dataclass(frozen=True)
class Separation(ABC):
    """A filter that takes the specular part away from linear light, where it is seen (`stages.separated`).

    Attributes
    ----------
    residue : float
        Grey levels of 255 by which the specular part must change the recorded picture to be masked; 16 is
        what the suite's ground truth calls a highlight.

    Raises
    ------
    VslamError
        When a parameter has no meaning.
    """

    name: ClassVar[str]
    wants: ClassVar[PictureForm] = PictureForm.LINEAR
    residue: float = field(default=16.0, kw_only=True)

    def __post_init__(self) -> None:
        from vslam.filters.stages.separated import check_levels

        check_levels(self.name, self.residue)

    def __call__(self, image: NDArray[np.float32]) -> Filtered:
        """Separate."""
        from vslam.filters.stages.separated import separated

        check_picture(image, self.wants)
        return separated(image, self._diffuse(image), self.residue)

    @abstractmethod
    def _diffuse(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        """The diffuse part of linear light, (H, W, 3), 0…1."""
