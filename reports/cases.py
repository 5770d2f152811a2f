"""What a report compares filters in: all that was measured, then parts of it, each with a name."""

from __future__ import annotations

from dataclasses import dataclass

from reports.comparison import Comparison, Condition
from reports.illuminations import illuminations
from reports.run import Run

POOLED = "all illuminations"


@dataclass(frozen=True, eq=False)
class Case:
    """A comparison under one condition, and what it is called."""

    label: str
    comparison: Comparison
    condition: Condition = None


def by_illumination(run: Run, comparison: Comparison) -> tuple[Case, ...]:
    """All illuminations pooled, then each, from dark to bright."""
    lights = (Case(light.label, comparison, light.name) for light in illuminations(run))
    return (Case(POOLED, comparison), *lights)
