"""The conditions of a rendered study and how they are named."""

from __future__ import annotations

from dataclasses import dataclass

from reports.run import Run


@dataclass(frozen=True, order=True)
class Illumination:
    """One condition, ordered from dark to bright.

    Attributes
    ----------
    sun_lux, bulb_lm : float
        Sun (facing it) in lux, each bulb in lumen.
    name : str
        As stored.
    """

    sun_lux: float
    bulb_lm: float
    name: str

    @property
    def label(self) -> str:
        """For a person: "sun 10 klx, bulbs 800 lm", and the state of the lamps where they do not all burn."""
        levels = f"sun {quantity(self.sun_lux, 'lx')}, bulbs {quantity(self.bulb_lm, 'lm')}"
        _, stands, lamps = self.name.partition(f"-bulb{self.bulb_lm:.10g}-")
        return f"{levels}, lamps {lamps}" if stands else levels


def illuminations(run: Run) -> tuple[Illumination, ...]:
    """All conditions of a run, from dark to bright."""
    rows = run.frames if len(run.frames) else run.runs
    unique = rows[["sun_lux", "bulb_lm", "illumination"]].drop_duplicates()
    return tuple(sorted(Illumination(float(a), float(b), str(c)) for a, b, c in unique.to_numpy()))


def quantity(value: float, unit: str) -> str:
    """A light level in its unit, with k from 1000 on: "0 lx", "800 lm", "97 klx"."""
    return f"{value / 1000:.3g} k{unit}" if value >= 1000 else f"{value:.3g} {unit}"
