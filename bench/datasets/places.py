"""The places of a data set: every scene asked for, once for each split."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bench import catalogue
from bench.datasets.model import NO_SPLIT, SPLITS, Place
from bench.errors import unknown_name
from bench.options import GenerateOptions
from bench.rng import generator
from bench.sequences.lighting import load_scene
from bench.study_model import RenderedStudy, SceneChoice


def places(study: RenderedStudy, options: GenerateOptions) -> tuple[Place, ...]:
    """Scenes × splits.

    Without a scene it is the study's own. Each split builds the scenes from seeds of its own, so that splits
    share no geometry; without a split they are built from the study's own seed.

    Raises
    ------
    BenchError
        For an unknown scene, split or illumination, with near names.
    """
    for split in options.splits:
        if split not in SPLITS:
            raise unknown_name("split", split, SPLITS)
    chosen = _positions(study, options.illuminations)
    return tuple(_places(study, options, chosen))


def _positions(study: RenderedStudy, names: Sequence[str]) -> list[int]:
    """Where the named illuminations stand in the study's grid; all without a name."""
    grid = [light.name for light in study.illuminations.grid()]
    for name in names:
        if name not in grid:
            raise unknown_name("illumination", name, grid)
    return [grid.index(name) for name in dict.fromkeys(names)] or list(range(len(grid)))


def _places(study: RenderedStudy, options: GenerateOptions, chosen: list[int]) -> Iterator[Place]:
    for scene in dict.fromkeys(options.scenes or [study.scene.name]):
        for split in dict.fromkeys(options.splits or [NO_SPLIT]):
            own = study.model_copy(update={"scene": _choice(study.scene, scene, split)})
            catalogue.check(own)
            grid, length = own.illuminations.grid(), len(load_scene(own).tour.stamps)
            yield Place(
                name=scene if split == NO_SPLIT else f"{scene}-{split}",
                split=split,
                study=own,
                frames=min(options.frames or length, length),
                lights=tuple(grid[k].name for k in chosen),
            )


def _choice(wanted: SceneChoice, scene: str, split: str) -> SceneChoice:
    """Parameters and lamps are of one scene: another one takes its own."""
    seed = wanted.seed
    if split != NO_SPLIT:
        seed = int(generator(wanted.seed, "split", split).integers(2**31))
    if scene == wanted.name:
        return wanted.model_copy(update={"seed": seed})
    return SceneChoice(name=scene, seed=seed)
