"""Options that several commands share."""

from __future__ import annotations

import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from bench.study_model import Study


class SplitName(StrEnum):
    """The splits of `scenes.splits`."""

    train = "train"
    test = "test"
    validation = "validation"


StudyOption = Annotated[
    str, typer.Option("--study", metavar="NAME|FILE", help="A packaged study, or a study file (YAML).")
]
DataOption = Annotated[
    Path | None,
    typer.Option(
        "--data",
        metavar="DIR",
        help="Folder of the DLR log (default: $BENCH_DATA/dlr, else the cache), or of picture pairs.",
    ),
]
WorkersOption = Annotated[
    int | None,
    typer.Option("--workers", min=1, metavar="N", help="Processes; changes no number. (Default: all cores.)"),
]
SceneOption = Annotated[
    str | None,
    typer.Option(
        "--scene",
        metavar="NAME|FILE",
        help="A scene or a glTF file; lamps keep their ratio to its own. (Default: the study's.)",
    ),
]
SplitOption = Annotated[
    SplitName | None,
    typer.Option("--split", help="Of the scene's family, which its seed counts. (Default: the study's.)"),
]
FilterOption = Annotated[
    list[str] | None,
    typer.Option(
        "--filter",
        metavar="NAME|MODULE:CLASS|FILE.onnx",
        help="Instead of the study's filters, beside 'none', which always runs; repeatable. "
        "(Default: the study's.)",
    ),
]
ResultsOption = Annotated[Path, typer.Option("--out", metavar="DIR", help="The results folder.")]


def placed(study: Study, scene: str | None, split: SplitName | None, data: Path | None = None) -> Study:
    """The study in the scene that the options name; ``data`` is the DLR folder, for a scene that reads it."""
    if scene is None and split is None:
        return study
    from bench.another_place import in_scene, in_scenes
    from bench.kinds.rendered import RenderedStudy
    from bench.scenes_study import ScenesStudy

    if isinstance(study, ScenesStudy):
        return in_scenes(study, scene, None if split is None else split.value)
    if type(study) is not RenderedStudy:
        from bench.errors import BenchError

        option = "--scene" if scene is not None else "--split"
        if isinstance(study, RenderedStudy):  # its keys name illuminations, which another scene renames
            raise BenchError(
                f"{option}: study {study.name!r} is made for its scene; change it in the study file"
            )
        raise BenchError(f"{option}: study {study.name!r} has no scene to replace; leave the option out")
    return in_scene(study, scene, None if split is None else split.value, data=data)


def command_line() -> tuple[str, ...]:
    """The command as typed, for the provenance."""
    return ("python", "-m", "bench", *sys.argv[1:])


def workers_or_cores(workers: int | None) -> int:
    """The number asked for, or one process per core."""
    from bench.provenance import cores

    return workers or cores()
