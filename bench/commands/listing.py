"""``list``: the names that studies may use."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

EXAMPLE = "Example: python -m bench list filters"


class Kind(StrEnum):
    """What can be listed."""

    scenes = "scenes"
    filters = "filters"
    backends = "backends"
    studies = "studies"
    layouts = "layouts"


def list_known(
    kind: Annotated[Kind, typer.Argument(help="What to list.")],
    time: Annotated[
        bool, typer.Option("--time/--no-time", help="Measure each filter, which takes a few seconds.")
    ] = True,
) -> None:
    """List scenes, filters (with time and parameters), SLAM back-ends, studies or layouts of data sets."""
    from bench import catalogue

    entries = catalogue.filters(time) if kind is Kind.filters else getattr(catalogue, kind.value)()
    width = max((len(entry.name) for entry in entries), default=0)
    for entry in entries:
        typer.echo(f"{entry.name:<{width}}  {entry.summary}".rstrip())
        for line in entry.details:
            typer.echo(f"{'':<{width}}    {line}")
