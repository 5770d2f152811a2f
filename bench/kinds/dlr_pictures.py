"""The DLR robot's own pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field, model_validator

from bench import study_checks
from bench.backend_choice import BackendChoice
from bench.filter_choice import FilterChoice, Filters
from bench.robot_choice import DiscChoice, SlamChoice
from bench.study_model import Study


class DlrPicturesStudy(Study):
    """The DLR robot's recorded pictures through the light filters and our detector, then SLAM.

    ``stride`` takes every so many of the log's steps. The camera's mount is calibrated on the pictures 0,
    ``calibrate_every``, 2 · ``calibrate_every`` … (`bench.sequences.dlr_mount`), which no score counts; with
    0, ``camera.json`` stays as it is.
    """

    sequence: Literal["dlr_pictures"]
    stride: int = Field(1, ge=1)
    calibrate_every: int = Field(20, ge=0)
    filters: Filters = (FilterChoice(name="none"),)
    discs: DiscChoice = DiscChoice()
    slam: tuple[SlamChoice, ...] = Field((SlamChoice(association="annotated"),), min_length=1)

    @model_validator(mode="after")
    def _pictures_left(self) -> DlrPicturesStudy:
        if self.calibrate_every and self.stride % self.calibrate_every == 0:
            raise ValueError(
                f"stride {self.stride} takes only pictures that calibrate_every {self.calibrate_every} keeps "
                "from being scored; choose another stride"
            )
        return self

    def check(self, data: Path | None = None) -> None:
        """Refuse unknown names, as `Study.check` says."""
        study_checks.filters(self.filters)
        for choice in self.slam:
            forms = [(choice.association, choice.observation)]
            study_checks.backends([BackendChoice(name=choice.backend)], forms)

    def reads_data(self) -> bool:
        """It is about recorded data."""
        return True


MODEL = DlrPicturesStudy
