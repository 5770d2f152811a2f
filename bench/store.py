"""A run's folder: written aside, checked against the schema, then renamed."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bench.disk import require_free
from bench.errors import BenchError
from bench.schema import FRAME_COLUMNS, RUN_COLUMNS
from bench.tables import Row, read_table, to_table

if TYPE_CHECKING:
    import pandas as pd

    from vslam.occupancy import OccupancyGrid


class RunFolder:
    """The folder of one run while it is being written; use it in a ``with`` block.

    Leaving the block renames it to ``<out>/<study>-<date>-<time>`` and points ``<out>/latest`` to it; an
    exception removes it.

    Parameters
    ----------
    out : Path
        The results folder; created where missing.
    study : str
        The study's name.
    needed_bytes : int
        Estimate of what the run will write; the folder is refused where less is free.
    now : datetime, optional
        Start of the run, for the name.

    Raises
    ------
    BenchError
        If ``out`` cannot be written, is too full, or holds a ``latest`` that is not ours.

    Attributes
    ----------
    path : Path
        Where to write: the side folder inside the block, the final one after it.
    """

    def __init__(
        self, out: Path, study: str, needed_bytes: int = 100_000_000, now: datetime | None = None
    ) -> None:
        self._out = out
        self._name = f"{study}-{now or datetime.now():%Y%m%d-%H%M%S}"
        _check_results_folder(out, needed_bytes)
        self.path = out / f".{self._name}.partial-{os.getpid()}"

    def __enter__(self) -> RunFolder:
        shutil.rmtree(self.path, ignore_errors=True)  # an older process of the same number may have died
        for folder in ("trajectories", "figures"):
            (self.path / folder).mkdir(parents=True)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None:
            shutil.rmtree(self.path, ignore_errors=True)
            return
        final = self._free_name()
        os.rename(self.path, final)
        self.path = final
        self._point_latest()

    def write_text(self, name: str, text: str) -> Path:
        """Write a text file, UTF-8, at a path inside the run."""
        target = self.path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8", newline="\n")
        return target

    def write_json(self, name: str, value: object) -> Path:
        """Write JSON with two spaces of indent."""
        return self.write_text(name, json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n")

    def write_frames(self, rows: Iterable[Row]) -> Path:
        """Write ``frames.parquet``; every row has exactly the columns of `bench.schema.FRAME_COLUMNS`."""
        return self.write_table("frames.parquet", rows, FRAME_COLUMNS)

    def write_runs(self, rows: Iterable[Row]) -> Path:
        """Write ``runs.parquet``; every row has exactly the columns of `bench.schema.RUN_COLUMNS`."""
        return self.write_table("runs.parquet", rows, RUN_COLUMNS)

    def write_trajectory(self, name: str, stamps: ArrayLike, poses: ArrayLike) -> Path:
        """Write ``trajectories/<name>.tum``: stamp, position and quaternion (x y z w) in each line.

        Parameters
        ----------
        name : str
            File name without suffix.
        stamps : (n,) array
            Seconds, increasing.
        poses : (n, 3) array
            x, y (metres) and heading (rad); the robot stays on z = 0.

        Raises
        ------
        BenchError
            If the lengths differ or a value is not finite.
        """
        lines = tum_lines(stamps, poses, name)
        return self.write_text(f"trajectories/{name}.tum", "".join(f"{line}\n" for line in lines))

    def write_map(self, name: str, grid: OccupancyGrid) -> None:
        """Write ``maps/<name>.yaml`` and ``.pgm``, as nav2's ``map_server`` reads them."""
        from bench import map_server

        (self.path / "maps").mkdir(exist_ok=True)
        for file, content in map_server.files(grid, name).items():
            (self.path / "maps" / file).write_bytes(content)

    def write_table(self, name: str, rows: Iterable[Row], columns: Mapping[str, str]) -> Path:
        """Write a table whose rows have exactly the columns of ``columns``, as Parquet."""
        import pyarrow.parquet as pq

        target = self.path / name
        pq.write_table(to_table(list(rows), columns, name), target, compression="zstd")
        return target

    def _free_name(self) -> Path:
        """The final name, with a number where two runs start within one second."""
        final, number = self._out / self._name, 2
        while final.exists():
            final, number = self._out / f"{self._name}-{number}", number + 1
        return final

    def _point_latest(self) -> None:
        """Replace the link in one step: a reader sees the old or the new run, never none."""
        link = self._out / f".latest-{os.getpid()}"
        link.unlink(missing_ok=True)
        link.symlink_to(self.path.name)
        os.replace(link, self._out / "latest")


def tum_lines(stamps: ArrayLike, poses: ArrayLike, name: str = "trajectory") -> list[str]:
    """Format poses on the floor as lines of a TUM RGB-D trajectory; see `RunFolder.write_trajectory`."""
    seconds = np.asarray(stamps, dtype=np.float64)
    track: NDArray[np.float64] = np.asarray(poses, dtype=np.float64)
    if track.shape != (len(seconds), 3):
        raise BenchError(
            f"trajectory {name!r}: {len(seconds)} stamps but poses of shape {track.shape}, not (n, 3)"
        )
    if not (np.isfinite(seconds).all() and np.isfinite(track).all()):
        raise BenchError(f"trajectory {name!r}: holds a value that is not finite")
    half = track[:, 2] / 2
    return [
        f"{t:.6f} {x:.9f} {y:.9f} 0 0 0 {s:.12f} {c:.12f}"
        for t, (x, y, _), s, c in zip(seconds, track, np.sin(half), np.cos(half), strict=True)
    ]


@dataclass(frozen=True)
class StoredRun:
    """What `read` gives: the study's text, the provenance and both tables."""

    path: Path
    study: str
    provenance: dict[str, Any]
    frames: pd.DataFrame
    runs: pd.DataFrame


def read(run_dir: Path) -> StoredRun:
    """Read a run's folder.

    Raises
    ------
    BenchError
        If it is no run's folder, a file cannot be read, or a table's columns are not the schema's.
    """
    if not (run_dir / "study.yaml").is_file():
        raise BenchError(f"{run_dir}: not the folder of a run (no study.yaml); name one like results/latest")
    try:
        study = (run_dir / "study.yaml").read_text(encoding="utf-8")
        provenance = json.loads((run_dir / "provenance.json").read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BenchError(f"{run_dir}: study.yaml or provenance.json cannot be read: {error}") from None
    frames = read_table(run_dir / "frames.parquet", FRAME_COLUMNS)
    runs = read_table(run_dir / "runs.parquet", RUN_COLUMNS)
    return StoredRun(run_dir, study, provenance, frames, runs)


def _check_results_folder(out: Path, needed_bytes: int) -> None:
    """Refuse before hours of work, not after."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        probe = out / f".probe-{os.getpid()}"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise BenchError(
            f"results folder {out}: cannot be written ({error.strerror}); choose another with --out"
        ) from None
    require_free(out, needed_bytes, "choose another with --out")
    latest = out / "latest"
    if latest.exists() and not latest.is_symlink():
        raise BenchError(f"{latest}: is no link to a run; move it away, or choose another folder with --out")
