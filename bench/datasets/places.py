"""The places of a data set: every scene asked for, once for each split."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bench import catalogue
from bench.datasets.model import NO_SPLIT, SPLITS, Place
from bench.errors import unknown_name
from bench.rng import generator
from bench.sequences.lighting import load_scene
from bench.study_model import RenderedStudy, SceneChoice


def places(
    study: RenderedStudy, scenes: Sequence[str], splits: Sequence[str], frames: int | None
) -> tuple[Place, ...]:
    """Scenes × splits.

    Parameters
    ----------
    scenes : sequence of str
        Names of the library; the study's own scene where there is none.
    splits : sequence of str
        Out of `SPLITS`; each builds the scenes from seeds of its own, so that splits share no geometry.
        Without one the scenes are built from the study's own seed.
    frames : int or None
        The first so many of each tour; None for all.

    Raises
    ------
    BenchError
        For an unknown scene or split, with near names.
    """
    for split in splits:
        if split not in SPLITS:
            raise unknown_name("split", split, SPLITS)
    return tuple(_places(study, dict.fromkeys(scenes or [study.scene.name]), dict.fromkeys(splits), frames))


def _places(
    study: RenderedStudy, scenes: dict[str, None], splits: dict[str, None], frames: int | None
) -> Iterator[Place]:
    for scene in scenes:
        for split in splits or (NO_SPLIT,):
            own = study.model_copy(update={"scene": _choice(study.scene, scene, split)})
            catalogue.check(own)
            length = len(load_scene(own).tour.stamps)
            name = scene if split == NO_SPLIT else f"{scene}-{split}"
            yield Place(name, split, own, min(frames or length, length))


def _choice(wanted: SceneChoice, scene: str, split: str) -> SceneChoice:
    """Parameters and lamps are of one scene: another one takes its own."""
    seed = wanted.seed
    if split != NO_SPLIT:
        seed = int(generator(wanted.seed, "split", split).integers(2**31))
    if scene == wanted.name:
        return wanted.model_copy(update={"seed": seed})
    return SceneChoice(name=scene, seed=seed)
