"""The places of a data set: every scene asked for, once for each split."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bench import log_parts
from bench.another_place import in_scene
from bench.datasets.model import NO_SPLIT, Place
from bench.errors import BenchError, unknown_name
from bench.kinds.rendered import RenderedStudy
from bench.options import GenerateOptions
from bench.sequences.lighting import load_scene
from scenes.splits import SPLITS


def places(study: RenderedStudy, options: GenerateOptions) -> tuple[Place, ...]:
    """Scenes × splits.

    Without a scene it is the study's own. Each split builds the scenes from seeds of its own
    (`scenes.splits`), so that splits share no geometry; without one, from the study's own seed. Another
    scene's illuminations are those of the same places in the grid, its lamps as strong as they are there.

    Raises
    ------
    BenchError
        For an unknown scene, split or illumination, with near names; two places of one name.
    """
    for split in options.splits:
        if split not in SPLITS:
            raise unknown_name("split", split, SPLITS)
    chosen = _positions(study, options.illuminations)
    found = tuple(_places(study, options, chosen))
    names = [place.name for place in found]
    for name in names:
        if names.count(name) > 1:
            raise BenchError(f"generate: two scenes are called {name!r}; rename one of the files")
    return found


def _positions(study: RenderedStudy, names: Sequence[str]) -> list[int]:
    """Where the named illuminations stand in the study's grid; all without a name."""
    grid = [light.name for light in study.illuminations.grid()]
    for name in names:
        if name not in grid:
            raise unknown_name("illumination", name, grid)
    return [grid.index(name) for name in dict.fromkeys(names)] or list(range(len(grid)))


def _places(study: RenderedStudy, options: GenerateOptions, chosen: list[int]) -> Iterator[Place]:
    for scene in dict.fromkeys(options.scenes or [None]):
        for split in dict.fromkeys(options.splits or [None]):
            own = log_parts.resolved(in_scene(study, scene, split, data=options.data), options.data)
            own.check()
            grid, place = own.illuminations.grid(), load_scene(own)
            length = len(place.tour.stamps)
            yield Place(
                name=place.name if split is None else f"{place.name}-{split}",
                split=split or NO_SPLIT,
                study=own,
                frames=min(options.frames or length, length),
                lights=tuple(grid[k].name for k in chosen),
            )
