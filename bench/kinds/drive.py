"""A robot that drives itself, in closed loop."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from bench.illumination_grid import Illumination
from bench.kinds.rendered import RenderedStudy
from bench.study_parts import Name, Part, Positive


class ClosedLoopTask(Part):
    """What is driven in closed loop, and when the true world calls it a success.

    ``goal``: from a start to a goal at least ``min_distance_m`` away and home again, `NavigationTask.pairs`
    such pairs with `RenderedStudy.seeds` repetitions each. ``explore``: see all free space, from
    ``explorations`` starts. ``lights`` are names of illuminations out of the grid, all where it is empty.
    ``arrival_m``: as near the robot has to be in truth where it believes to have arrived. It gets
    ``patience`` times the time that the shortest way takes at full speed, and ``explore_s`` for exploring.
    """

    tasks: tuple[Literal["goal", "explore"], ...] = Field(("goal", "explore"), min_length=1)
    home: bool = True
    lights: tuple[Name, ...] = ()
    min_distance_m: Positive = 8.0
    explorations: int = Field(2, ge=1)
    arrival_m: Positive = 0.3
    patience: float = Field(4.0, ge=1)
    explore_s: Positive = 180.0
    commands_per_frame: int = Field(4, ge=1, le=100)


class ClosedLoopStudy(RenderedStudy):
    """A robot that drives itself through a rendered scene, its own SLAM pose its only feedback.

    The tour gives its speed and the time between two pictures, nothing else.
    """

    sequence: Literal["drive"]  # type: ignore[assignment]  # another value of the key that tells kinds apart
    drive: ClosedLoopTask = ClosedLoopTask()

    @model_validator(mode="after")
    def _can_be_driven(self) -> ClosedLoopStudy:
        if self.camera.optics.motion_blur:
            raise ValueError("camera.optics.motion_blur: is for tours; leave it out of a drive")
        known = [cell.name for cell in self.illuminations.grid()]
        for name in self.drive.lights:
            if name not in known:
                raise ValueError(f"drive.lights: {name!r} is not in the grid; it has {', '.join(known)}")
        return self

    def lights(self) -> tuple[Illumination, ...]:
        """The illuminations that are driven in."""
        cells, chosen = self.illuminations.grid(), self.drive.lights
        return tuple(cell for cell in cells if not chosen or cell.name in chosen)


MODEL = ClosedLoopStudy
