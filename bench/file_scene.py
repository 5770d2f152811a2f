"""The part of a study that takes its scene from a glTF file."""

from __future__ import annotations

import re
from pathlib import PurePath
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from bench.study_parts import Part, Positive

SUFFIXES = (".glb", ".gltf")

Metres = Annotated[float, Field(ge=-10_000, le=10_000)]
WayPoint = tuple[Metres, Metres]
Disc = tuple[Metres, Metres, Annotated[float, Field(gt=0, le=1)], Literal["white", "black"]]


class FileScene(Part):
    """A .glb or .gltf file, and what it does not say itself; metres in the floor's plan, x east, y north.

    ``path`` counts from the folder that the program is started in. ``floor`` names the node that is the
    floor; without it the lowest roomy level is. The tour goes through ``tour``, else through nodes named
    ``tour…`` in the order of their numbers, else on a round that is planned, at most ``longest_m`` long;
    ``closed`` ones are driven ``laps`` times. Landmarks are ``landmarks`` (x, y, radius, white or black),
    else nodes named ``landmark…``, else drawn beside the tour. The sun stands where the file's directional
    light says, unless said here.
    """

    path: Annotated[str, Field(min_length=1)]
    floor: str = ""
    tour: tuple[WayPoint, ...] = ()
    closed: bool = True
    laps: Annotated[float, Field(gt=0, le=20)] = 1.25
    longest_m: Positive = 60.0
    landmarks: tuple[Disc, ...] | None = None
    sun_azimuth_deg: Annotated[float, Field(ge=-360, le=360)] | None = None
    sun_elevation_deg: Annotated[float, Field(ge=-90, le=90)] | None = None

    @model_validator(mode="before")
    @classmethod
    def _from_path_alone(cls, value: Any) -> Any:
        return {"path": value} if isinstance(value, str) else value

    @model_validator(mode="after")
    def _known_kind(self) -> FileScene:
        if not self.path.lower().endswith(SUFFIXES):
            raise ValueError(f"{self.path}: no {' or '.join(SUFFIXES)} file; export the scene as glTF 2.0")
        return self


def is_file(scene: str) -> bool:
    """Whether what a user calls a scene is a file rather than a name."""
    return "/" in scene or "." in scene


def name_of(path: str) -> str:
    """A scene's name from its file's: small letters, digits, - and _."""
    return re.sub(r"[^a-z0-9_-]+", "-", PurePath(path).stem.lower()).strip("-_") or "scene"
