"""``sweep``: recorded pictures with full ground truth per second, 32 illuminations of poses of one tour.

The corridor with eight lights (sun, sky, six bulbs, a layer each), 320 × 240 through a pinhole.
Ours, for each pose: render the light basis (engine "auto", shadow rays for the sun and each bulb, mirror
rays), then for each illumination weight it and record it: raw numbers, 8-bit picture, noise-free picture with
and without specular light, highlight and saturation masks. Depth, ids and visibility come with the basis.
Baseline: `bench.speed.stock_pyrender` renders each illumination anew, two passes, then
`bench.speed.numpy_sensor` records it; stock pyrender's pictures have 8 bits and its bulbs no shadows, so it
does less. It is timed on a few of the illuminations, as each costs it the same.
Both run in the same processes, one for each core. Left out on both sides is what happens once per scene:
baking the bounced light, uploading the mesh.
"""

from __future__ import annotations

import atexit
import functools
import os
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from bench.speed import numpy_sensor, stage
from bench.speed.model import Benchmark, Configuration, Sides
from bench.speed.stock_pyrender import StockRenderer
from bench.workers import workers
from renderers.basis import SceneRenderer, mean_white, relight
from renderers.engine import choose_engine
from renderers.sensor import Sensor
from renderers.truth import Recording
from renderers.truth import record as record_truth

BULBS = 6
BASELINE_SHARE = 8
"""The baseline renders every eighth illumination."""

Poses = NDArray[np.float64]
Lights = list[dict[str, float]]


@functools.lru_cache(maxsize=1)
def _task(configuration: Configuration) -> tuple[Poses, Lights, dict[str, NDArray[np.float64]]]:
    place = stage.scene(BULBS, configuration.laps)
    return (
        stage.poses(place, configuration.poses),
        stage.lights(place, configuration.illuminations),
        stage.colours(place),
    )


@functools.lru_cache(maxsize=1)
def _renderer(configuration: Configuration) -> SceneRenderer:
    engine = choose_engine("auto").name
    renderer = stage.renderer(stage.scene(BULBS, configuration.laps), configuration, engine)
    atexit.register(
        renderer.close
    )  # left to its destructor, pyrender prints while the interpreter shuts down
    return renderer


@functools.lru_cache(maxsize=1)
def _stock(configuration: Configuration) -> StockRenderer:
    stock = StockRenderer(stage.scene(BULBS, configuration.laps), configuration)
    atexit.register(stock.close)
    return stock


def ours(configuration: Configuration, pose: int) -> list[Recording]:
    """All pictures of one pose by the suite."""
    poses, lights, colours = _task(configuration)
    basis = _renderer(configuration).render(poses[pose])
    recordings = []
    for k, intensity in enumerate(lights):
        diffuse, specular = relight(basis, intensity, colours)
        white, rng = mean_white(basis, intensity, colours), np.random.default_rng(k)
        recordings.append(record_truth(Sensor(), diffuse, specular, white, rng))
    return recordings


def baseline(configuration: Configuration, pose: int) -> list[numpy_sensor.PlainRecording]:
    """Some of the pictures of one pose by stock pyrender and NumPy."""
    poses, lights, _ = _task(configuration)
    recordings = []
    for k, intensity in enumerate(lights[::BASELINE_SHARE]):
        full, dull, _ = _stock(configuration).render(poses[pose], intensity)
        rng = np.random.default_rng(k)
        recordings.append(numpy_sensor.record(Sensor(), dull, full, np.ones(3), rng))
    return recordings


def _ours(task: tuple[Configuration, int]) -> int:
    return len(ours(*task))


def _baseline(task: tuple[Configuration, int]) -> int:
    return len(baseline(*task))


@contextmanager
def prepare(configuration: Configuration) -> Iterator[Sides]:
    """Bake into the cache and open the processes."""
    stage.renderer(stage.scene(BULBS, configuration.laps), configuration, "raycast", threads=0).close()
    tasks = [(configuration, pose) for pose in range(configuration.poses)]
    with _one_mesa_thread(configuration.processes), workers(configuration.processes) as pool:

        def note(rate: float, _: float) -> str:
            pixels = configuration.width * configuration.height
            rays = (1 + (1 + BULBS)) * pixels / configuration.illuminations
            draws = 3 * pixels
            return (
                f"{configuration.processes} processes, {configuration.poses} poses × "
                f"{configuration.illuminations} illuminations; a picture is at most {rays:,.0f} primary and "
                f"shadow rays and {draws:,} noise draws: {rate * draws / 1e6:.1f} million draws a second"
            )

        yield Sides(lambda: sum(pool.map(_ours, tasks)), lambda: sum(pool.map(_baseline, tasks)), note)


@contextmanager
def _one_mesa_thread(processes: int) -> Iterator[None]:
    """One process for each core needs no threads in Mesa; the processes inherit this."""
    name = "LP_NUM_THREADS"
    before = os.environ.get(name)
    if processes > 1:
        os.environ[name] = "0"  # llvmpipe: rasterise in the calling thread
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = before


BENCHMARK = Benchmark(
    "sweep",
    "pictures with ground truth of a tour under 32 illuminations, against stock pyrender + NumPy",
    "pictures/s",
    True,
    "ratio ≥ 20",
    prepare,
)
