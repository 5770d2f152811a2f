"""``relight_expose``: one picture with its ground truth from a light basis that is already there.

Ours: `relight`, the mean white of its light, and `record` (metering, shot and read noise, raw numbers, 8-bit
picture, noise-free picture with and without specular light, masks). Baseline: the same by NumPy alone:
``tensordot`` over the layers and `bench.speed.numpy_sensor`. Both sides work in the same processes, one for
each core, on the same basis of 8 layers; the layers' means, which the white follows from, ours keeps with it.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from bench.speed import numpy_sensor, stage
from bench.speed.measure import copy_bandwidth
from bench.speed.model import Benchmark, Configuration, Sides
from bench.workers import workers
from renderers.basis import LightBasis, mean_white, relight
from renderers.sensor import Sensor
from renderers.truth import Recording
from renderers.truth import record as record_truth

BULBS = 6


@functools.lru_cache(maxsize=1)
def basis(configuration: Configuration) -> LightBasis:
    """The basis of one pose, once per process."""
    place = stage.scene(BULBS, configuration.laps)
    return stage.renderer(place, configuration, "raycast").render(stage.poses(place, 2)[1])


@functools.lru_cache(maxsize=1)
def _lights(configuration: Configuration) -> tuple[list[dict[str, float]], dict[str, np.ndarray]]:
    place = stage.scene(BULBS, configuration.laps)
    return stage.lights(place, configuration.illuminations), stage.colours(place)


def ours(configuration: Configuration, k: int) -> Recording:
    """Illumination ``k`` by the suite."""
    view, (lights, colours) = basis(configuration), _lights(configuration)
    diffuse, specular = relight(view, lights[k], colours)
    white = mean_white(view, lights[k], colours)
    return record_truth(Sensor(), diffuse, specular, white, np.random.default_rng(k))


def baseline(configuration: Configuration, k: int) -> numpy_sensor.PlainRecording:
    """Illumination ``k`` by NumPy."""
    view, (lights, colours) = basis(configuration), _lights(configuration)
    intensity = np.array([lights[k][layer] for layer in view.layers])
    tint = np.stack([colours[layer] for layer in view.layers])
    weights = (intensity[:, None] * tint).astype(np.float32)
    diffuse = np.einsum("lhwc,lc->hwc", view.diffuse, weights)
    specular = np.einsum("lhwc,lc->hwc", view.specular, weights)
    share = intensity * view.diffuse.mean(axis=(1, 2, 3))
    return numpy_sensor.record(
        Sensor(), diffuse, diffuse + specular, share @ tint / share.sum(), np.random.default_rng(k)
    )


def _many(task: tuple[str, Configuration, int]) -> int:
    side, configuration, part = task
    mine = range(part, configuration.illuminations, configuration.processes)
    for k in mine:
        ours(configuration, k) if side == "ours" else baseline(configuration, k)
    return len(mine)


@contextmanager
def prepare(configuration: Configuration) -> Iterator[Sides]:
    """Open the processes; each makes the basis in the first, untimed round."""
    view = basis(configuration)  # bakes into the cache before the processes look there
    traffic = view.diffuse.nbytes + view.specular.nbytes
    bandwidth = copy_bandwidth()

    with workers(configuration.processes) as pool:

        def side(name: str) -> int:
            return sum(pool.map(_many, [(name, configuration, k) for k in range(configuration.processes)]))

        def note(rate: float, _: float) -> str:
            moved = rate * traffic
            return (
                f"{configuration.processes} processes; the basis is {traffic / 1e6:.1f} MB a picture: "
                f"{moved / 1e9:.2f} GB/s, {100 * moved / bandwidth:.0f} % of one core's copy at "
                f"{bandwidth / 1e9:.1f} GB/s"
            )

        yield Sides(lambda: side("ours"), lambda: side("baseline"), note)


BENCHMARK = Benchmark(
    "relight_expose",
    "one picture with ground truth from an existing basis of 8 layers, against plain NumPy",
    "pictures/s",
    True,
    "ours ≥ 300",
    prepare,
)
