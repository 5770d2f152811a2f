"""Pictures with their truth, from scenes of one split, for training `guarded`.

Each scene is rendered once per pose; each basis is then recorded under several lights, sensors and exposures.
Of some, the same view is recorded without its specular light: what a picture free of highlights looks like.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.another_place import in_scene
from bench.camera_choice import CameraChoice
from bench.illumination_grid import SKY_PER_SUN, Illumination
from bench.kinds.rendered import RenderedStudy
from bench.rng import generator
from bench.sensor_choice import SensorChoice
from bench.sequences.lighting import Lighting, as_built, light_colours
from bench.sequences.rendered import RenderedSequence, SequenceSetup, sensor
from bench.study import load
from renderers.basis import LightBasis, mean_white, relight
from renderers.irradiance import BakeQuality
from renderers.truth import record

FAMILIES = ("corridor", "atrium", "office", "warehouse", "tabletop", "regular")
BAKE = BakeQuality(sky_rays=512, bounce_rays=96, bounces=3)
"""An eighth of a study's rays: what it costs is a little unevenness of diffuse light."""

SENSORS = ("standard", "standard", "machine-vision", "webcam", "old-robot")


@dataclass(frozen=True)
class Amount:
    """How many scenes of each family, poses of each scene and lights of each pose."""

    scenes: int
    poses: int
    lights: int


@dataclass(frozen=True, eq=False)
class Pictures:
    """Pictures of one scene, at the network's resolution: half the camera's.

    Attributes
    ----------
    image : (n, H, W, 3) uint8
        As recorded, with noise.
    full, diffuse : (n, H, W, 3) uint8
        Free of noise, with and without specular light.
    disc : (n, H, W) bool
        Where a landmark's paint is seen.
    """

    image: NDArray[np.uint8]
    full: NDArray[np.uint8]
    diffuse: NDArray[np.uint8]
    disc: NDArray[np.bool_]


def split_pictures(split: str, amount: Amount, seed: int, cache: Path) -> Iterator[tuple[str, Pictures]]:
    """Pictures of every family, scene by scene, with its name; made once, then read from ``cache``."""
    cache.mkdir(parents=True, exist_ok=True)
    for number in range(amount.scenes):
        for family in FAMILIES:
            name = f"{split}-{family}-{number}"
            path = cache / f"{name}-{amount.poses}x{amount.lights}-{seed}.npz"
            if not path.exists():
                made = scene_pictures(split, family, number, amount, seed, cache)
                part = path.with_suffix(".part.npz")
                np.savez(part, **vars(made))
                part.rename(path)
            with np.load(path) as stored:
                yield name, Pictures(**{key: stored[key] for key in stored.files})


def scene_pictures(split: str, family: str, number: int, amount: Amount, seed: int, cache: Path) -> Pictures:
    """Pictures of one scene under random lights."""
    rng = generator(seed, "guarded", split, family, number)
    study = in_scene(load("quick"), family, split, number).model_copy(update={"camera": _camera(rng, number)})
    setup = SequenceSetup(study, "raycast", light_colours(study, cache), 0, cache / "baked", BAKE)
    sequence = RenderedSequence(setup)
    built = as_built(study)
    lighting = Lighting(study, sequence.scene, built, setup.colours)
    usual_lm = float(np.median([bulb.lumen for bulb in built.bulbs]))
    shots: list[tuple[np.ndarray, ...]] = []
    for frame in _spread(rng, len(sequence), amount.poses):
        basis = sequence.basis(frame)
        for k in range(amount.lights):
            light = _light(rng, usual_lm)
            shots.append(_shot(rng, study, lighting, basis, light, frame, matt=k == 0))
    sequence.renderer.close()
    return Pictures(*(np.stack(kind) for kind in zip(*shots, strict=True)))


def _spread(rng: np.random.Generator, frames: int, count: int) -> list[int]:
    """``count`` frames over the whole tour, from a random start."""
    return ((np.arange(count) + rng.uniform()) * frames / count).astype(int).tolist()


def _camera(rng: np.random.Generator, number: int) -> CameraChoice:
    """The default camera every other time; else another height, pitch, lens."""
    if number % 2 == 0:
        return CameraChoice.model_validate({})
    choice: dict[str, object] = {
        "height_m": float(rng.uniform(0.5, 1.4)),
        "pitch_deg": float(rng.uniform(5, 40)),
        "optics": {"blur_px": float(rng.uniform(0, 1)), "glare": float(rng.uniform(0, 0.04))},
    }
    if rng.random() < 0.6:
        choice |= {"model": "pinhole", "fov_deg": float(rng.uniform(60, 100))}
    return CameraChoice.model_validate(choice)


def _light(rng: np.random.Generator, usual_lm: float) -> Illumination:
    """Night, or sun of 1 to 120 klx with its sky; lamps of 1/10 to 10 times their usual strength, or off."""
    sun = 0.0 if rng.random() < 0.35 else float(np.exp(rng.uniform(np.log(1e3), np.log(1.2e5))))
    lamps_on = sun == 0.0 or rng.random() < 0.85
    bulb = usual_lm * float(np.exp(rng.uniform(np.log(0.1), np.log(10)))) if lamps_on else 0.0
    return Illumination(name="drawn", sun_lux=sun, sky_lux=sun * SKY_PER_SUN, bulb_lm=bulb)


def _shot(
    rng: np.random.Generator,
    study: RenderedStudy,
    lighting: Lighting,
    basis: LightBasis,
    light: Illumination,
    frame: int,
    matt: bool,
) -> tuple[np.ndarray, ...]:
    """One picture through a random sensor: image, full, diffuse, disc."""
    choice = SensorChoice.model_validate(
        {
            "preset": str(rng.choice(SENSORS)),
            "target": float(rng.uniform(0.10, 0.28)),
            "max_exposure_s": float(rng.choice([0.008, 0.03])),
            "max_gain_db": float(rng.choice([0.0, 12.0])),
        }
    )
    taker = sensor(study.model_copy(update={"sensor": choice}))
    intensity, colours = lighting.intensity(light, frame), lighting.colour(light)
    diffuse, specular = relight(basis, intensity, colours)
    specular = np.zeros_like(specular) if matt else specular
    taken = record(taker, diffuse, specular, mean_white(basis, intensity, colours), rng)
    return *(_half(p) for p in (taken.image, taken.full, taken.diffuse)), basis.landmark[::2, ::2] >= 0


def _half(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    rows, columns = (side // 2 for side in picture.shape[:2])
    return np.asarray(cv2.resize(picture, (columns, rows), interpolation=cv2.INTER_AREA), dtype=np.uint8)
