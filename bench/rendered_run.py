"""The main job over a rendered scene: perceive every frame, localise every variant, keep the evidence."""

from __future__ import annotations

import functools
import pickle
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from bench import strips
from bench.data import cache_folder
from bench.kinds.rendered import RenderedStudy
from bench.localisation import Localised, Variant, World, localise
from bench.metrics import navigation
from bench.options import RunOptions
from bench.perception import FramePercepts, Perception
from bench.progress import Progress
from bench.rng import generator
from bench.run_facts import RunFacts, landmark_csv, run_stem
from bench.sequences.lighting import light_colours, load_scene
from bench.sequences.rendered import RenderedSequence, SequenceSetup
from bench.store import RunFolder
from bench.workers import Workers, workers
from renderers.engine import choose_engine
from renderers.irradiance_cache import bake_scene
from scenes.occupancy import TrueOccupancy, check_tour, true_occupancy
from vslam.filters.apply import FilterFailureError


def run(study: RenderedStudy, folder: RunFolder, options: RunOptions, progress: Progress) -> RunFacts:
    """Run a rendered study into a run folder."""
    count = options.workers
    choice = choose_engine(study.engine)
    if choice.notice:
        progress.notice(choice.notice)
    facts = RunFacts(choice.name, choice.notice)
    with prepared(study, choice.name, facts, progress) as setup, workers(count) as pool:
        setup = replace(setup, threads=0 if count <= 1 else 1)
        sequence = RenderedSequence(setup)
        with facts.timed("perceive"):
            percepts = _perceive(setup, len(sequence), pool, progress)
        with facts.timed("localise"):
            occupancy = true_occupancy(sequence.scene, study.navigation.resolution_m)
            localised = _localise(sequence, occupancy, percepts, pool, progress)
        with facts.timed("pictures"):
            rows = [row for p in percepts for row in p.rows]
            shown = _show(setup, strips.choose(rows), pool, progress)
        _write(folder, sequence, occupancy, rows, localised, shown)
    return facts


@contextmanager
def prepared(
    study: RenderedStudy, engine: str, facts: RunFacts, progress: Progress
) -> Iterator[SequenceSetup]:
    """What every process needs, with the scene's light baked where it will be found.

    Raises
    ------
    SceneError
        If the tour runs through a wall.
    """
    with writable_cache() as cache:
        scene = load_scene(study)
        for text in scene.notices:
            progress.notice(text)
        check_tour(scene)
        with facts.timed("bake"), progress.stage("bake light", 1) as advance:
            setup = SequenceSetup(study, engine, light_colours(study, cache), 0, cache)
            bake_scene(scene, cache, progress.notice)
            advance(1)
        yield setup


@contextmanager
def writable_cache() -> Iterator[Path]:
    """The user's cache, or a folder for this run alone where that one cannot be written."""
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError:
        with tempfile.TemporaryDirectory() as own:
            yield Path(own)
        return
    yield folder


@functools.lru_cache(maxsize=1)
def perception(pickled_setup: bytes) -> Perception:
    """The perception of the process it is called in; made once, at its first frame."""
    setup: SequenceSetup = pickle.loads(pickled_setup)
    return Perception(RenderedSequence(setup), setup.engine)


def _perceive_frame(task: tuple[bytes, int]) -> FramePercepts:
    pickled_setup, frame = task
    return perception(pickled_setup).frame(frame)


def _perceive(setup: SequenceSetup, frames: int, pool: Workers, progress: Progress) -> list[FramePercepts]:
    pickled, percepts = pickle.dumps(setup), []
    with progress.stage("perceive", frames) as advance:
        for result in pool.map(_perceive_frame, [(pickled, k) for k in range(frames)]):
            percepts.append(result)
            advance(1)
    return percepts


def show_choice(task: tuple[bytes, strips.Choice]) -> strips.Strip | None:
    """Render and filter a chosen picture again, in a worker."""
    pickled_setup, choice = task
    try:
        return strips.render(choice, perception(pickled_setup).sequence)
    except FilterFailureError:  # it fails now and then; its rows say where it failed
        return None


def _show(
    setup: SequenceSetup, choices: list[strips.Choice], pool: Workers, progress: Progress
) -> list[strips.Strip]:
    pickled, shown = pickle.dumps(setup), []
    with progress.stage("pictures", len(choices)) as advance:
        for strip in pool.map(show_choice, [(pickled, choice) for choice in choices]):
            shown += [strip] if strip is not None else []
            advance(1)
    return shown


def _localise(
    sequence: RenderedSequence,
    occupancy: TrueOccupancy,
    percepts: list[FramePercepts],
    pool: Workers,
    progress: Progress,
) -> list[tuple[Variant, list[Localised]]]:
    variants = list(_variants(sequence, occupancy, percepts))
    done = []
    with progress.stage("localise", len(variants) * sequence.study.seeds) as advance:
        for variant, runs in zip(variants, pool.map(localise, variants), strict=True):
            done.append((variant, runs))
            advance(len(runs))
    return done


def _variants(
    sequence: RenderedSequence, occupancy: TrueOccupancy, percepts: list[FramePercepts]
) -> Iterator[Variant]:
    study, world = sequence.study, _world(sequence, occupancy, percepts)
    for illumination in study.illuminations.grid():
        for choice in study.filters:
            own = tuple(p.percepts[illumination.name, choice.label] for p in percepts)
            yield Variant(study, world, illumination, choice.label, own)


def _world(sequence: RenderedSequence, occupancy: TrueOccupancy, percepts: list[FramePercepts]) -> World:
    study, scene = sequence.study, sequence.scene
    task = study.navigation
    x0, y0 = occupancy.origin
    rows, cols = occupancy.blocked.shape
    return World(
        scene=scene.name,
        poses=scene.tour.poses,
        landmarks=scene.landmark_positions,
        bounds=(x0, y0, x0 + cols * occupancy.resolution, y0 + rows * occupancy.resolution),
        scans=tuple(p.scan for p in percepts),
        navigation=navigation.prepare(
            occupancy.blocked,
            occupancy.origin,
            occupancy.resolution,
            task.robot_radius_m,
            generator(study.seed, "navigation"),
            task.pairs,
        ),
    )


def _write(
    folder: RunFolder,
    sequence: RenderedSequence,
    occupancy: TrueOccupancy,
    rows: list[dict[str, object]],
    localised: list[tuple[Variant, list[Localised]]],
    shown: list[strips.Strip],
) -> None:
    scene, figures = sequence.scene, folder.path / "figures"
    folder.write_frames(rows)
    folder.write_runs([run.row for _, runs in localised for run in runs])
    folder.write_trajectory(f"truth--{scene.name}", scene.tour.stamps, scene.tour.poses)
    for run in (run for _, runs in localised for run in runs if run.row["status"] == "ok"):
        stem = run_stem(run.row)
        folder.write_trajectory(stem, scene.tour.stamps, run.poses)
        if run.row["seed"] == 0:
            folder.write_text(f"figures/landmarks--{stem}.csv", landmark_csv(run.landmark_table))
        if run.grid is not None:
            folder.write_map(stem, run.grid)
    np.savez_compressed(
        figures / f"occupancy--{scene.name}.npz",
        blocked=occupancy.blocked,
        origin=occupancy.origin,
        resolution=occupancy.resolution,
    )
    strips.write(figures, shown)
