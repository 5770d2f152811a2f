"""``doctor``: can this machine run the suite?"""

from __future__ import annotations

from pathlib import Path

import typer

from bench.commands.parameters import DataOption, ResultsOption

EXAMPLE = "Example: python -m bench doctor --out results"
_COLOURS = {"ok": "green", "warn": "yellow", "fail": "red"}


def doctor(out: ResultsOption = Path("results"), data: DataOption = None) -> None:
    """Check engine, packages, cores, memory, disk and data: each line is ok, or says what to do."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from bench.doctor import examine, runnable

    checks = examine(out, data)
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for check in checks:
        table.add_row(Text(check.status, style=_COLOURS[check.status]), check.name, Text(check.detail))
    Console().print(table)
    if not runnable(checks):
        raise typer.Exit(2)
