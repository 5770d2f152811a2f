"""Light composited onto the DLR robot's own pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from bench import study_checks
from bench.filter_choice import FilterChoice, Filters
from bench.illumination_grid import IlluminationGrid
from bench.robot_choice import DiscChoice
from bench.study_model import Study
from bench.study_parts import Positive


class DlrLightStudy(Study):
    """The DLR robot's recorded pictures with light composited onto them (`bench.sequences.dlr_light`).

    ``stride`` takes every so many of the log's steps; ``own_lamps_lm`` is what each of the building's lamps
    had when the pictures were taken, by assumption, and ties the added light to the recorded one.
    """

    sequence: Literal["dlr_light"]
    stride: int = Field(30, ge=1)
    floor_roughness: float = Field(0.25, ge=0.02, le=1)
    own_lamps_lm: Positive = 3000.0
    illuminations: IlluminationGrid = IlluminationGrid.model_validate({})
    highlight_threshold: int = Field(16, ge=1, le=255)
    filters: Filters = (FilterChoice(name="none"),)
    discs: DiscChoice = DiscChoice()

    def check(self, data: Path | None = None) -> None:
        """Refuse unknown names, as `Study.check` says."""
        study_checks.filters(self.filters)

    def reads_data(self) -> bool:
        """It is about recorded data."""
        return True


MODEL = DlrLightStudy
