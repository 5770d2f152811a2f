"""What light and filters do to a robot's detection, position and plans, in several scenes."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from bench import study_checks
from bench.robot_choice import DepthNoise, NavigationTask, OdometryNoise, SlamChoice, TourChoice
from bench.scenes_study import ScenesStudy


class DownstreamStudy(ScenesStudy):
    """Tours of several scenes at the same levels of light: filtered, detected, localised, mapped, planned.

    In each scene it is what a rendered study is in one (`bench.kinds.rendered`).
    """

    sequence: Literal["downstream"]
    tour: TourChoice = TourChoice()
    odometry: OdometryNoise = OdometryNoise()
    depth: DepthNoise = DepthNoise()
    slam: SlamChoice = SlamChoice()
    seeds: int = Field(10, ge=1)
    navigation: NavigationTask = NavigationTask()

    def check(self, data: Path | None = None) -> None:
        """Refuse unknown names, as `Study.check` says."""
        super().check(data)
        study_checks.rendered_slam(self.slam)


MODEL = DownstreamStudy
