"""``run``: a study from its first picture to its report."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.commands.parameters import (
    DataOption,
    FilterOption,
    ResultsOption,
    SceneOption,
    SplitOption,
    StudyOption,
    WorkersOption,
    command_line,
    placed,
    workers_or_cores,
)

if TYPE_CHECKING:
    from bench.study_model import Study

EXAMPLE = "Example: python -m bench run --study dlr --data data/dlr"
FINISHED_WITH_FAILURES = 3
"""The exit code of a run that is whole, but holds pictures or SLAM runs that failed."""

NEEDED = {
    "engine": ("--engine", "renders nothing"),
    "filters": ("--filter", "filters no picture"),
    "linear": ("--linear, --srgb", "reads no picture pairs"),
    "stride": ("--stride", "reads no recorded pictures"),
}
"""Keys of a study that options change, and what a study without one lacks."""


class EngineName(StrEnum):
    """What finds the visible surfaces."""

    auto = "auto"
    rasterise = "rasterise"
    raycast = "raycast"


def run(
    study: StudyOption = "quick",
    scene: SceneOption = None,
    split: SplitOption = None,
    filters: FilterOption = None,
    data: DataOption = None,
    out: ResultsOption = Path("results"),
    workers: WorkersOption = None,
    engine: Annotated[
        EngineName | None, typer.Option("--engine", help="Instead of the study's. (Default: the study's.)")
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option("--seed", min=0, metavar="S", help="Instead of the study's. (Default: the study's.)"),
    ] = None,
    stride: Annotated[
        int | None,
        typer.Option(
            "--stride", min=1, metavar="N", help="Every N-th recorded picture. (Default: the study's.)"
        ),
    ] = None,
    linear: Annotated[
        bool | None,
        typer.Option("--linear/--srgb", help="What the files of picture pairs hold. (Default: the study's.)"),
    ] = None,
) -> int:
    """Run a study: render or replay, filter, map, navigate, score, report.

    Exits with 0, or with 3 when a filter failed on a picture or a SLAM run failed: all others went on, and
    the table and the report say what failed and why.
    """
    from bench import log_parts
    from bench.commands.report import show
    from bench.errors import BenchError
    from bench.options import RunOptions
    from bench.progress import Bars
    from bench.study import load

    chosen = _override(placed(load(study), scene, split, data), engine, seed, filters, linear, stride)
    if data is not None and not chosen.reads_data():
        raise BenchError(f"--data: study {chosen.name!r} reads no data; leave the option out")
    chosen = log_parts.resolved(chosen, data)
    chosen.check(data)
    options = RunOptions(out=out, data=data, workers=workers_or_cores(workers), command=command_line())
    from bench import runner  # Open3D comes with it: a wrong name must not wait for that
    from reports import html
    from reports.kind import kind_of
    from reports.run import load as load_run

    run_dir = runner.run(chosen, options, Bars(), report=html.build)
    show(run_dir)
    stored = load_run(run_dir)
    return FINISHED_WITH_FAILURES if kind_of(stored.sequence).failures(stored) else 0


def _override(
    study: Study,
    engine: EngineName | None,
    seed: int | None,
    filters: list[str] | None = None,
    linear: bool | None = None,
    stride: int | None = None,
) -> Study:
    """The study as the options want it; the run stores it so."""
    from bench.errors import BenchError
    from bench.study import dump, parse

    changes: dict[str, object] = {}
    if seed is not None:
        changes["seed"] = seed
    asked = {"engine": engine, "filters": filters or None, "linear": linear, "stride": stride}
    for key, (option, lacks) in NEEDED.items():
        if asked[key] is not None and key not in type(study).model_fields:
            raise BenchError(f"{option}: study {study.name!r} {lacks}; leave the option out")
    if linear is not None:
        changes["linear"] = linear
    if engine is not None:
        changes["engine"] = engine.value
    if filters:
        from bench.filter_choice import from_option

        changes["filters"] = from_option(filters)
    if stride is not None:
        changes["stride"] = stride
    changed = study.model_copy(update=changes)
    # a stride may not fit the study's other keys: they are checked together
    return changed if stride is None else parse(dump(changed), f"--stride {stride}")
