"""``score``: the trajectory that another system answered for a sequence."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

EXAMPLE = (
    "Example: python -m bench score --trajectory answer.tum --sequence pictures/tum/corridor/sun0-bulb800"
)


def score(
    trajectory: Annotated[
        Path, typer.Option("--trajectory", metavar="FILE", help="t x y z qx qy qz qw in each line.")
    ],
    sequence: Annotated[
        Path, typer.Option("--sequence", metavar="DIR", help="In TUM or EuRoC layout, or a trajectory file.")
    ],
    tolerance: Annotated[
        float, typer.Option("--tolerance", min=0, metavar="S", help="Longest time between two paired poses.")
    ] = 0.02,
    step: Annotated[
        int, typer.Option("--step", min=1, metavar="N", help="Pairs between the two poses of RPE.")
    ] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Numbers for a program.")] = False,
) -> None:
    """Score a trajectory against a sequence's true poses: ATE and RPE, as it is and aligned."""
    import json

    from bench.metrics.space_trajectory import Alignment, associate, evaluate
    from bench.trajectory_files import read_truth, read_tum

    estimate, truth = read_tum(trajectory), read_truth(sequence)
    paired = associate(estimate, truth, tolerance)
    scores = {alignment.value: evaluate(*paired, alignment, step) for alignment in Alignment}
    counts = {"poses": len(estimate), "paired": len(paired[0]), "true_poses": len(truth)}
    if as_json:
        typer.echo(json.dumps(counts | {name: vars(found) for name, found in scores.items()}, indent=2))
        return
    _print(counts, scores)


def _print(counts: Mapping[str, int], scores: Mapping[str, object]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table("aligned", *(f"{what}\n{unit}" for what, unit in COLUMNS.values()))
    for name, found in scores.items():
        table.add_row(name, *(f"{getattr(found, key):.4f}" for key in COLUMNS))
    Console().print(table)
    typer.echo(
        f"{counts['paired']} of {counts['poses']} estimated poses are paired; "
        f"{counts['true_poses'] - counts['paired']} of {counts['true_poses']} true ones have no estimate"
    )


COLUMNS = {
    "ate_rmse_m": ("ATE RMSE", "m"),
    "ate_median_m": ("median", "m"),
    "ate_max_m": ("largest", "m"),
    "rpe_rmse_m": ("RPE RMSE", "m"),
    "rpe_rmse_deg": ("RPE RMSE", "°"),
    "scale": ("scale", ""),
}
