"""A study of filters: all of them in several scenes at the same levels of light, without SLAM."""

from __future__ import annotations

import math
import pickle
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, fields, replace
from typing import Any

from bench import strips
from bench.engine_choice import chosen_engine
from bench.filter_choice import FilterChoice
from bench.filter_times import milliseconds
from bench.filter_trial import Trial, try_filters
from bench.kinds.filters import FiltersStudy
from bench.light_levels import in_scene
from bench.options import RunOptions
from bench.perception import make_filter
from bench.pictures import reduced
from bench.progress import Progress
from bench.rendered_run import for_workers, prepared, show_choice
from bench.run_facts import RunFacts
from bench.schema import FRAME_COLUMNS, TIME_COLUMNS
from bench.sequences.lighting import load_scene
from bench.sequences.rendered import SequenceSetup
from bench.store import RunFolder
from bench.tour import perception
from bench.workers import Workers, workers
from vslam.filters.apply import FilterFailureError

Row = dict[str, Any]
SHOWN_SIDE = 200  # pixels: a strip of each filter has to fit on the page


@dataclass(frozen=True)
class _Task:
    """One pose of one scene, for a worker process."""

    setup: bytes
    frame: int
    neutral_objects: tuple[str, ...]


def run(study: FiltersStudy, folder: RunFolder, options: RunOptions, progress: Progress) -> RunFacts:
    """Compare the study's filters into a run folder; the table of SLAM runs stays empty."""
    facts = chosen_engine(study.engine, progress)
    with ExitStack() as held, workers(options.workers) as pool:
        setups = {}
        for scene in study.scenes:
            there = in_scene(study, scene, options.data)
            setup = held.enter_context(prepared(there, facts.engine, facts, progress))
            setups[load_scene(there).name] = for_workers(setup, options)
        with facts.timed("filter"):
            trial = _try_all(study, setups, pool, progress)
        with facts.timed("pictures"):
            shown = _show(setups, chosen(trial.lit), pool)
        with facts.timed("times"):
            times = _times(study, pool, progress)
    _write(folder, trial, times, shown)
    return facts


def frames_of(length: int, count: int) -> list[int]:
    """``count`` frames evenly spaced over a tour, or all of a shorter one."""
    if count >= length:
        return list(range(length))
    return [int((k + 0.5) * length / count) for k in range(count)]


def chosen(rows: Sequence[Row]) -> list[strips.Choice]:
    """Every filter on one picture: of those with any highlight, the one with the median share of them.

    By the true mask, not by what a filter made of it.
    """
    affected = sorted(
        (r["true_share"], r["scene"], r["illumination"], r["frame"])
        for r in rows
        if r["filter"] == "none" and r["true_share"] > 0
    )
    if not affected:
        return []
    picture = affected[len(affected) // 2][1:]
    return [
        strips.Choice("median picture", row)
        for row in rows
        if (row["scene"], row["illumination"], row["frame"]) == picture
        and row["status"] == "ok"
        and row["filter"] != "none"
    ]


def _try_all(
    study: FiltersStudy, setups: dict[str, SequenceSetup], pool: Workers, progress: Progress
) -> Trial:
    tasks = [
        _Task(pickled, frame, study.neutral_objects)
        for setup, pickled in ((s, pickle.dumps(s)) for s in setups.values())
        for frame in frames_of(len(load_scene(setup.study).tour.stamps), study.frames)
    ]
    every = Trial()
    with progress.stage("filter", len(tasks)) as advance:
        for trial in pool.map(_try_pose, tasks):
            for part in fields(Trial):
                getattr(every, part.name).extend(getattr(trial, part.name))
            advance(1)
    return every


def _try_pose(task: _Task) -> Trial:
    return try_filters(perception(task.setup), task.frame, task.neutral_objects)


def _show(
    setups: dict[str, SequenceSetup], choices: list[strips.Choice], pool: Workers
) -> list[strips.Strip]:
    tasks = [(pickle.dumps(setups[choice.row["scene"]]), choice) for choice in choices]
    return [_small(strip) for strip in pool.map(show_choice, tasks) if strip is not None]


def _small(strip: strips.Strip) -> strips.Strip:
    return replace(strip, pictures={k: reduced(p, SHOWN_SIDE) for k, p in strip.pictures.items()})


def _times(study: FiltersStudy, pool: Workers, progress: Progress) -> list[Row]:
    """Of every filter at every size, one after another and nothing beside them."""
    rows: list[Row] = []
    with progress.stage("time the filters", len(study.filters)) as advance:
        for choice in study.filters:
            rows += next(iter(pool.map(_time, [(choice, study.timed_sizes)])))
            advance(1)
    return rows


def _time(task: tuple[FilterChoice, tuple[tuple[int, int], ...]]) -> list[Row]:
    choice, sizes = task
    rows: list[Row] = []
    light_filter = make_filter(choice)
    for width, height in sizes:
        row = {"filter": choice.label, "width": width, "height": height}
        try:
            rows.append(row | {"filter_ms": milliseconds(light_filter, width, height), "status": "ok"})
        except FilterFailureError as error:
            rows.append(row | {"filter_ms": math.nan, "status": f"failed: {error.reason}"})
    return rows


def _write(folder: RunFolder, trial: Trial, times: list[Row], shown: list[strips.Strip]) -> None:
    folder.write_frames(trial.lit)
    folder.write_runs([])
    for name in ("highlight_free", "neutral", "oracle"):
        folder.write_table(f"{name}.parquet", getattr(trial, name), FRAME_COLUMNS)
    folder.write_table("times.parquet", times, TIME_COLUMNS)
    strips.write(folder.path / "figures", shown)
