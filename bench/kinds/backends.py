"""SLAM back-ends compared on the same drives."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from bench import study_checks
from bench.backend_choice import Backends
from bench.drive_choice import AnyDrive, RenderedDrive
from bench.study_model import Study
from bench.study_parts import Engine, Name, distinct


class BackendsStudy(Study):
    """Back-ends compared on the same observations of known landmarks, simulated or recorded; no pictures.

    ``seeds`` repeats what is random: a simulated drive, or the odometry of a rendered one, never a recorded
    one. ``engine`` renders where a drive has pictures.
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
    engine: Engine = "auto"

    def check(self, data: Path | None = None) -> None:
        """Refuse unknown names, as `Study.check` says."""
        from bench.sequences.toured import rendered

        study_checks.backends(self.backends, [("annotated", self.observation)])
        for drive in self.rendered_drives():
            study_checks.scenes([drive.scene])
            rendered(drive, self.seed, data).check()

    def rendered_drives(self) -> tuple[RenderedDrive, ...]:
        """Those whose pictures have to be rendered."""
        return tuple(drive for drive in self.drives if isinstance(drive, RenderedDrive))

    def reads_log(self) -> bool:
        """Whether a drive is the recorded one, or follows it."""
        return any(drive.source in ("recorded", "virtual") for drive in self.drives)

    def reads_data(self) -> bool:
        """The same, or a rendered drive's scene or camera comes out of the log."""
        of_log = (d.camera.source == "dlr" or d.scene.reads_log() for d in self.rendered_drives())
        return self.reads_log() or any(of_log)


MODEL = BackendsStudy
