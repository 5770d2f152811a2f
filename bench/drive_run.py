"""A study in closed loop: every episode under every light with every filter, a task each."""

from __future__ import annotations

import functools
import pickle
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.drive import scores
from bench.drive.closed_loop import ClosedLoop, Drive
from bench.drive.episode import Episode, draw
from bench.engine_choice import chosen_engine
from bench.filter_choice import FilterChoice
from bench.illumination_grid import Illumination
from bench.kinds.drive import ClosedLoopStudy
from bench.options import RunOptions
from bench.progress import Progress
from bench.rendered_run import writable_cache
from bench.run_facts import RunFacts
from bench.schema import DRIVE_COLUMNS
from bench.sequences.lighting import light_colours, load_scene
from bench.sequences.rendered import RenderedSequence, SequenceSetup
from bench.store import RunFolder
from bench.workers import workers
from renderers.irradiance_cache import bake_scene
from scenes.occupancy import TrueOccupancy, true_occupancy
from vslam.occupancy import OccupancyGrid


@dataclass(frozen=True, eq=False)
class Task:
    """One drive: under which light, with which filter, from where to where."""

    setup: bytes
    illumination: Illumination
    choice: FilterChoice
    episode: Episode


@dataclass(frozen=True, eq=False)
class Driven:
    """What is kept of a drive: its row, and stamps, true and believed poses, and what it had explored."""

    row: dict[str, object]
    stamps: NDArray[np.float64]
    true: NDArray[np.float64]
    believed: NDArray[np.float64]
    explored: NDArray[np.float64]
    grid: OccupancyGrid


def run(study: ClosedLoopStudy, folder: RunFolder, options: RunOptions, progress: Progress) -> RunFacts:
    """Drive a study into a run folder; the tables of frames and runs stay empty."""
    facts = chosen_engine(study.engine, progress)
    scene = load_scene(study)
    occupancy = true_occupancy(scene, study.navigation.resolution_m)
    episodes = draw(study, occupancy)
    with writable_cache() as cache:
        lights = study.lights()
        colours = light_colours(study, cache)
        setups = [
            SequenceSetup(only(study, i), facts.engine, colours, 1, cache, cached_shadows=True)
            for i in lights
        ]
        with facts.timed("bake"), progress.stage("bake light", len(setups)) as advance:
            for setup in setups:
                bake_scene(load_scene(setup.study), cache, progress.notice)
                advance(1)
        tasks = [
            Task(pickle.dumps(setup), light, filter_choice, episode)
            for setup, light in zip(setups, lights, strict=True)
            for filter_choice in study.filters
            for episode in episodes
        ]
        with (
            facts.timed("drive"),
            progress.stage("drive", len(tasks)) as advance,
            workers(options.workers) as pool,
        ):
            driven = []
            for result in pool.map(drive, tasks):
                driven.append(result)
                advance(1)
    _write(folder, scene.name, occupancy, driven)
    return facts


def only(study: ClosedLoopStudy, illumination: Illumination) -> ClosedLoopStudy:
    """The study with one illumination, so that its scene has no more layers of light than that needs."""
    grid = study.illuminations
    if grid.times is not None:
        return study
    changes = {
        "sun_lux": (illumination.sun_lux,),
        "bulb_lm": (illumination.bulb_lm,),
        "lamps": tuple(state for state in grid.lamps if state.name == illumination.lamps),
    }
    task = study.drive.model_copy(update={"lights": ()})
    return study.model_copy(update={"illuminations": grid.model_copy(update=changes), "drive": task})


def drive(task: Task) -> Driven:
    """Drive one task; a pure function of it."""
    sequence, occupancy = _place(task.setup)
    assert isinstance(sequence.study, ClosedLoopStudy)
    result = ClosedLoop(sequence, occupancy, task.illumination).drive(task.episode, task.choice)
    row = scores.row(
        sequence.study, sequence.scene.name, task.illumination, task.choice.label, task.episode, result
    )
    return _kept(row, result)


@functools.lru_cache(maxsize=2)
def _place(pickled: bytes) -> tuple[RenderedSequence, TrueOccupancy]:
    """What the process it is called in drives through; made once for each light."""
    setup: SequenceSetup = pickle.loads(pickled)
    sequence = RenderedSequence(setup)
    return sequence, true_occupancy(sequence.scene, setup.study.navigation.resolution_m)


def _kept(row: dict[str, object], result: Drive) -> Driven:
    moments = result.moments
    return Driven(
        row,
        np.array([m.seconds for m in moments]),
        np.array([m.true for m in moments]).reshape(-1, 3),
        np.array([m.believed for m in moments]).reshape(-1, 3),
        np.array([m.explored for m in moments]),
        result.grid,
    )


def stem(row: dict[str, object]) -> str:
    """File stem of what belongs to one drive."""
    return (
        "--".join(str(row[k]) for k in ("scene", "illumination", "filter", "task")) + f"--e{row['episode']}"
    )


def _write(folder: RunFolder, scene: str, occupancy: TrueOccupancy, driven: list[Driven]) -> None:
    folder.write_frames([])
    folder.write_runs([])
    folder.write_table("drives.parquet", [d.row for d in driven], DRIVE_COLUMNS)
    for one in driven:
        if not len(one.stamps):
            continue
        name = stem(one.row)
        folder.write_trajectory(f"truth--{name}", one.stamps, one.true)
        folder.write_trajectory(name, one.stamps, one.believed)
        if one.row["episode"] == 0:
            folder.write_map(name, one.grid)
        if one.row["task"] == "explore":
            lines = [f"{t:.3f},{share:.6f}" for t, share in zip(one.stamps, one.explored, strict=True)]
            folder.write_text(f"figures/explored--{name}.csv", "\n".join(["seconds,explored", *lines]) + "\n")
    np.savez_compressed(
        folder.path / "figures" / f"occupancy--{scene}.npz",
        blocked=occupancy.blocked,
        origin=occupancy.origin,
        resolution=occupancy.resolution,
    )
