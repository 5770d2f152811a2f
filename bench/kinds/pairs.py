"""Folders of picture pairs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from bench import study_checks
from bench.filter_choice import FilterChoice, Filters
from bench.study_model import Study


class PairsStudy(Study):
    """A folder of picture pairs (`bench.sequences.pairs`), named by ``--data``, that filters are scored on.

    ``linear`` says that the files hold linear light; otherwise they are sRGB. ``thresholds`` are the grey
    levels of 255 by which a picture has to exceed its diffuse one to count as affected.
    """

    sequence: Literal["pairs"]
    filters: Filters = (FilterChoice(name="none"),)
    linear: bool = False
    thresholds: tuple[Annotated[int, Field(ge=0, le=254)], ...] = Field((8, 16, 32), min_length=1)

    def check(self, data: Path | None = None) -> None:
        """Refuse unknown names, as `Study.check` says."""
        study_checks.filters(self.filters)

    def reads_data(self) -> bool:
        """It is about recorded data."""
        return True


MODEL = PairsStudy
