"""The states of a study's lamps: which burn, how steadily, and in what colour."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, model_validator

from bench.study_parts import Illuminant, Name, Part, Positive

STEADY = "all"
"""The state of lamps that all burn steadily; it adds nothing to an illumination's name."""


class Flicker(Part):
    """Lamps that flicker in phase, as on one mains phase, 1 at the tour's first frame.

    ``depth`` is IEEE 1789's modulation depth, (max − min) / (max + min). The factor is taken at a frame's
    stamp: a picture's exposure is taken as short against the period, and a frequency that is a multiple of
    the frame rate looks steady, as it would to such a camera.
    """

    frequency_hz: Positive
    depth: Annotated[float, Field(ge=0, le=1)]


class Lamps(Part):
    """Which lamps burn, and how. A lamp is ``lamp-0``, ``lamp-1``, … in the scene's order, or a group's name.

    ``broken`` of all lamps are broken besides, drawn from the study's seed and this state's name.
    ``illuminant`` gives them another colour: "A", "FL2", "LED-B3", …, or "2700K".
    """

    name: Name
    without: tuple[str, ...] = ()
    only: tuple[str, ...] = ()
    broken: Annotated[float, Field(ge=0, le=1)] = 0.0
    flicker: Flicker | None = None
    illuminant: Illuminant | None = None

    @model_validator(mode="before")
    @classmethod
    def _all(cls, value: Any) -> Any:
        return {"name": STEADY} if value == STEADY else value

    @model_validator(mode="after")
    def _says_what_it_is(self) -> Lamps:
        plain = not (self.without or self.only or self.broken or self.flicker or self.illuminant)
        if plain != (self.name == STEADY):
            raise ValueError(
                f"{self.name!r} says nothing of its lamps; give it without, only, broken, flicker"
                " or illuminant"
                if plain
                else f"the name {STEADY!r} is kept for lamps that all burn steadily; choose another"
            )
        return self
