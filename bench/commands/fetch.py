"""``fetch``: public data into the user's cache."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

EXAMPLE = "Example: python -m bench fetch dlr --pictures"


class DataSet(StrEnum):
    """What can be fetched."""

    dlr = "dlr"


def fetch(
    data_set: Annotated[DataSet, typer.Argument(help="Which data set.")],
    to: Annotated[
        Path | None, typer.Option("--to", metavar="DIR", help="Where to. (Default: dlr in the user's cache.)")
    ] = None,
    pictures: Annotated[
        bool, typer.Option("--pictures", help="The robot's 3,297 pictures too (101 MB).")
    ] = False,
) -> None:
    """Download the DLR building log (2.5 MB), every file verified against its pinned SHA-256."""
    from bench.data import cache_folder
    from bench.fetch import DLR_PICTURES, fetch_dlr
    from bench.progress import Bars

    folder = fetch_dlr(to or cache_folder() / data_set.value, Bars(), DLR_PICTURES if pictures else None)
    typer.echo(f"DLR log: {folder}")
