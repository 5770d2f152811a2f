"""A study of several scenes through the whole chain: its cases, pooled and each."""

from __future__ import annotations

from reports.cases import Case
from reports.comparison import compare
from reports.run import Run

POOLED = "all scenes and lights"
KEYS = ("recall", "precision", "rmse", "nav_success")
"""Columns of `reports.tables.COLUMNS` that say what the robot has of a filter."""


def scenes(run: Run) -> tuple[str, ...]:
    """In the study's order."""
    return tuple(dict.fromkeys(run.frames["scene"]))


def levels(run: Run) -> tuple[str, ...]:
    """Names of the levels of light, in the study's order."""
    return tuple(dict.fromkeys(run.frames["illumination"]))


def pooled(run: Run) -> tuple[Case, ...]:
    """All scenes together: under every light, then under each."""
    everything = compare(run)
    under = (Case(f"all scenes, {level}", everything, level) for level in levels(run))
    return (Case(POOLED, everything), *under)


def each(run: Run) -> tuple[Case, ...]:
    """Each scene under each light."""
    compared = {scene: compare(run.in_scene(scene)) for scene in scenes(run)}
    return tuple(
        Case(f"{scene}, {level}", comparison, level)
        for scene, comparison in compared.items()
        for level in levels(run)
    )
