"""``report``: the report of a run that is already there."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

EXAMPLE = "Example: python -m bench report results/latest"


def report(run_dir: Annotated[Path, typer.Argument(metavar="RUN_DIR", help="The folder of a run.")]) -> None:
    """Build the report of a stored run anew, and print its table."""
    from reports import html

    html.build(run_dir)
    show(run_dir)


def show(run_dir: Path) -> None:
    """Print a run's table and where its page is."""
    from rich.console import Console

    from reports import terminal

    console = Console()
    if not console.is_terminal:
        console.width = 100  # a file is as wide as it is; rich assumes 80
    console.print(terminal.summary(run_dir))
    typer.echo(f"report: {run_dir / 'report.html'}")
