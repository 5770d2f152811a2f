"""The scene, poses and illuminations that benchmarks share: the corridor with eight lights, a layer each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bench.speed.model import Configuration
from renderers.basis import SceneRenderer
from renderers.camera import Mount, Pinhole
from renderers.irradiance import FULL_QUALITY, BakeQuality
from scenes import library
from scenes.model import Scene

SKY_PER_SUN = 0.124
SEED = 7
FOV_DEG = 90.0
MOUNT = Mount()


def scene(bulbs: int, laps: float = 1.0) -> Scene:
    """The corridor with its first bulbs alone, each in a group of its own."""
    whole = library.load("corridor", seed=SEED, laps=laps)
    kept = tuple(replace(bulb, group=f"bulb {k}") for k, bulb in enumerate(whole.bulbs[:bulbs]))
    return replace(whole, bulbs=kept)


def poses(place: Scene, count: int) -> NDArray[np.float64]:
    """(count, 3): evenly spread over the tour."""
    at = np.linspace(0, len(place.tour.poses), count, endpoint=False).astype(int)
    return place.tour.poses[at]


def camera(configuration: Configuration) -> Pinhole:
    """A pinhole, as stock pyrender has no fisheye."""
    return Pinhole(configuration.width, configuration.height, FOV_DEG)


def renderer(place: Scene, configuration: Configuration, engine: str, threads: int = 1) -> SceneRenderer:
    """Our renderer of a scene."""
    return SceneRenderer(
        place,
        camera(configuration),
        MOUNT,
        engine,
        threads=threads,
        cache=configuration.cache,
        quality=quality(configuration),
    )


def quality(configuration: Configuration) -> BakeQuality:
    """How well light is baked."""
    return BakeQuality(64, 16, 1) if configuration.fast_bake else FULL_QUALITY


def lights(place: Scene, count: int) -> list[dict[str, float]]:
    """Intensities of ``count`` illuminations: a log sweep of sun and sky, each bulb dimmed by itself."""
    rng = np.random.default_rng(SEED)
    suns = np.geomspace(100.0, 100_000.0, count)
    return [
        {
            place.suns[0].name: float(sun),
            place.sky.name: float(sun * SKY_PER_SUN),
            **{bulb.group: float(lumen) for bulb, lumen in zip(place.bulbs, row, strict=True)},
        }
        for sun, row in zip(suns, rng.uniform(200, 3200, (count, len(place.bulbs))), strict=True)
    ]


def colours(place: Scene) -> dict[str, NDArray[np.float64]]:
    """Every layer's colour: white, which costs as much as any other."""
    return {name: np.ones(3) for name in lights(place, 1)[0]}
