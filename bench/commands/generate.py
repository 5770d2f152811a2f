"""``generate``: a study's pictures with their ground truth, on disk."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.commands.parameters import DataOption, StudyOption, WorkersOption, workers_or_cores

if TYPE_CHECKING:
    from bench.options import GenerateOptions

EXAMPLE = "Example: python -m bench generate --out pictures --layout tum --layout exr --frames 20"


def generate(
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="A new data set goes here.")
    ] = None,
    resume: Annotated[
        Path | None,
        typer.Option("--resume", metavar="DIR", help="Finish this one: make what is missing or damaged."),
    ] = None,
    verify: Annotated[
        Path | None,
        typer.Option("--verify", metavar="DIR", help="Name every missing or damaged file of this one."),
    ] = None,
    study: StudyOption = "quick",
    layout: Annotated[
        list[str] | None,
        typer.Option(
            "--layout",
            metavar="NAME",
            help="tum, euroc, coco, exr (half), exr-float, raw; repeatable. (Default: tum.)",
        ),
    ] = None,
    scene: Annotated[
        list[str] | None,
        typer.Option(
            "--scene", metavar="NAME|FILE", help="Or a glTF file; repeatable. (Default: the study's.)"
        ),
    ] = None,
    illumination: Annotated[
        list[str] | None,
        typer.Option(
            "--illumination", metavar="NAME", help="Of the study's grid; repeatable. (Default: all.)"
        ),
    ] = None,
    split: Annotated[
        list[str] | None,
        typer.Option(
            "--split", metavar="NAME", help="train, validation, test; repeatable. (Default: one set.)"
        ),
    ] = None,
    frames: Annotated[
        int | None,
        typer.Option("--frames", min=1, metavar="N", help="The first N of each tour. (Default: all.)"),
    ] = None,
    workers: WorkersOption = None,
    data: DataOption = None,
) -> None:
    """Write a study's pictures and their ground truth as a data set."""
    from bench.errors import BenchError
    from bench.progress import Bars

    if sum(folder is not None for folder in (out, resume, verify)) != 1:
        raise BenchError("generate: give one of --out DIR, --resume DIR and --verify DIR")
    if verify is not None:
        _verify(verify)
        return
    count = workers_or_cores(workers)
    if resume is not None:
        from bench.generate import resume as finish

        finish(resume, count, Bars())
    if out is not None:
        from bench.options import GenerateOptions

        illuminations, scenes, splits = (tuple(names or ()) for names in (illumination, scene, split))
        layouts = tuple(layout or ("tum",))
        _write(study, GenerateOptions(out, illuminations, frames, layouts, scenes, splits, count, data))
    typer.echo(f"data set: {resume or out}")


def _write(study: str, options: GenerateOptions) -> None:
    from bench.errors import BenchError
    from bench.kinds.rendered import RenderedStudy
    from bench.progress import Bars
    from bench.study import load

    chosen = load(study)
    if not isinstance(chosen, RenderedStudy):
        raise BenchError(
            f"study {chosen.name!r} is not of one rendered scene; choose one with 'sequence: rendered'"
        )
    from bench.generate import generate as write_pictures

    write_pictures(chosen, options, Bars())


def _verify(root: Path) -> None:
    from bench.datasets.verify import verify
    from bench.errors import BenchError
    from bench.progress import Bars

    verdict = verify(root, Bars())
    for problem in verdict.problems:
        typer.echo(problem)
    if verdict.problems:
        raise BenchError(
            f"{root}: {len(verdict.problems)} files missing or damaged; mend them with: "
            f"python -m bench generate --resume {root}"
        )
    typer.echo(f"data set: {root}: {verdict.files} files, all whole")
