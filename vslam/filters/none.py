"""The filter that does nothing: the row that every other filter is held against."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from vslam.filters.base import Filtered, check_picture
from vslam.filters.registry import register


@register("none", summary="does nothing: all-negative mask, picture as recorded", source="baseline")
@dataclass(frozen=True)
class NoFilter:
    """No light filter: finds no highlight (score 0) and repairs nothing."""

    name: ClassVar[str] = "none"

    def __call__(self, image: NDArray[np.uint8]) -> Filtered:
        """Copy the picture and give it an empty mask."""
        check_picture(image)
        shape = image.shape[:2]
        return Filtered(image.copy(), np.zeros(shape, dtype=np.bool_), np.zeros(shape, dtype=np.float32))
