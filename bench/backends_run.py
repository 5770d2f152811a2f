"""Back-ends compared on the same drives: a task per drive, repetition and back-end."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from bench import tour
from bench.backend_choice import BackendChoice
from bench.data import dlr_folder
from bench.dlr_run import write
from bench.drive_choice import AnyDrive, FileDrive, LoopDrive, RecordedDrive, RenderedDrive
from bench.engine_choice import chosen_engine
from bench.kinds.backends import BackendsStudy
from bench.metrics.cramer_rao import position_bound
from bench.options import RunOptions
from bench.progress import Progress
from bench.rendered_run import for_workers, prepared
from bench.rng import generator
from bench.run_facts import RunFacts
from bench.score import Replay, run_and_score
from bench.sequences import dlr, simulated, toured
from bench.sequences.drive import Drive, from_file, recorded
from bench.store import RunFolder
from bench.workers import Workers, workers
from vslam.slam import SlamSettings


@dataclass(frozen=True, eq=False)
class Sources:
    """What drives are made of that the study only names.

    Attributes
    ----------
    log : DlrLog, optional
        Where a drive needs it.
    tours : dict of drive's name to Seen
        What rendered drives saw.
    """

    log: dlr.DlrLog | None
    tours: dict[str, toured.Seen]


@dataclass(frozen=True, eq=False)
class Task:
    """A back-end on one repetition of a drive."""

    study: BackendsStudy
    drive: AnyDrive
    backend: BackendChoice
    run: int
    bound_m: float
    sources: Sources


def run(study: BackendsStudy, folder: RunFolder, options: RunOptions, progress: Progress) -> RunFacts:
    """Run all back-ends on all drives into a run folder; the frames table stays empty."""
    facts = _facts(study, progress)
    log = dlr.load(dlr_folder(options.data)) if study.reads_log() else None
    pairs = [(drive, k) for drive in study.drives for k in range(_repetitions(study, drive))]
    replays: list[Replay] = []
    with workers(options.workers) as pool:
        sources = Sources(log, _toured(study, facts, pool, options, progress))
        with facts.timed("bound"), progress.stage("bound", len(pairs)) as advance:
            bounds = []
            for bound_m in pool.map(_bound, [(study, drive, k, sources) for drive, k in pairs]):
                bounds.append(bound_m)
                advance(1)
        tasks = [
            Task(study, drive, backend, k, bound_m, sources)
            for (drive, k), bound_m in zip(pairs, bounds, strict=True)
            for backend in study.backends
        ]
        with facts.timed("estimate"), progress.stage("estimate", len(tasks)) as advance:
            for done in pool.map(_estimate, tasks):
                replays += done
                advance(1)
    write(folder, replays)
    return facts


def _facts(study: BackendsStudy, progress: Progress) -> RunFacts:
    """The engine that renders, where anything is rendered."""
    return chosen_engine(study.engine, progress) if study.rendered_drives() else RunFacts("none")


def _toured(
    study: BackendsStudy, facts: RunFacts, pool: Workers, options: RunOptions, progress: Progress
) -> dict[str, toured.Seen]:
    """The pictures of every rendered drive, looked at once for all repetitions and back-ends."""
    tours = {}
    for choice in study.rendered_drives():
        there = toured.rendered(choice, study.seed, options.data)
        with prepared(there, facts.engine, facts, progress) as setup:
            frames = tour.perceive(for_workers(setup, options), pool, facts, progress)
        tours[choice.name] = toured.seen(there, frames, choice.filter.label)
    return tours


def make(study: BackendsStudy, choice: AnyDrive, run: int, sources: Sources) -> Drive:
    """One repetition of a drive."""
    if isinstance(choice, RenderedDrive):
        return toured.drive(choice.name, sources.tours[choice.name], run)
    if isinstance(choice, LoopDrive):
        return simulated.round_loop(choice, study.seed, run)
    if isinstance(choice, FileDrive):
        return from_file(Path(choice.path), choice.name)
    assert sources.log is not None
    if isinstance(choice, RecordedDrive):
        return recorded(sources.log, choice.name)
    return simulated.along_log(choice, sources.log, study.seed, run)


def _repetitions(study: BackendsStudy, drive: AnyDrive) -> int:
    return 1 if isinstance(drive, RecordedDrive | FileDrive) else study.seeds


def _bound(task: tuple[BackendsStudy, AnyDrive, int, Sources]) -> float:
    study, choice, run, sources = task
    return position_bound(make(study, choice, run, sources))


def _estimate(task: Task) -> tuple[Replay, ...]:
    study, backend = task.study, task.backend
    own = generator(study.seed, "backend", backend.label, task.drive.name, task.run)
    settings = SlamSettings(
        backend.name,
        "annotated",
        study.observation,
        seed=int(own.integers(2**32)),
        parameters=backend.parameters,
    )
    drive = make(study, task.drive, task.run, task.sources)
    return run_and_score(drive, settings, backend.label, task.run, task.bound_m)
