"""What filters that detect highlights and leave their repair to inpainting have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from vslam.filters.base import Filtered, PictureForm, check_picture

# vslam.filters.stages is imported where a filter is built, not here: see vslam.filters.seed


@dataclass(frozen=True)
class Detection(ABC):
    """A filter that finds highlights in the recorded values and has them painted over (`stages.detected`).

    Attributes
    ----------
    repair : str
        What becomes of the mask: "inpaint" (Telea 2004, OpenCV) or "none".

    Raises
    ------
    VslamError
        When a parameter has no meaning.
    """

    name: ClassVar[str]
    wants: ClassVar[PictureForm] = PictureForm.SRGB8
    repair: str = field(default="inpaint", kw_only=True)

    def __post_init__(self) -> None:
        from vslam.filters.stages.detected import check_repair

        check_repair(self.name, self.repair)

    def __call__(self, image: NDArray[np.uint8]) -> Filtered:
        """Detect, then repair."""
        from vslam.filters.stages.detected import detected

        check_picture(image)
        mask, score = self._highlights(image)
        return detected(image, mask, score, self.repair)

    @abstractmethod
    def _highlights(self, image: NDArray[np.uint8]) -> tuple[NDArray[np.bool_], NDArray[np.float32]]:
        """The mask and the score of a recorded picture, (H, W) each."""
