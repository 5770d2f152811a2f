"""A study in another place: the same questions, the lamps as strong as they are there."""

from __future__ import annotations

from bench.errors import unknown_name
from bench.study_model import RenderedStudy
from scenes import library


def in_scene(
    study: RenderedStudy, name: str | None = None, split: str | None = None, seed: int | None = None
) -> RenderedStudy:
    """The study in another scene, in another split, or at another of its scenes.

    In another scene the builder's parameters are that scene's own, and ``bulb_lm`` keeps its ratio to the
    lamps that the scene is built with: a warehouse's high bays are no corridor's bulbs.

    Parameters
    ----------
    name : str, optional
        A scene of the library; without one, the study's.
    split : {"train", "test", "validation"}, optional
        Which scenes ``seed`` counts (`scenes.splits`); without one, the study's.

    Raises
    ------
    BenchError
        For a scene that does not exist, with near names.
    """
    scene, grid = study.scene, study.illuminations
    if name is not None and name != scene.name:
        known = library.names()
        if name not in known:
            raise unknown_name("scene", name, known)
        ratio = _lumen(name) / _lumen(scene.name)
        bulb_lm = tuple(float(f"{value * ratio:.4g}") for value in grid.bulb_lm)
        grid = grid.model_copy(update={"bulb_lm": bulb_lm})
        scene = scene.model_copy(update={"name": name, "parameters": {}})
    changes: dict[str, object] = {}
    if split is not None:
        changes["split"] = split
    if seed is not None:
        changes["seed"] = seed
    return study.model_copy(update={"scene": scene.model_copy(update=changes), "illuminations": grid})


def _lumen(name: str) -> float:
    """Of a lamp as the scene is built; 1 for a scene without any."""
    bulbs = library.load(name).bulbs
    return bulbs[0].lumen if bulbs else 1.0
