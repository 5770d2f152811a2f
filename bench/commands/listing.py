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


def list_known(kind: Annotated[Kind, typer.Argument(help="What to list.")]) -> None:
    """List scenes, filters, SLAM back-ends, studies or layouts of data sets, each with one line about it."""
    from bench import catalogue

    entries = getattr(catalogue, kind.value)()
    width = max((len(entry.name) for entry in entries), default=0)
    for entry in entries:
        typer.echo(f"{entry.name:<{width}}  {entry.summary}".rstrip())
