"""A scene, rendered, filtered, mapped and navigated."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from bench import study_checks
from bench.camera_choice import CameraChoice
from bench.filter_choice import FilterChoice, Filters
from bench.illumination_grid import IlluminationGrid
from bench.robot_choice import DepthNoise, DiscChoice, NavigationTask, OdometryNoise, SlamChoice, TourChoice
from bench.scene_choice import SceneChoice
from bench.sensor_choice import SensorChoice
from bench.study_model import Study
from bench.study_parts import Engine


class RenderedStudy(Study):
    """A scene of the library, rendered, filtered, mapped and navigated."""

    sequence: Literal["rendered"]
    scene: SceneChoice = SceneChoice()
    camera: CameraChoice = CameraChoice.model_validate({})
    engine: Engine = "auto"
    sensor: SensorChoice = SensorChoice.model_validate({})
    illuminations: IlluminationGrid = IlluminationGrid.model_validate({})
    tour: TourChoice = TourChoice()
    odometry: OdometryNoise = OdometryNoise()
    depth: DepthNoise = DepthNoise()
    filters: Filters = (FilterChoice(name="none"),)
    discs: DiscChoice = DiscChoice()
    slam: SlamChoice = SlamChoice()
    seeds: int = Field(10, ge=1)
    navigation: NavigationTask = NavigationTask()

    def check(self, data: Path | None = None) -> None:
        """Refuse unknown names, as `Study.check` says."""
        study_checks.scenes([self.scene])
        study_checks.filters(self.filters)
        study_checks.lights(self)
        study_checks.rendered_slam(self.slam)

    def reads_data(self) -> bool:
        """Whether its scene or camera comes out of the log."""
        return self.camera.source == "dlr" or self.scene.reads_log()


MODEL = RenderedStudy
