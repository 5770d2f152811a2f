"""What the command line asks of a run besides the study itself."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class RunOptions:
    """Where a run reads, writes and how wide it works.

    Attributes
    ----------
    out : Path
        The results folder that the run's own folder goes into.
    data : Path or None
        The DLR folder from ``--data``; None searches the usual places (`bench.data.dlr_folder`).
    workers : int
        Processes, ≥ 1. The numbers do not depend on it.
    command : tuple of str
        The command line as typed, for the provenance.
    """

    out: Path = Path("results")
    data: Path | None = None
    workers: int = 1
    command: tuple[str, ...] = ()


@dataclass(frozen=True)
class GenerateOptions:
    """What `generate` writes to disk, and how.

    Attributes
    ----------
    out : Path
        The data set's folder; new or empty.
    illuminations : tuple of str
        Names out of the study's grid; empty means all.
    frames : int or None
        The first so many frames of each tour; None means all.
    layouts : tuple of str
        Names of `bench.datasets.layout.layouts`.
    scenes : tuple of str
        Names out of the library, or glTF files; empty means the study's own.
    splits : tuple of str
        Of "train", "validation" and "test"; empty means one set that is not split.
    workers : int
        Processes, ≥ 1. The bytes do not depend on it.
    data : Path or None
        The DLR folder from ``--data``, for a scene or camera that needs the log.
    """

    out: Path
    illuminations: tuple[str, ...] = ()
    frames: int | None = None
    layouts: tuple[str, ...] = ("tum",)
    scenes: tuple[str, ...] = ()
    splits: tuple[str, ...] = ()
    workers: int = 1
    data: Path | None = None


@dataclass(frozen=True)
class PreviewOptions:
    """What `preview` shows of a scene.

    Attributes
    ----------
    out : Path
        The folder for the two pictures.
    views : int
        Poses, evenly spaced along the tour.
    illuminations : tuple of str
        Names out of the study's grid; empty means four of them.
    """

    out: Path
    views: int = 4
    illuminations: tuple[str, ...] = ()
