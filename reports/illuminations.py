"""The conditions of a rendered study and how they are named."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from reports.run import Run, records

STEADY = "all"
"""What a run stores where all lamps burn steadily."""

COLUMNS = ("time", "sun_lux", "bulb_lm", "lamps", "exposure_ev", "illumination")


@dataclass(frozen=True, order=True)
class Illumination:
    """One condition, ordered by time of day and from dark to bright.

    Attributes
    ----------
    time : str
        Time of day, "09:00"; empty where the study has none.
    sun_lux, bulb_lm : float
        Sun (facing it) in lux, each bulb in lumen.
    lamps : str
        Name of the lamps' state.
    exposure_ev : float
        Stops that its pictures are exposed more than metered.
    name : str
        As stored.
    """

    time: str
    sun_lux: float
    bulb_lm: float
    lamps: str
    exposure_ev: float
    name: str

    @property
    def label(self) -> str:
        """For a person: "09:00, sun 68 klx, bulbs 800 lm, lamps broken, −2 EV"; without what is as usual."""
        time = f"{self.time}, " if self.time else ""
        lamps = "" if self.lamps == STEADY else f", lamps {self.lamps}"
        exposure = f", {stops(self.exposure_ev)}" if self.exposure_ev else ""
        return (
            f"{time}sun {quantity(self.sun_lux, 'lx')}, bulbs {quantity(self.bulb_lm, 'lm')}{lamps}{exposure}"
        )

    @property
    def daylight(self) -> tuple[str, float]:
        """Its row in a heat map."""
        return self.time, self.sun_lux

    @property
    def column(self) -> tuple[float, str, float]:
        """Its column in a heat map: lamps and exposure."""
        return self.bulb_lm, self.lamps, self.exposure_ev

    @staticmethod
    def of(row: Mapping[str, Any]) -> Illumination:
        """Of a row of one of the tables."""
        return Illumination(
            str(row["time"]),
            float(row["sun_lux"]),
            float(row["bulb_lm"]),
            str(row["lamps"]),
            float(row["exposure_ev"]),
            str(row["illumination"]),
        )


def illuminations(run: Run) -> tuple[Illumination, ...]:
    """All conditions of a run, by time of day and from dark to bright."""
    rows = run.frames if len(run.frames) else run.runs
    return tuple(sorted(Illumination.of(row) for row in records(rows[list(COLUMNS)].drop_duplicates())))


def weakest_and_strongest(run: Run) -> tuple[Illumination, ...]:
    """The two conditions with the least and the most light, sun before bulbs; one where there is only one."""
    by_light = sorted(illuminations(run), key=lambda light: (light.sun_lux, light.bulb_lm, light.name))
    return tuple(dict.fromkeys((by_light[0], by_light[-1])))


def stops(ev: float) -> str:
    """An exposure against what is metered: "+2 EV", "−0.5 EV", "0 EV"."""
    return f"{ev:+.3g} EV".replace("-", "−") if ev else "0 EV"


def quantity(value: float, unit: str) -> str:
    """A light level in its unit, with k from 1000 on: "0 lx", "800 lm", "97 klx"."""
    return f"{value / 1000:.3g} k{unit}" if value >= 1000 else f"{value:.3g} {unit}"
