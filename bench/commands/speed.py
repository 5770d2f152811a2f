"""``speed``: how fast the suite renders and records, beside a baseline measured in the same run."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.table import Table

    from bench.speed.model import Result

EXAMPLE = "Example: python -m bench speed --only relight_expose --json"


def speed(
    as_json: Annotated[
        bool, typer.Option("--json", help="A list of {name, ours, baseline, ratio, unit} instead of a table.")
    ] = False,
    only: Annotated[
        list[str] | None,
        typer.Option("--only", metavar="NAME", help="One benchmark; repeatable. (Default: all.)"),
    ] = None,
) -> None:
    """Measure ours and a baseline alternately: a sweep of lights, a picture, a light basis, a data set."""
    from rich.console import Console

    from bench.data import cache_folder
    from bench.provenance import cores
    from bench.speed.measure import measure
    from bench.speed.model import Configuration
    from bench.speed.registry import choose

    chosen = choose(only or [])
    configuration = Configuration(cache=cache_folder(), processes=cores())
    results = []
    with Console(stderr=True).status("measuring") as status:
        for benchmark in chosen:
            status.update(f"measuring {benchmark.name}: {benchmark.summary}")
            results.append(measure(benchmark, configuration))
    if as_json:
        typer.echo(json.dumps([result.record() for result in results], indent=2))
        return
    console = Console()
    if not console.is_terminal:
        console.width = 120  # a file is as wide as it is; rich assumes 80
    console.print(table(results))
    for result in results:
        console.print(f"{result.name}: {result.note}", highlight=False)


def table(results: list[Result]) -> Table:
    """One row a benchmark: medians with their quartiles, and ours / baseline."""
    from rich.table import Table

    shown = Table(caption="median (quartiles) over alternating rounds; ratio = ours / baseline")
    shown.add_column("benchmark")
    for heading in ("ours", "baseline", "ratio"):
        shown.add_column(heading, justify="right")
    shown.add_column("unit")
    shown.add_column("target")
    for r in results:
        shown.add_row(
            r.name,
            _spread(r.ours, r.ours_quartiles),
            _spread(r.baseline, r.baseline_quartiles),
            f"{r.ratio:.2f}",
            r.unit,
            r.target,
        )
    return shown


def _spread(median: float, quartiles: tuple[float, float]) -> str:
    low, high = quartiles
    return f"{median:.3g} ({low:.3g}–{high:.3g})"
