"""``preview``: a scene at a glance."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bench.commands.parameters import DataOption, StudyOption

EXAMPLE = "Example: python -m bench preview corridor"


def preview(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="A scene of the library, or a glTF file.")],
    study: StudyOption = "quick",
    views: Annotated[int, typer.Option("--views", min=1, metavar="N", help="Along the tour.")] = 4,
    illumination: Annotated[
        list[str] | None,
        typer.Option(
            "--illumination",
            metavar="NAME",
            help="Of the study's grid; repeatable. (Default: four of the grid.)",
        ),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option("--seed", min=0, metavar="S", help="Of the scene. (Default: the study's.)"),
    ] = None,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where the pictures go.")] = Path(
        "previews"
    ),
    data: DataOption = None,
) -> None:
    """Write a contact sheet (views × lights, with diffuse, specular, mask) and a top view of a scene."""
    from bench import log_parts
    from bench.another_place import in_scene
    from bench.errors import BenchError
    from bench.kinds.rendered import RenderedStudy
    from bench.options import PreviewOptions
    from bench.progress import Bars
    from bench.study import load

    chosen = load(study)
    if not isinstance(chosen, RenderedStudy):
        raise BenchError(
            f"study {chosen.name!r} is not of one rendered scene; choose one with 'sequence: rendered'"
        )
    chosen = log_parts.resolved(in_scene(chosen, scene, seed=seed, data=data), data)
    chosen.check()
    from bench.preview.preview import preview as draw

    for path in draw(chosen, PreviewOptions(out, views, tuple(illumination or ())), Bars()):
        typer.echo(f"preview: {path}")
