"""``drive``: seconds of a robot's life for each second of one core, in closed loop with rendering.

The study ``drive``, but in the corridor under strong sun and dim bulbs, with its last filter, 320 × 240, a
picture every 0.4 s and a command every 0.1 s. Everything runs in one process with one thread: rendering at
the true pose, sensor with ground truth, light filter, detection, SLAM, mapping, planning, following, scoring.
The baseline renders the same poses with `bench.speed.stock_pyrender` (two passes, as it has no light basis)
and does nothing else. Left out on both sides is what happens once per scene: baking the bounced light,
uploading the mesh. Shadows, which a scene keeps from picture to picture, are not left out: each drive starts
without any.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from bench.drive.closed_loop import ClosedLoop
from bench.drive.episode import Episode, draw
from bench.drive_run import only
from bench.illumination_grid import IlluminationGrid
from bench.kinds.drive import ClosedLoopStudy
from bench.scene_choice import SceneChoice
from bench.sequences.lighting import light_colours
from bench.sequences.rendered import RenderedSequence, SequenceSetup
from bench.speed import stage
from bench.speed.model import Benchmark, Configuration, Sides
from bench.speed.stock_pyrender import StockRenderer
from bench.study import load
from scenes.occupancy import true_occupancy

SECONDS_PER_POSE = 2.0
"""Of driving, for each pose of a configuration: four make 20 pictures."""

PLACE = SceneChoice(name="corridor", seed=7)
LIGHT = IlluminationGrid(sun_lux=(90_000.0,), bulb_lm=(100.0,))

BULBS = 6
"""That stock pyrender has, as in the other benchmarks; the corridor's own are 14."""


def prepared(configuration: Configuration) -> tuple[ClosedLoop, ClosedLoopStudy, Episode]:
    """The loop, its study, and its first episode, ended by the clock."""
    whole = load("drive")
    assert isinstance(whole, ClosedLoopStudy)
    size = {"width": configuration.width, "height": configuration.height}
    there = {"camera": whole.camera.model_copy(update=size), "scene": PLACE, "illuminations": LIGHT}
    (light,) = LIGHT.grid()
    study = only(whole.model_copy(update=there), light)
    colours = light_colours(study, configuration.cache)
    setup = SequenceSetup(
        study, "raycast", colours, 1, configuration.cache, stage.quality(configuration), cached_shadows=True
    )
    sequence = RenderedSequence(setup)
    occupancy = true_occupancy(sequence.scene, study.navigation.resolution_m)
    seconds = SECONDS_PER_POSE * configuration.poses
    task = study.drive
    shortened = replace(draw(study, occupancy)[0], optimum_m=seconds * study.tour.speed_mps / task.patience)
    assert sequence.renderer.layers  # made now, not within the time of a drive
    return ClosedLoop(sequence, occupancy, light), study, shortened


@contextmanager
def prepare(configuration: Configuration) -> Iterator[Sides]:
    """Bake, and drive once for the poses that the baseline renders."""
    loop, study, episode = prepared(configuration)
    choice = study.filters[-1]
    drive = loop.drive(episode, choice)
    fresh = [prepared(configuration)[0] for _ in range(configuration.rounds + 1)]
    place = stage.scene(BULBS, configuration.laps)
    stock, lights = StockRenderer(place, configuration), stage.lights(place, 1)[0]
    seconds = round(drive.seconds)

    def ours() -> int:
        fresh.pop().drive(episode, choice)
        return seconds

    def baseline() -> int:
        for moment in drive.moments:
            stock.render(np.asarray(moment.true), lights)
        return seconds

    def note(rate: float, _: float) -> str:
        frame_ms = 1e3 * study.tour.frame_interval_s / rate
        return (
            f"{rate:.1f} times real time on one core, {frame_ms:.0f} ms a picture "
            f"({len(drive.moments)} pictures, {drive.driven_m:.1f} m)"
        )

    try:
        yield Sides(ours, baseline, note)
    finally:
        stock.close()


BENCHMARK = Benchmark(
    "drive",
    "a robot's seconds in closed loop per second of one core, against stock pyrender's pictures alone",
    "s/s",
    True,
    "ours ≥ 5",
    prepare,
)
