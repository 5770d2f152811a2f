"""A study's scene with the lights that its illuminations need, and what each illumination makes of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.illumination_grid import Illumination
from bench.kinds.rendered import RenderedStudy
from bench.own_scene import build as own_scene
from bench.rng import generator
from bench.sequences import lamps
from bench.sequences.dlr_drive import drive_log
from renderers.illuminant import linear_srgb
from scenes import library
from scenes.model import Scene, Sun
from scenes.splits import seed_of

FloatArray = NDArray[np.float64]
Colours = dict[str, FloatArray]


def load_scene(study: RenderedStudy) -> Scene:
    """The study's scene with the study's tour, a sun for each time of day, and its lamps in as many layers as
    the study switches.

    Raises
    ------
    BenchError
        If the study switches a lamp that the scene does not have.
    SceneError
        If the scene does not exist, or a parameter of it or of its lamps does not fit.
    """
    scene, cells = as_built(study), study.illuminations.grid()
    states = [lamps.burning(scene, cell, study.seed) for cell in cells]
    return lamps.split(replace(scene, suns=_suns(scene, cells)), states)


def as_built(study: RenderedStudy) -> Scene:
    """The scene with the suns and groups of lamps of its builder; lamps and discs as the study says."""
    scene = own_scene.build(study) if study.scene.file is not None else _of_library(study)
    return lamps.fitted(_with_discs(study, scene), study.scene.lamps)


def _of_library(study: RenderedStudy) -> Scene:
    split, seed = study.scene.split, study.scene.seed
    parameters = {
        "seed": seed if split is None else seed_of(split, seed),
        "speed_mps": study.tour.speed_mps,
        "frame_interval_s": study.tour.frame_interval_s,
        **study.scene.parameters,
    }
    if isinstance(parameters.get("log"), str):
        parameters["log"] = drive_log(Path(parameters["log"]))
    return library.load(study.scene.name, **parameters)


def _with_discs(study: RenderedStudy, scene: Scene) -> Scene:
    """The scene with the study's share of its discs, numbered anew, at least one."""
    if study.scene.disc_share == 1.0:
        return scene
    count = max(1, round(study.scene.disc_share * len(scene.landmarks)))
    order = generator(study.seed, "discs").permutation(len(scene.landmarks))
    left = (scene.landmarks[k] for k in sorted(order[:count]))
    return replace(scene, landmarks=tuple(replace(disc, id=i) for i, disc in enumerate(left)))


def _suns(scene: Scene, cells: Sequence[Illumination]) -> tuple[Sun, ...]:
    """No more suns than illuminations weight: none below the horizon, none that is always dark."""
    shining = [cell for cell in cells if cell.sun_lux > 0]
    suns = [sun for cell in shining for sun in ((cell.sun,) if cell.sun else scene.suns[:1])]
    return tuple(sun for sun in dict.fromkeys(suns) if sun.elevation_deg > 0)


def light_colours(study: RenderedStudy, cache: Path | None = None) -> Colours:
    """The colour of every illuminant of a study, (3,) linear sRGB, luminance-normalised.

    With a ``cache`` folder the answers of colour-science are kept there, as its import takes seconds.

    Raises
    ------
    RendererError
        For an illuminant that does not exist, with near names.
    """
    scene, cells = load_scene(study), study.illuminations.grid()
    own = [scene.sky.illuminant, *(s.illuminant for s in scene.suns), *(b.illuminant for b in scene.bulbs)]
    chosen = [name for c in cells for name in (c.sun_illuminant, c.sky_illuminant, c.lamp_illuminant)]
    return {name: linear_srgb(name, cache) for name in dict.fromkeys([*own, *filter(None, chosen)])}


@dataclass(frozen=True, eq=False)
class Lighting:
    """Weighs the layers of a study's scene.

    Attributes
    ----------
    scene : Scene
        Of `load_scene`.
    colours : dict of illuminant to (3,) float64
        Of `light_colours`.
    """

    study: RenderedStudy
    scene: Scene
    built: Scene
    colours: Colours

    def intensity(self, illumination: Illumination, seconds: float) -> dict[str, float]:
        """Lux or lumen of each layer; the moment matters where lamps flicker."""
        lumen = illumination.bulb_lm * lamps.flicker(illumination, seconds)
        on = lamps.burning(self.built, illumination, self.study.seed)
        own = illumination.sun
        return {
            **{
                sun.name: illumination.sun_lux if own is None or sun.name == own.name else 0.0
                for sun in self.scene.suns
            },
            self.scene.sky.name: illumination.sky_lux,
            **{bulb.group: lumen * burns for bulb, burns in zip(self.scene.bulbs, on, strict=True)},
        }

    def colour(self, illumination: Illumination) -> Colours:
        """Linear sRGB of each layer, (3,)."""
        scene = self.scene
        named = {
            **{sun.name: illumination.sun_illuminant or sun.illuminant for sun in scene.suns},
            scene.sky.name: illumination.sky_illuminant or scene.sky.illuminant,
            **{bulb.group: illumination.lamp_illuminant or bulb.illuminant for bulb in scene.bulbs},
        }
        return {layer: self.colours[name] for layer, name in named.items()}
