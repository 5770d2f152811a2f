"""``generate``: a study's pictures with their ground truth, on disk."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bench.commands.parameters import DataOption, SceneOption, SplitOption, StudyOption, placed

EXAMPLE = "Example: python -m bench generate --out pictures --illumination sun90000-bulb800 --frames 20"


def generate(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where the TUM RGB-D folders go.")],
    study: StudyOption = "quick",
    scene: SceneOption = None,
    split: SplitOption = None,
    illumination: Annotated[
        list[str] | None,
        typer.Option(
            "--illumination", metavar="NAME", help="Of the study's grid; repeatable. (Default: all.)"
        ),
    ] = None,
    frames: Annotated[
        int | None,
        typer.Option("--frames", min=1, metavar="N", help="The first N of the tour. (Default: all.)"),
    ] = None,
    data: DataOption = None,
) -> None:
    """Write a study's pictures and their ground truth as TUM RGB-D folders."""
    from bench import catalogue, log_parts
    from bench.errors import BenchError
    from bench.options import GenerateOptions
    from bench.progress import Bars
    from bench.study import RenderedStudy, load

    chosen = placed(load(study), scene, split, data)
    if not isinstance(chosen, RenderedStudy):
        raise BenchError(f"study {chosen.name!r} renders nothing; choose one with 'sequence: rendered'")
    chosen = log_parts.resolved(chosen, data)
    catalogue.check(chosen)
    from bench.generate import generate as write_pictures

    options = GenerateOptions(out, tuple(illumination or ()), frames)
    for folder in write_pictures(chosen, options, Bars()):
        typer.echo(f"pictures: {folder}")
