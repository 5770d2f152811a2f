"""Pictures with their whole truth, on which the guard of `guarded` is chosen.

The study `quick` in a scene of a split: three suns × three strengths of lamps, its camera, its sensor. Under
each light the same view is recorded a second time without its specular light, as if everything were matt: a
picture that is free of highlights by construction.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.another_place import in_scene
from bench.kinds.rendered import RenderedStudy
from bench.perception import visible_landmarks
from bench.rng import generator
from bench.sequences.lighting import Lighting, as_built, light_colours
from bench.sequences.rendered import RenderedSequence, SequenceSetup
from bench.study import load
from renderers.basis import mean_white, relight
from renderers.irradiance import BakeQuality
from renderers.truth import Recording, record

WHITE_AND_GREY = ("white matt", "white glaze", "grey matt", "grey gloss")
"""Objects of the scene `tabletop`."""


@dataclass(frozen=True, eq=False)
class Trial:
    """One picture with its truth.

    Attributes
    ----------
    light : str
        Name of the illumination.
    matt : bool
        Recorded without specular light.
    recording : Recording
    colourless : (H, W) bool
        Pixels of white and grey objects.
    discs : (n, 2) float64
        Landmarks in the robot's frame, metres.
    visible : (n,) bool
        Which of them the picture shows.
    """

    light: str
    matt: bool
    recording: Recording
    colourless: NDArray[np.bool_]
    discs: NDArray[np.float64]
    visible: NDArray[np.bool_]


def study_of(family: str, split: str, number: int) -> RenderedStudy:
    """The default study in a scene of a split."""
    return in_scene(load("quick"), family, split, number)


def trials(
    family: str, split: str, number: int, poses: int, cache: Path, quality: BakeQuality
) -> Iterator[Trial]:
    """Every light of the study at evenly spread poses of one scene's tour."""
    study = study_of(family, split, number)
    setup = SequenceSetup(study, "raycast", light_colours(study, cache), 1, cache / "baked", quality)
    sequence = RenderedSequence(setup)
    lighting = Lighting(study, sequence.scene, as_built(study), setup.colours)
    wanted = [k for k, s in enumerate(sequence.scene.surfaces) if s.name in WHITE_AND_GREY]
    for frame in np.linspace(0, len(sequence), poses, endpoint=False).astype(int).tolist():
        basis = sequence.basis(frame)
        for light in study.illuminations.grid():
            diffuse, specular = relight(basis, lighting.intensity(light, frame), lighting.colour(light))
            white = mean_white(basis, lighting.intensity(light, frame), lighting.colour(light))
            for matt in (False, True):
                taken = record(
                    sequence.sensor,
                    diffuse,
                    0 * specular if matt else specular,
                    white,
                    generator(study.seed, "sensor", light.name, frame),
                    study.sensor.highlight_threshold,
                )
                yield Trial(
                    light.name,
                    matt,
                    taken,
                    np.isin(basis.surface, wanted),
                    _from_robot(sequence, frame),
                    visible_landmarks(basis),
                )
    sequence.renderer.close()


def _from_robot(sequence: RenderedSequence, frame: int) -> NDArray[np.float64]:
    """The true landmarks in the robot's frame (eq. 3-6), (n, 2) metres."""
    x, y, theta = sequence.scene.tour.poses[frame]
    c, s = np.cos(theta), np.sin(theta)
    return np.asarray((sequence.scene.landmark_positions - (x, y)) @ np.array([[c, -s], [s, c]]))
