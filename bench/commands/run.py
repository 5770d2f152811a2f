"""``run``: a study from its first picture to its report."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.commands.parameters import (
    DataOption,
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
    from bench.study import Study

EXAMPLE = "Example: python -m bench run --study dlr --data data/dlr"


class EngineName(StrEnum):
    """What finds the visible surfaces."""

    auto = "auto"
    rasterise = "rasterise"
    raycast = "raycast"


def run(
    study: StudyOption = "quick",
    scene: SceneOption = None,
    split: SplitOption = None,
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
) -> None:
    """Run a study: render or replay, filter, map, navigate, score, report."""
    from bench import catalogue, log_parts
    from bench.commands.report import show
    from bench.errors import BenchError
    from bench.options import RunOptions
    from bench.progress import Bars
    from bench.study import load

    chosen = _override(placed(load(study), scene, split, data), engine, seed)
    if data is not None and not log_parts.reads_log(chosen):
        raise BenchError(f"--data: study {chosen.name!r} reads no log; leave the option out")
    chosen = log_parts.resolved(chosen, data)
    catalogue.check(chosen)
    options = RunOptions(out=out, data=data, workers=workers_or_cores(workers), command=command_line())
    from bench import runner  # Open3D comes with it: a wrong name must not wait for that
    from reports import html

    show(runner.run(chosen, options, Bars(), report=html.build))


def _override(study: Study, engine: EngineName | None, seed: int | None) -> Study:
    """The study as the options want it; the run stores it so."""
    from bench.errors import BenchError
    from bench.study_model import RenderedStudy

    changes: dict[str, object] = {}
    if seed is not None:
        changes["seed"] = seed
    if engine is not None:
        if not isinstance(study, RenderedStudy):
            raise BenchError(f"--engine: study {study.name!r} renders nothing; leave the option out")
        changes["engine"] = engine.value
    return study.model_copy(update=changes)
