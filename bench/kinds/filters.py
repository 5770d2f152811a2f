"""Light filters compared in several scenes."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from bench.scenes_study import ScenesStudy


class FiltersStudy(ScenesStudy):
    """Light filters compared in several scenes at the same levels of light, picture by picture.

    ``frames`` are taken evenly from each tour; ``neutral_objects`` names white and grey surfaces, which a
    filter should leave alone. Filters are timed on pictures of ``timed_sizes``, width and height.
    """

    sequence: Literal["filters"]
    frames: int = Field(6, ge=1)
    neutral_objects: tuple[str, ...] = ()
    timed_sizes: tuple[tuple[Annotated[int, Field(ge=16)], Annotated[int, Field(ge=16)]], ...] = Field(
        ((320, 240), (640, 480), (1280, 720)), min_length=1
    )


MODEL = FiltersStudy
