"""Levels of light that mean the same in every scene: in proportion to the sun and the lamps that it has."""

from __future__ import annotations

from pathlib import Path

from bench import log_parts
from bench.illumination_grid import Illumination, IlluminationGrid
from bench.kinds.rendered import RenderedStudy
from bench.scene_choice import SceneChoice
from bench.scenes_study import LightLevel, ScenesStudy
from bench.sequences import lamps
from bench.sequences.lighting import as_built
from scenes.model import Scene


class LevelGrid(IlluminationGrid):
    """A study's levels as one scene has them, instead of every sun with every bulb."""

    cells: tuple[Illumination, ...]

    def grid(self) -> tuple[Illumination, ...]:
        """The levels, in the study's order."""
        return self.cells


def at_level(level: LightLevel, scene: Scene) -> Illumination:
    """A level in a scene as its builder made it: a dark sun where it has none, its lamps alike.

    The sky follows the sun, in the scene's own ratio; a scene's lamps share the lumen of its middle one.
    """
    own = scene.suns[0].lux if scene.suns else 0.0
    return Illumination(
        name=level.name,
        sun_lux=level.sun * own,
        sky_lux=level.sun * scene.sky.lux,
        bulb_lm=level.lamps * lamps.middle_lumen(scene),
    )


def in_scene(study: ScenesStudy, scene: SceneChoice, data: Path | None = None) -> RenderedStudy:
    """What a study of several scenes renders in one of them: all that a rendered study has too is the same.

    Parameters
    ----------
    data : Path, optional
        The DLR folder from ``--data``, for a scene or camera that needs the log (`bench.log_parts`).
    """
    if scene.file is None and scene.split is None:
        scene = scene.model_copy(update={"split": study.split})
    common = RenderedStudy.model_fields.keys() & type(study).model_fields.keys()
    shared = {key: getattr(study, key) for key in common}
    rendered = RenderedStudy(**(shared | {"sequence": "rendered", "scene": scene}))
    rendered = log_parts.resolved(rendered, data)
    built = as_built(rendered)
    cells = tuple(at_level(level, built) for level in study.levels)
    return rendered.model_copy(update={"illuminations": LevelGrid(sun_lux=(0.0,), cells=cells)})
