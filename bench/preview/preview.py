"""``preview``: what a study's scene looks like, before hours are spent on it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from bench.engine_choice import chosen_engine
from bench.errors import BenchError, unknown_name
from bench.illumination_grid import Illumination
from bench.kinds.rendered import RenderedStudy
from bench.options import PreviewOptions
from bench.preview import plan, sheet
from bench.preview.sheet import Cell
from bench.progress import Progress
from bench.rendered_run import prepared
from bench.sequences.rendered import RenderedSequence
from renderers.basis import LightBasis
from renderers.develop import encode

if TYPE_CHECKING:
    from matplotlib.figure import Figure

T = TypeVar("T")

ILLUMINATIONS = 4
"""Columns of a sheet unless the user names others."""


def preview(study: RenderedStudy, options: PreviewOptions, progress: Progress) -> list[Path]:
    """Write ``OUT/<scene>-sheet.png`` and ``OUT/<scene>-plan.png``; files of these names are replaced.

    Returns
    -------
    list of Path
        The two pictures.

    Raises
    ------
    BenchError
        For an unknown illumination, or a folder that cannot be written.
    """
    lights = _illuminations(study, options.illuminations)
    _make(options.out)
    facts = chosen_engine(study.engine, progress)
    with prepared(study, facts.engine, facts, progress) as setup:
        sequence = RenderedSequence(setup)
        frames = evenly(range(len(sequence)), options.views, closed=True)
        rows = []
        with progress.stage("preview", len(frames)) as advance:
            for frame in frames:
                basis = sequence.basis(frame)
                rows.append([cell(sequence, basis, light, frame) for light in lights])
                advance(1)
    names = [f"view {k + 1}, frame {frame}" for k, frame in enumerate(frames)]
    place, stem = sequence.scene, options.out / sequence.scene.name
    drawn = {
        stem.with_name(f"{stem.name}-sheet.png"): sheet.draw(rows, names, [light.name for light in lights]),
        stem.with_name(f"{stem.name}-plan.png"): plan.draw(place, place.tour.poses[frames]),
    }
    for path, figure in drawn.items():
        _save(figure, path)
    return list(drawn)


def evenly(items: Sequence[T], count: int, closed: bool = False) -> list[T]:
    """At most ``count`` of the items, evenly spaced; of a closed round, the end is its start and left out."""
    places = np.linspace(0, len(items) - (not closed), min(count, len(items)), endpoint=not closed)
    return [items[int(k)] for k in places]


def cell(sequence: RenderedSequence, basis: LightBasis, light: Illumination, frame: int) -> Cell:
    """A view under one light. The specular layer is exposed and balanced as its picture is."""
    recording = sequence.record(basis, light, frame)
    _, specular = sequence.relight(basis, light, frame)
    sensor, exposure = sequence.sensor, recording.exposure
    full_scale = sensor.electrons_per_luminance * exposure.seconds / sensor.full_well_e
    shown = encode(specular * full_scale * exposure.white_balance)
    return Cell(recording.image, recording.diffuse, shown, recording.highlight)


def _illuminations(study: RenderedStudy, names: Sequence[str]) -> list[Illumination]:
    grid = {light.name: light for light in study.illuminations.grid()}
    for name in names:
        if name not in grid:
            raise unknown_name("illumination", name, grid)
    return [grid[name] for name in dict.fromkeys(names)] or evenly(list(grid.values()), ILLUMINATIONS)


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BenchError(
            f"{folder}: cannot be written ({error.strerror}); choose another with --out"
        ) from None


def _save(figure: Figure, path: Path) -> None:
    aside = path.with_suffix(".png.part")
    try:
        figure.savefig(aside, format="png", metadata={"Software": None})
        aside.replace(path)
    except OSError as error:
        aside.unlink(missing_ok=True)
        raise BenchError(f"{path}: cannot be written ({error.strerror}); choose another --out") from None
