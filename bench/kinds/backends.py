"""SLAM back-ends compared on the same drives."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from bench import study_checks
from bench.backend_choice import Backends
from bench.drive_choice import AnyDrive
from bench.study_model import Study
from bench.study_parts import Name, distinct


class BackendsStudy(Study):
    """Back-ends compared on the same observations of known landmarks, simulated or recorded; no pictures.

    ``seeds`` repeats what is random: a simulated drive, never a recorded one.
    """

    sequence: Literal["backends"]
    drives: Annotated[
        tuple[Annotated[AnyDrive, Field(discriminator="source")], ...],
        Field(min_length=1),
        AfterValidator(distinct("name")),
    ]
    backends: Backends
    observation: Name = "cartesian"
    seeds: int = Field(10, ge=1)

    def check(self) -> None:
        """Refuse unknown names, as `Study.check` says."""
        study_checks.backends(self.backends, [("annotated", self.observation)])

    def reads_data(self) -> bool:
        """Whether a drive is the recorded one, or follows it."""
        return any(drive.source in ("recorded", "virtual") for drive in self.drives)


MODEL = BackendsStudy
