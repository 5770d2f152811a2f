"""The main job over a rendered scene: perceive every frame, localise every variant, keep the evidence."""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from bench import strips, tour
from bench.data import cache_folder
from bench.engine_choice import chosen_engine
from bench.kinds.rendered import RenderedStudy
from bench.options import RunOptions
from bench.progress import Progress
from bench.run_facts import RunFacts
from bench.sequences.lighting import light_colours, load_scene
from bench.sequences.rendered import SequenceSetup
from bench.store import RunFolder
from bench.workers import Workers, workers
from renderers.irradiance_cache import bake_scene
from scenes.occupancy import check_tour
from vslam.filters.apply import FilterFailureError


def run(study: RenderedStudy, folder: RunFolder, options: RunOptions, progress: Progress) -> RunFacts:
    """Run a rendered study into a run folder."""
    facts = chosen_engine(study.engine, progress)
    with prepared(study, facts.engine, facts, progress) as setup, workers(options.workers) as pool:
        setup = for_workers(setup, options)
        toured = tour.take(setup, pool, facts, progress)
        with facts.timed("pictures"):
            shown = _show(setup, strips.choose(toured.frame_rows), pool, progress)
        folder.write_frames(toured.frame_rows)
        folder.write_runs(toured.run_rows)
        tour.write(folder, toured)
        strips.write(folder.path / "figures", shown)
    return facts


def for_workers(setup: SequenceSetup, options: RunOptions) -> SequenceSetup:
    """The setup for the processes of a run: one alone has all cores, of several each has one."""
    return replace(setup, threads=0 if options.workers <= 1 else 1)


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


def show_choice(task: tuple[bytes, strips.Choice]) -> strips.Strip | None:
    """Render and filter a chosen picture again, in a worker."""
    pickled_setup, choice = task
    try:
        return strips.render(choice, tour.perception(pickled_setup).sequence)
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
