"""The user's files that a study names, and what was in them: filters, scenes, lamps, landmark logs."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

from bench.drive_choice import FileDrive
from bench.file_scene import FileScene
from bench.filter_choice import FilterChoice
from bench.scene_choice import LampChoice
from bench.study_parts import Part
from vslam.filters import discovery


def sha256(study: Part) -> dict[str, str]:
    """SHA-256 in hexadecimal of each file that a study names, and of those that its glTF files refer to.

    A file is called by the path that the study has, one beside a glTF file by that file's folder and its own
    name. A file that is not there is left to whoever reads it.

    Raises
    ------
    SceneError
        For a scene file that is no glTF file.
    """
    paths = sorted({path for part in _parts(study) for path in _files(part)})
    there = [path for path in paths if path.expanduser().is_file()]
    return {str(path): _digest(path.expanduser()) for path in there}


def _parts(part: Part) -> Iterator[Part]:
    """A part and all parts in it."""
    yield part
    for name in type(part).model_fields:
        value = getattr(part, name)
        for inner in value if isinstance(value, tuple) else (value,):
            if isinstance(inner, Part):
                yield from _parts(inner)


def _files(part: Part) -> Iterator[Path]:
    if isinstance(part, FilterChoice) and discovery.is_onnx(part.name):
        yield Path(part.name)
    elif isinstance(part, LampChoice) and part.ies is not None:
        yield Path(part.ies)
    elif isinstance(part, FileDrive):
        yield Path(part.path)
    elif isinstance(part, FileScene):
        yield from _of_scene(Path(part.path))


def _of_scene(path: Path) -> Iterator[Path]:
    from scenes.gltf.document import read

    yield path
    if path.expanduser().is_file():
        yield from (path.parent / name for name in read(path.expanduser()).files())


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
