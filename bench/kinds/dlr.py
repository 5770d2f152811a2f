"""The replay of the DLR log."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from bench import study_checks
from bench.backend_choice import BackendChoice, Backends
from bench.study_model import Study
from bench.study_parts import Name


class DlrStudy(Study):
    """The real DLR building log, replayed with every back-end, association and observation form."""

    sequence: Literal["dlr"]
    backends: Backends = (BackendChoice(name="ekf"),)
    associations: tuple[Name, ...] = Field(("annotated", "icnn"), min_length=1)
    observations: tuple[Name, ...] = Field(("cartesian", "range_bearing"), min_length=1)
    gate: Annotated[float, Field(gt=0, lt=1)] = 0.99

    def check(self, data: Path | None = None) -> None:
        """Refuse unknown names, as `Study.check` says."""
        study_checks.backends(self.backends, product(self.associations, self.observations))

    def reads_data(self) -> bool:
        """It is about recorded data."""
        return True


MODEL = DlrStudy
