"""A study in another place: the same questions, the lamps as strong as they are there."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from pydantic import ValidationError

from bench import log_parts
from bench.errors import BenchError, unknown_name
from bench.file_scene import is_file
from bench.kinds.rendered import RenderedStudy
from bench.scene_choice import SceneChoice
from bench.scenes_study import ScenesStudy
from bench.sequences import lamps
from bench.sequences.lighting import as_built
from bench.study_errors import reason
from scenes import library

S = TypeVar("S", bound=ScenesStudy)


def in_scene(
    study: RenderedStudy,
    name: str | None = None,
    split: str | None = None,
    seed: int | None = None,
    data: Path | None = None,
) -> RenderedStudy:
    """The study in another scene, in another split, or at another of its scenes.

    In another scene the builder's parameters are that scene's own, and ``bulb_lm`` keeps its ratio to the
    lamps that the scene is built with, or has in its file: a warehouse's high bays are no corridor's bulbs.

    Parameters
    ----------
    name : str, optional
        A scene of the library, or the path of a glTF file; without one, the study's.
    split : {"train", "test", "validation"}, optional
        Which scenes ``seed`` counts (`scenes.splits`); without one, the study's.
    data : Path, optional
        The DLR folder from ``--data``, for a scene that needs the log (`bench.log_parts`).

    Raises
    ------
    BenchError
        For a scene that does not exist, with near names, a file that is no glTF file, or a split of a file.
    SceneError
        If the file gives no scene.
    """
    scene, grid = study.scene, study.illuminations
    if name is not None and name not in (scene.name, scene.file and scene.file.path):
        other = _choice(name, scene.seed)
        there = study.model_copy(update={"scene": other})
        ratio = _lumen(there, data) / _lumen(study, data)
        bulb_lm = tuple(float(f"{value * ratio:.4g}") for value in grid.bulb_lm)
        grid = grid.model_copy(update={"bulb_lm": bulb_lm})
        scene = scene.model_copy(update={"name": other.name, "parameters": {}, "file": other.file})
    changes: dict[str, object] = {}
    if split is not None:
        if scene.file is not None:
            raise BenchError(f"--split: {scene.file.path} is one scene, not a family; leave the option out")
        changes["split"] = split
    if seed is not None:
        changes["seed"] = seed
    return study.model_copy(update={"scene": scene.model_copy(update=changes), "illuminations": grid})


def in_scenes(study: S, name: str | None = None, split: str | None = None) -> S:
    """The study in one other scene alone, or with its scenes out of another split.

    Raises
    ------
    BenchError, SceneError
        As `in_scene`.
    """
    scenes = study.scenes if name is None else (_choice(name, 0),)
    if split is not None:
        scenes = tuple(s if s.file is not None else s.model_copy(update={"split": None}) for s in scenes)
    return study.model_copy(update={"scenes": scenes, "split": split or study.split})


def _choice(name: str, seed: int) -> SceneChoice:
    if not is_file(name):
        if name not in library.names():
            raise unknown_name("scene", name, library.names())
        return SceneChoice(name=name, seed=seed)
    try:
        return SceneChoice.model_validate({"seed": seed, "file": name})
    except ValidationError as error:
        raise BenchError(f"--scene: {reason(SceneChoice, error)}") from None


def _lumen(study: RenderedStudy, data: Path | None) -> float:
    return lamps.middle_lumen(as_built(log_parts.resolved(study, data)))
