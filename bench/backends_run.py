"""Back-ends compared on the same drives: a task per drive, repetition and back-end."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from bench.backend_choice import BackendChoice
from bench.data import dlr_folder
from bench.dlr_run import write
from bench.drive_choice import AnyDrive, FileDrive, LoopDrive, RecordedDrive
from bench.kinds.backends import BackendsStudy
from bench.metrics.cramer_rao import position_bound
from bench.options import RunOptions
from bench.progress import Progress
from bench.rng import generator
from bench.run_facts import RunFacts
from bench.score import Replay, run_and_score
from bench.sequences import dlr, simulated
from bench.sequences.drive import Drive, from_file, recorded
from bench.store import RunFolder
from bench.workers import workers
from vslam.slam import SlamSettings


@dataclass(frozen=True, eq=False)
class Task:
    """A back-end on one repetition of a drive; ``log`` where the drive needs it."""

    study: BackendsStudy
    drive: AnyDrive
    backend: BackendChoice
    run: int
    bound_m: float
    log: dlr.DlrLog | None


def run(study: BackendsStudy, folder: RunFolder, options: RunOptions, progress: Progress) -> RunFacts:
    """Run all back-ends on all drives into a run folder; the frames table stays empty."""
    facts = RunFacts("none")
    log = dlr.load(dlr_folder(options.data)) if study.reads_data() else None
    pairs = [(drive, k) for drive in study.drives for k in range(_repetitions(study, drive))]
    replays: list[Replay] = []
    with workers(options.workers) as pool:
        with facts.timed("bound"), progress.stage("bound", len(pairs)) as advance:
            bounds = []
            for bound_m in pool.map(_bound, [(study, drive, k, log) for drive, k in pairs]):
                bounds.append(bound_m)
                advance(1)
        tasks = [
            Task(study, drive, backend, k, bound_m, log)
            for (drive, k), bound_m in zip(pairs, bounds, strict=True)
            for backend in study.backends
        ]
        with facts.timed("estimate"), progress.stage("estimate", len(tasks)) as advance:
            for done in pool.map(_estimate, tasks):
                replays += done
                advance(1)
    write(folder, replays)
    return facts


def make(study: BackendsStudy, choice: AnyDrive, run: int, log: dlr.DlrLog | None) -> Drive:
    """One repetition of a drive."""
    if isinstance(choice, LoopDrive):
        return simulated.round_loop(choice, study.seed, run)
    if isinstance(choice, FileDrive):
        return from_file(Path(choice.path), choice.name)
    assert log is not None
    if isinstance(choice, RecordedDrive):
        return recorded(log, choice.name)
    return simulated.along_log(choice, log, study.seed, run)


def _repetitions(study: BackendsStudy, drive: AnyDrive) -> int:
    return 1 if isinstance(drive, RecordedDrive | FileDrive) else study.seeds


def _bound(task: tuple[BackendsStudy, AnyDrive, int, dlr.DlrLog | None]) -> float:
    study, choice, run, log = task
    return position_bound(make(study, choice, run, log))


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
    drive = make(study, task.drive, task.run, task.log)
    return run_and_score(drive, settings, backend.label, task.run, task.bound_m)
