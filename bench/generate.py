"""Data sets: rendered pictures with their ground truth on disk, in layouts that other tools open."""

from __future__ import annotations

import errno
import pickle
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from bench.datasets import layout, manifest
from bench.datasets.estimate import estimate
from bench.datasets.files import as_json, store_text
from bench.datasets.frame_writer import Job, write_frame
from bench.datasets.journal import Journal
from bench.datasets.model import REQUEST, Place, Request, Row
from bench.datasets.places import places
from bench.datasets.verify import read_request
from bench.engine_choice import chosen_engine
from bench.errors import BenchError
from bench.kinds.rendered import RenderedStudy
from bench.options import GenerateOptions
from bench.progress import Progress
from bench.provenance import version
from bench.rendered_run import prepared
from bench.run_facts import RunFacts
from bench.workers import Workers, workers

BATCH = 256
"""Frames that are handed to the processes at once, so that a long tour's tasks do not pile up in memory."""


def generate(study: RenderedStudy, options: GenerateOptions, progress: Progress) -> None:
    """Write a new data set into ``options.out``.

    Raises
    ------
    BenchError
        For an unknown scene, illumination, layout or split, a folder that holds something already or cannot
        be written, too little disk, or a disk that fills up; `resume` continues what was begun.
    """
    layout.check_names(options.layouts)
    chosen = places(study, options)
    engine = chosen_engine(study.engine, progress).engine
    layouts = tuple(dict.fromkeys(options.layouts))
    request = Request(chosen, layouts, engine, version("glarebench"))
    _begin(options.out, request)
    with _stopping(options.out):
        _make(options.out, request, options.workers, progress)


def resume(root: Path, count: int, progress: Progress) -> None:
    """Make what is missing or damaged in a data set, and close it.

    Parameters
    ----------
    count : int
        Processes.

    Raises
    ------
    BenchError
        If ``root`` holds no data set or one of another version, or the disk fills up.
    """
    request = read_request(root)
    here = version("glarebench")
    if request.glarebench != here:
        raise BenchError(
            f"{root}: begun by glarebench {request.glarebench}, this is {here}; "
            "pictures of both would not go together: make the data set anew with --out"
        )
    with _stopping(root):
        _make(root, request, count, progress)


def _begin(out: Path, request: Request) -> None:
    try:
        if out.exists() and (not out.is_dir() or any(path.name != REQUEST for path in out.iterdir())):
            raise BenchError(
                f"{out}: exists already; continue it with --resume {out}, or choose another --out"
            )
        store_text(out, REQUEST, [as_json(request.to_json())])
    except OSError as error:
        raise BenchError(f"{out}: cannot be written ({error.strerror}); choose another with --out") from None


@contextmanager
def _stopping(root: Path) -> Iterator[None]:
    """Say how to go on when the disk does not take more; what is on it is whole."""
    try:
        yield
    except OSError as error:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
        raise BenchError(
            f"{error.filename or root}: {error.strerror or error}; {'make room' if full else 'mend that'}, "
            f"then continue with: python -m bench generate --resume {root}"
        ) from None


def _make(root: Path, request: Request, count: int, progress: Progress) -> None:
    journal = Journal(root, request)
    to_do = [(place, journal.missing(place)) for place in request.places]
    others = sum(len(frames) for _, frames in to_do)
    announced = False
    with workers(count) as pool:
        for place, frames in ((p, f) for p, f in to_do if f):
            others -= len(frames)
            with _job(root, request, place, count, progress) as job:
                if not announced:
                    progress.notice(str(estimate(job, frames, others, count)))
                    announced = True
                with progress.stage(f"generate {place.name}", len(frames)) as advance:
                    for rows in _rows(pool, job, frames):
                        journal.append(rows)
                        advance(1)
    manifest.close(root, request)


@contextmanager
def _job(root: Path, request: Request, place: Place, count: int, progress: Progress) -> Iterator[Job]:
    facts = RunFacts(request.engine)
    with prepared(place.study, request.engine, facts, progress) as setup:
        yield Job(
            setup=replace(setup, threads=0 if count <= 1 else 1),
            place=place.name,
            illuminations=tuple(place.illuminations()),
            layouts=request.layouts,
            root=root,
        )


def _rows(pool: Workers, job: Job, frames: Sequence[int]) -> Iterator[list[Row]]:
    pickled = pickle.dumps(job)
    for start in range(0, len(frames), BATCH):
        yield from pool.map(write_frame, [(pickled, frame) for frame in frames[start : start + BATCH]])
