"""The illuminations of a study: every sun, or time of day, with every bulb, lamps' state and exposure."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, model_validator

from bench.lamp_states import STEADY, Lamps
from bench.study_parts import Illuminant, NotNegative, Part, refuse_unknown
from bench.times_of_day import TimesOfDay, label
from scenes.model import Sun

SKY_PER_SUN = 0.124
"""12 klx of diffuse light to 97 klx of direct light on a clear day (ASTM G-173 weighted by V(λ))."""

SUNS_LUX = (0.0, 10_000.0, 90_000.0)
"""Where a study names neither suns nor times: night, overcast-bright, clear noon."""


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
    time : str
        Time of day, "09:00"; empty where the study names suns by their lux.
    sun : Sun, optional
        Where the sun stands at that time; without it, where the scene's own stands.
    sun_illuminant, sky_illuminant, lamp_illuminant : str
        CIE illuminant or colour temperature; where empty, the scene's own.
    exposure_ev : float
        Stops that its pictures are exposed more (+) or less (−) than metered.
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
    time: str = ""
    sun: Sun | None = None
    sun_illuminant: str = ""
    sky_illuminant: str = ""
    lamp_illuminant: str = ""
    exposure_ev: float = 0.0

    def labels(self) -> dict[str, object]:
        """Its columns in the tables of `bench.schema`."""
        return {
            "illumination": self.name,
            "time": self.time,
            "sun_lux": self.sun_lux,
            "bulb_lm": self.bulb_lm,
            "lamps": self.lamps,
            "exposure_ev": self.exposure_ev,
        }


def _expanded(value: Any) -> Any:
    """A list as it is; ``{log: [low, high], steps: n}`` as n values in equal ratios, rounded to 4 digits."""
    if not isinstance(value, dict):
        return value
    refuse_unknown(value, ("log", "steps"))
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
    """Every sun, or time of day, with every bulb, every state of the lamps and every exposure.

    ``sun_lux`` and ``bulb_lm`` are lists or log ranges, ``{log: [100, 100000], steps: 4}``.
    ``sky_per_sun`` ties the sky to the sun. ``sun_illuminant`` and ``sky_illuminant`` give them another
    colour than the scene's. ``times`` stands for all of these: there sun and sky are a clear day's.
    ``exposure_ev`` brackets: each picture is taken once for each number of stops, by exposure time.
    """

    sun_lux: Annotated[tuple[Annotated[float, Field(ge=0, le=200_000)], ...], Expanded]
    bulb_lm: Annotated[tuple[Annotated[float, Field(ge=0, le=1_000_000)], ...], Expanded] = Field(
        (200.0, 800.0, 3200.0), min_length=1
    )
    sky_per_sun: NotNegative = SKY_PER_SUN
    sun_illuminant: Illuminant | None = None
    sky_illuminant: Illuminant | None = None
    times: TimesOfDay | None = None
    lamps: tuple[Lamps, ...] = Field((Lamps(name=STEADY),), min_length=1)
    exposure_ev: tuple[Annotated[float, Field(ge=-20, le=20)], ...] = Field((0.0,), min_length=1)

    @model_validator(mode="before")
    @classmethod
    def _usual_suns(cls, value: Any) -> Any:
        if not isinstance(value, dict) or "sun_lux" in value:
            return value
        return {**value, "sun_lux": SUNS_LUX if value.get("times") is None else ()}

    @model_validator(mode="after")
    def _suns_or_times(self) -> IlluminationGrid:
        if self.times is None and not self.sun_lux:
            raise ValueError("sun_lux: give at least one value, such as 0 for no sun, or times")
        given = [key for key in ("sun_lux", "sun_illuminant", "sky_illuminant") if getattr(self, key)]
        given += ["sky_per_sun"] * (self.sky_per_sun != SKY_PER_SUN)
        if self.times is not None and given:
            raise ValueError(f"times says where and how bright sun and sky are; leave {given[0]} out")
        return self

    @model_validator(mode="after")
    def _distinct(self) -> IlluminationGrid:
        states = [state.name for state in self.lamps]
        for name in states:
            if states.count(name) > 1:
                raise ValueError(f"lamps: the name {name!r} stands twice; give one of them another")
        for key, unit in (("sun_lux", "lx"), ("bulb_lm", "lm"), ("exposure_ev", "EV")):
            levels = [_level(value) for value in getattr(self, key)]
            for level in levels:
                if levels.count(level) > 1:
                    raise ValueError(f"{key}: {level} {unit} stands twice; each value may stand once")
        bracketed = {_bracketed(_suffix(name), ev) for name in states for ev in self.exposure_ev if ev}
        for name in states:
            if _suffix(name) in bracketed:
                raise ValueError(f"lamps: the name {name!r} reads as an exposure; choose another")
        return self

    def grid(self) -> tuple[Illumination, ...]:
        """All cells, the sun outermost, named like ``sun20000-bulb800``, ``t0900-bulb800-broken-ev-2``."""
        return tuple(
            replace(cell, name=_bracketed(cell.name, ev), exposure_ev=ev)
            for day in (self._days() if self.times is None else self._hours(self.times))
            for bulb in self.bulb_lm
            for cell in (self._with_lamps(day, bulb, state) for state in self.lamps)
            for ev in self.exposure_ev
        )

    def _days(self) -> list[Illumination]:
        """The scene's own sun at each strength, without lamps."""
        return [
            Illumination(
                name=f"sun{_level(lux)}",
                sun_lux=lux,
                sky_lux=lux * self.sky_per_sun,
                bulb_lm=0.0,
                sun_illuminant=self.sun_illuminant or "",
                sky_illuminant=self.sky_illuminant or "",
            )
            for lux in self.sun_lux
        ]

    def _hours(self, times: TimesOfDay) -> list[Illumination]:
        """A clear day's sun at each hour, without lamps."""
        return [
            Illumination(
                name=label(hour.time),
                sun_lux=hour.sun.lux,
                sky_lux=hour.sky.lux,
                bulb_lm=0.0,
                time=hour.time,
                sun=hour.sun,
                sun_illuminant=hour.sun.illuminant,
                sky_illuminant=hour.sky.illuminant,
            )
            for hour in times.daylight()
        ]

    def _with_lamps(self, day: Illumination, bulb: float, state: Lamps) -> Illumination:
        return replace(
            day,
            name=f"{day.name}-bulb{_level(bulb)}{_suffix(state.name)}",
            bulb_lm=bulb,
            lamps=state.name,
            without=state.without,
            only=state.only,
            broken=state.broken,
            flicker_hz=state.flicker.frequency_hz if state.flicker else 0.0,
            flicker_depth=state.flicker.depth if state.flicker else 0.0,
            lamp_illuminant=state.illuminant or "",
        )


def _suffix(state: str) -> str:
    """A state of lamps in names."""
    return "" if state == STEADY else f"-{state}"


def _bracketed(name: str, ev: float) -> str:
    """The name at an exposure; what is metered keeps its own, and so the same picture."""
    return f"{name}-ev{_level(ev)}" if ev else name


def _level(value: float) -> str:
    """A strength of light, or a number of stops, in names."""
    return f"{value + 0.0:.10g}"  # no "-0"
