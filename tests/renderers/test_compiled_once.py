"""Kernels are compiled once: a second process finds all of them beside their sources."""

from __future__ import annotations

import subprocess
import sys

RENDER = """
import gc
import numpy as np
from numba.core.dispatcher import Dispatcher
from renderers.basis import SceneRenderer, mean_white, relight
from renderers.camera import Fisheye, Mount
from renderers.irradiance import BakeQuality
from renderers.sensor import Sensor
from renderers.truth import record
from scenes import library

scene = library.load("corridor", laps=0.02)
renderer = SceneRenderer(scene, Fisheye(32, 24, 150.0), Mount(), threads=1, quality=BakeQuality(16, 16, 1))
basis = renderer.render(scene.tour.poses[0])
intensity, colour = dict.fromkeys(basis.layers, 800.0), dict.fromkeys(basis.layers, np.ones(3))
for array in ("none", "RGGB"):
    sensor, light = Sensor(colour_filter_array=array), relight(basis, intensity, colour)
    record(sensor, *light, mean_white(basis, intensity, colour), np.random.default_rng(0))
kernels = [k for k in gc.get_objects() if isinstance(k, Dispatcher) and k.__module__.startswith("renderers.")]
print(sum(len(k.stats.cache_hits) for k in kernels), *{
    f"{k.__module__}.{k.__name__}" for k in kernels if k.stats.cache_misses
})
"""


def test_nothing_recompiles_on_the_second_run():
    for _ in range(2):
        done = subprocess.run([sys.executable, "-c", RENDER], capture_output=True, text=True, check=True)
    loaded, *compiled = done.stdout.split()
    assert int(loaded) > 10
    assert compiled == []
