"""Options that several commands share."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

StudyOption = Annotated[
    str, typer.Option("--study", metavar="NAME|FILE", help="A packaged study, or a study file (YAML).")
]
SceneOption = Annotated[
    str | None,
    typer.Option(
        "--scene",
        metavar="NAME|FILE",
        help="Instead of the study's: a name, or a glTF file. (Default: the study's.)",
    ),
]
DataOption = Annotated[
    Path | None,
    typer.Option(
        "--data", metavar="DIR", help="Folder of the DLR log. (Default: $BENCH_DATA/dlr, else the cache.)"
    ),
]
WorkersOption = Annotated[
    int | None,
    typer.Option("--workers", min=1, metavar="N", help="Processes; changes no number. (Default: all cores.)"),
]
ResultsOption = Annotated[Path, typer.Option("--out", metavar="DIR", help="The results folder.")]


def command_line() -> tuple[str, ...]:
    """The command as typed, for the provenance."""
    return ("python", "-m", "bench", *sys.argv[1:])


def workers_or_cores(workers: int | None) -> int:
    """The number asked for, or one process per core."""
    from bench.provenance import cores

    return workers or cores()
