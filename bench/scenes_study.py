"""What studies of several scenes share: the scenes, light in proportion to each one's own, one camera."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from bench import study_checks
from bench.camera_choice import CameraChoice
from bench.filter_choice import FilterChoice, Filters
from bench.robot_choice import DiscChoice
from bench.scene_choice import SceneChoice
from bench.sensor_choice import SensorChoice
from bench.study_model import Study
from bench.study_parts import Engine, Name, NotNegative, Part, Split, distinct


class LightLevel(Part):
    """A level of light in proportion to a scene's own: its sun with its sky, and its lamps.

    A warehouse's high bays are no corridor's bulbs: what is common to places is the ratio to what they are
    built with.
    """

    name: Name
    sun: NotNegative = 0.0
    lamps: NotNegative = 0.0

    @model_validator(mode="after")
    def _lit(self) -> LightLevel:
        if not self.sun and not self.lamps:
            raise ValueError("sun or lamps must be above 0; nothing is seen in the dark")
        return self


def _named(scenes: Any) -> Any:
    """A scene of the library by its name alone."""
    if not isinstance(scenes, list | tuple):
        return scenes
    return [{"name": scene} if isinstance(scene, str) else scene for scene in scenes]


class ScenesStudy(Study):
    """Several scenes at the same levels of light (`bench.light_levels`).

    ``split`` is that of every library scene without one of its own.
    """

    scenes: Annotated[tuple[SceneChoice, ...], BeforeValidator(_named), AfterValidator(distinct("name"))] = (
        Field((SceneChoice(),), min_length=1)
    )
    split: Split = "test"
    levels: Annotated[tuple[LightLevel, ...], AfterValidator(distinct("name"))] = Field(
        (LightLevel(name="lamps", lamps=1.0),), min_length=1
    )
    camera: CameraChoice = CameraChoice.model_validate({})
    engine: Engine = "auto"
    sensor: SensorChoice = SensorChoice.model_validate({})
    filters: Filters = (FilterChoice(name="none"),)
    discs: DiscChoice = DiscChoice()

    def check(self, data: Path | None = None) -> None:
        """Refuse unknown names, as `Study.check` says."""
        from bench.light_levels import in_scene

        study_checks.scenes(self.scenes)
        study_checks.filters(self.filters)
        for scene in self.scenes:
            study_checks.lights(in_scene(self, scene, data))

    def reads_data(self) -> bool:
        """Whether a scene or the camera comes out of the log."""
        return self.camera.source == "dlr" or any(scene.reads_log() for scene in self.scenes)
