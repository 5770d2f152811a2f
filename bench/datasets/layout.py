"""What a layout of data sets is: which files a picture becomes, and which lists close a sequence."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from bench.datasets.model import Row
from bench.errors import unknown_name

if TYPE_CHECKING:  # a reader of data sets loads no renderer
    from bench.illumination_grid import Illumination
    from bench.sequences.rendered import RenderedSequence
    from renderers.basis import LightBasis
    from renderers.truth import Recording
    from vslam.camera import Calibration

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Track:
    """A place's tour under one illumination: what a layout may tell of a whole sequence."""

    sequence: RenderedSequence
    illumination: Illumination
    engine: str

    @cached_property
    def calibration(self) -> Calibration:
        """The camera and where it sits on the robot."""
        from bench.sequences.rendered import calibration

        return calibration(self.sequence.study)

    def T_world_camera(self, frame: int) -> FloatArray:
        """(4, 4): maps camera coordinates at a frame to the world's."""
        from renderers.camera import T_world_robot

        pose = self.sequence.scene.tour.poses[frame]
        return np.asarray(T_world_robot(pose) @ self.calibration.T_robot_camera)


@dataclass(frozen=True, eq=False)
class Picture:
    """One frame under one illumination, with all that is true about it."""

    track: Track
    frame: int
    basis: LightBasis
    recording: Recording

    @property
    def stamp_s(self) -> float:
        """Seconds since the start of the tour."""
        return float(self.track.sequence.scene.tour.stamps[self.frame])

    @cached_property
    def light(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Diffuse and specular luminance, each (H, W, 3) float32, cd/m²."""
        return self.track.sequence.relight(self.basis, self.track.illumination, self.frame)


@dataclass(frozen=True, eq=False)
class Files:
    """What a picture becomes.

    Attributes
    ----------
    content : mapping of str to bytes
        By path inside the sequence's folder; the recorded picture comes first.
    error : float, optional
        Largest |full − (diffuse + specular)| as stored, in the layout's unit; None where neither is stored.
    facts : mapping
        What the closing lists need besides, ready for JSON.
    """

    content: Mapping[str, bytes]
    error: float | None = None
    facts: Mapping[str, Any] = field(default_factory=dict)


class Layout(Protocol):
    """A layout; it keeps no state, so that pictures can be made in any order and process.

    Attributes
    ----------
    summary : str
        One line.
    suffix : str
        Of its pictures' files.
    error_unit : str
        What `Files.error` is a share of.
    """

    summary: str
    suffix: str
    error_unit: str

    def files(self, picture: Picture) -> Files:
        """The files of one picture."""

    def lists(self, track: Track, rows: Iterable[Row]) -> Iterator[tuple[str, Iterable[str]]]:
        """The files that close a sequence, path and pieces of text; ``rows`` may be gone through again."""

    def load(self, folder: Path, row: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        """Read one picture back; ``row`` has ``frame`` and ``stamp_s``."""


def layouts() -> dict[str, Layout]:
    """All layouts by name, sorted."""
    import bench.datasets.layouts as package

    names = sorted(module.name for module in pkgutil.iter_modules(package.__path__))
    found: dict[str, Layout] = {}
    for name in names:
        found.update(importlib.import_module(f"{package.__name__}.{name}").LAYOUTS)
    return found


def check_names(names: Iterable[str]) -> None:
    """Refuse a layout that does not exist.

    Raises
    ------
    BenchError
        With near names.
    """
    known = layouts()
    for name in names:
        if name not in known:
            raise unknown_name("layout", name, known)
