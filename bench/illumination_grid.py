"""The illuminations of a study: every sun with every bulb and every state of the lamps."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from math import isfinite
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, model_validator

from bench.study_parts import Name, NotNegative, Part, Positive

STEADY = "all"
"""The state of lamps that all burn steadily; it adds nothing to an illumination's name."""


@dataclass(frozen=True)
class Illumination:
    """One cell of the grid.

    Attributes
    ----------
    sun_lux, sky_lux : float
        The sun's lux on a plane facing it, the sky's on open ground.
    bulb_lm : float
        Lumen of each lamp that burns; of a flickering one, the mean over time.
    lamps : str
        Name of the lamps' state.
    without, only : tuple of str
        Lamps that are switched off; the lamps that alone are switched on, all where none is named.
    broken : float
        Share of the scene's lamps that are broken.
    flicker_hz, flicker_depth : float
        Φ(t) = bulb_lm · (1 + depth · cos(2π f t)).
    """

    name: str
    sun_lux: float
    sky_lux: float
    bulb_lm: float
    lamps: str = STEADY
    without: tuple[str, ...] = ()
    only: tuple[str, ...] = ()
    broken: float = 0.0
    flicker_hz: float = 0.0
    flicker_depth: float = 0.0


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
    """

    name: Name
    without: tuple[str, ...] = ()
    only: tuple[str, ...] = ()
    broken: Annotated[float, Field(ge=0, le=1)] = 0.0
    flicker: Flicker | None = None

    @model_validator(mode="before")
    @classmethod
    def _all(cls, value: Any) -> Any:
        return {"name": STEADY} if value == STEADY else value

    @model_validator(mode="after")
    def _says_what_it_is(self) -> Lamps:
        plain = not (self.without or self.only or self.broken or self.flicker)
        if plain != (self.name == STEADY):
            raise ValueError(
                f"{self.name!r} says nothing of its lamps; give it without, only, broken or flicker"
                if plain
                else f"the name {STEADY!r} is kept for lamps that all burn steadily; choose another"
            )
        return self


def _expanded(value: Any) -> Any:
    """A list as it is; ``{log: [low, high], steps: n}`` as n values in equal ratios, rounded to 4 digits."""
    if not isinstance(value, dict):
        return value
    for key in value:
        if key not in ("log", "steps"):
            near = get_close_matches(str(key), ("log", "steps"), n=1, cutoff=0.5)
            raise ValueError(
                f"unknown key {key!r}: {f'did you mean {near[0]!r}?' if near else 'known: log, steps'}"
            )
    ends, steps = value.get("log"), value.get("steps")
    if not (isinstance(ends, list | tuple) and len(ends) == 2 and all(_is_number(e) for e in ends)):
        raise ValueError(f"log should be two numbers, such as [100, 100000], not {ends!r}")
    low, high = (float(e) for e in ends)  # YAML reads 1e5 as text
    if not 0 < low < high < float("inf"):
        raise ValueError(f"log should rise from above 0, not run from {low:g} to {high:g}")
    if not isinstance(steps, int) or isinstance(steps, bool) or not 2 <= steps <= 1000:
        raise ValueError(f"steps should be a whole number from 2 to 1000, not {steps!r}")
    between = (low * (high / low) ** (k / (steps - 1)) for k in range(1, steps - 1))
    return [low, *(float(f"{value:.4g}") for value in between), high]


def _is_number(value: Any) -> bool:
    try:
        return not isinstance(value, bool) and isfinite(float(value))
    except (TypeError, ValueError, OverflowError):
        return False


Expanded = BeforeValidator(_expanded)


class IlluminationGrid(Part):
    """Every sun with every bulb and every state of the lamps.

    ``sun_lux`` and ``bulb_lm`` are lists or log ranges, ``{log: [100, 100000], steps: 4}``.
    ``sky_per_sun`` ties the sky to the sun: 12 klx of diffuse light to 97 klx of direct light on a clear
    day (ASTM G-173 weighted by V(λ)) give 0.124.
    """

    sun_lux: Annotated[tuple[Annotated[float, Field(ge=0, le=200_000)], ...], Expanded] = Field(
        (0.0, 10_000.0, 90_000.0), min_length=1
    )
    bulb_lm: Annotated[tuple[Annotated[float, Field(ge=0, le=1_000_000)], ...], Expanded] = Field(
        (200.0, 800.0, 3200.0), min_length=1
    )
    sky_per_sun: NotNegative = 0.124
    lamps: tuple[Lamps, ...] = Field((Lamps(name=STEADY),), min_length=1)

    @model_validator(mode="after")
    def _distinct(self) -> IlluminationGrid:
        states = [state.name for state in self.lamps]
        for name in states:
            if states.count(name) > 1:
                raise ValueError(f"lamps: the name {name!r} stands twice; give one of them another")
        names = [cell.name for cell in self.grid()]
        if len(set(names)) < len(names):
            raise ValueError("sun_lux and bulb_lm: each value may stand once")
        return self

    def grid(self) -> tuple[Illumination, ...]:
        """All cells, the sun outermost, named like ``sun20000-bulb800`` or ``sun20000-bulb800-broken``."""
        return tuple(
            self._cell(sun, bulb, state)
            for sun in self.sun_lux
            for bulb in self.bulb_lm
            for state in self.lamps
        )

    def _cell(self, sun: float, bulb: float, state: Lamps) -> Illumination:
        suffix = "" if state.name == STEADY else f"-{state.name}"
        return Illumination(
            name=f"sun{sun:.10g}-bulb{bulb:.10g}{suffix}",
            sun_lux=sun,
            sky_lux=sun * self.sky_per_sun,
            bulb_lm=bulb,
            lamps=state.name,
            without=state.without,
            only=state.only,
            broken=state.broken,
            flicker_hz=state.flicker.frequency_hz if state.flicker else 0.0,
            flicker_depth=state.flicker.depth if state.flicker else 0.0,
        )
