"""What a data set consists of: places, illuminations, one row per picture."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from bench.illumination_grid import Illumination
from bench.kinds.rendered import RenderedStudy

NO_SPLIT = "all"

REQUEST, PICTURES, TABLE, MANIFEST, CROISSANT = (
    "request.json",
    "pictures.jsonl",
    "frames.csv",
    "dataset.json",
    "croissant.json",
)
"""The files beside the layouts' folders. `MANIFEST` is written last: a data set that has it is whole."""


@dataclass(frozen=True)
class Place:
    """A scene along whose tour pictures are taken.

    Attributes
    ----------
    name : str
        Of its folder; differs between places.
    split : str
        One of `scenes.splits.SPLITS`, or `NO_SPLIT`.
    study : RenderedStudy
        Whose scene, camera, sensor and illuminations are used.
    frames : int
        The first so many of the tour.
    lights : tuple of str
        Names of illuminations out of the study's grid.
    """

    name: str
    split: str
    study: RenderedStudy
    frames: int
    lights: tuple[str, ...]

    def illuminations(self) -> list[Illumination]:
        """Those of `lights`, in their order."""
        grid = {light.name: light for light in self.study.illuminations.grid()}
        return [grid[name] for name in self.lights]


@dataclass(frozen=True)
class Sequence:
    """One place under one illumination; ``name`` is its folder inside each layout."""

    place: Place
    illumination: Illumination

    @property
    def name(self) -> str:
        """``<place>/<illumination>``."""
        return f"{self.place.name}/{self.illumination.name}"


@dataclass(frozen=True)
class Request:
    """All that a data set's bytes follow from.

    Attributes
    ----------
    layouts : tuple of str
        Names of `bench.datasets.layout.layouts`.
    engine : str
        "rasterise" or "raycast", already resolved.
    glarebench : str
        The version that writes it.
    """

    places: tuple[Place, ...]
    layouts: tuple[str, ...]
    engine: str
    glarebench: str

    def sequences(self) -> list[Sequence]:
        """Every place under every illumination."""
        return [Sequence(place, light) for place in self.places for light in place.illuminations()]

    @property
    def pictures(self) -> int:
        """How many there will be."""
        return sum(place.frames * len(place.lights) for place in self.places)

    def to_json(self) -> dict[str, Any]:
        """Plain values; `from_json` gives an equal request back."""
        places = [
            {**vars(place), "lights": list(place.lights), "study": place.study.model_dump(mode="json")}
            for place in self.places
        ]
        return {
            "glarebench": self.glarebench,
            "engine": self.engine,
            "layouts": list(self.layouts),
            "places": places,
        }

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> Request:
        """Read what `to_json` wrote; KeyError, TypeError or ValueError for anything else."""
        return cls(
            places=tuple(
                Place(
                    name=place["name"],
                    split=place["split"],
                    study=RenderedStudy.model_validate(place["study"]),
                    frames=int(place["frames"]),
                    lights=tuple(place["lights"]),
                )
                for place in value["places"]
            ),
            layouts=tuple(value["layouts"]),
            engine=value["engine"],
            glarebench=value["glarebench"],
        )


@dataclass(frozen=True)
class StoredFile:
    """A file of the data set: path from its root, size, and digest of its bytes."""

    path: str
    bytes: int
    sha256: str


@dataclass(frozen=True)
class LayoutRow:
    """What one layout made of a picture; see `bench.datasets.layout.Files`."""

    files: tuple[StoredFile, ...]
    error: float | None
    facts: Mapping[str, Any]


@dataclass(frozen=True)
class Row:
    """One picture that is on disk: a line of `PICTURES`.

    Attributes
    ----------
    stamp_s : float
        Seconds since the start of the tour.
    pose : (x, y, θ)
        Of the robot, metres and rad.
    white_balance : (r, g, b)
        Gains.
    highlight_share, saturated_share : float
        Of the picture's pixels.
    layouts : mapping of layout name to LayoutRow
    """

    sequence: str
    frame: int
    stamp_s: float
    pose: tuple[float, ...]
    exposure_s: float
    gain_db: float
    white_balance: tuple[float, ...]
    highlight_share: float
    saturated_share: float
    layouts: Mapping[str, LayoutRow]

    def files(self) -> Iterator[StoredFile]:
        """All files of the picture."""
        for layout in self.layouts.values():
            yield from layout.files

    def to_json(self) -> dict[str, Any]:
        """Plain values; `from_json` gives an equal row back."""
        return asdict(self)

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> Row:
        """Read what `to_json` wrote; KeyError or TypeError for anything else."""
        layouts = {
            name: LayoutRow(tuple(StoredFile(**f) for f in row["files"]), row["error"], row["facts"])
            for name, row in value["layouts"].items()
        }
        plain: dict[str, Any] = {key: tuple(v) if isinstance(v, list) else v for key, v in value.items()}
        return cls(**{**plain, "layouts": layouts})
