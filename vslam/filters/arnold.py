"""Arnold et al. 2010: highlights of endoscopic pictures."""

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
    "arnold2010",
    summary="detects by thresholds balanced for colour and by contrast to a median; inpaints",
    source="Arnold, Ghosh, Ameling & Lacey 2010, EURASIP JIVP 814319, section 2; repair: Telea 2004",
)
@dataclass(frozen=True)
class Arnold2010(Detection):
    """Detection as for endoscopes (`stages.endoscopic_highlights`); the repair is not the paper's.

    It assumes small highlights, nearly as bright as the sensor goes, on a picture of one reddish colour whose
    brightness changes slowly, and the recorded, encoded values. Any small object that is brighter than its
    surroundings is a highlight to it, white discs included.

    Attributes
    ----------
    absolute : float
        T1, grey levels.
    candidate : float
        T2abs, grey levels: brighter regions are painted over before the median.
    contrast : float
        T2rel, over the median of the surroundings.
    window : int
        Side of the median filter, pixels, odd.
    largest : int
        N_min, pixels: larger regions must have a steep contour.
    gradient : float
        T3, grey levels per pixel, of that contour.
    """

    name: ClassVar[str] = "arnold2010"
    absolute: float = 240.0
    candidate: float = 180.0
    contrast: float = 1.0
    window: int = 31
    largest: int = 9000
    gradient: float = 5.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.window < 1 or self.window % 2 == 0:
            raise VslamError(f"light filter 'arnold2010': window {self.window}; give a positive odd number")
        if not min(self.absolute, self.candidate, self.contrast) > 0:
            raise VslamError("light filter 'arnold2010': absolute, candidate and contrast must be above 0")

    def _highlights(self, image: NDArray[np.uint8]) -> tuple[NDArray[np.bool_], NDArray[np.float32]]:
        from vslam.filters.stages import endoscopic_highlights as arnold

        thresholds = arnold.Thresholds(
            self.absolute, self.candidate, self.contrast, self.window, self.largest, self.gradient
        )
        evidence = arnold.highlight_evidence(image, thresholds)
        mask = arnold.without_bright_areas(evidence > 1.0, image, thresholds)
        return mask, evidence / (1.0 + evidence)
