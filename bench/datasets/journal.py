"""The index of a data set while it grows: one JSON line per picture, appended when its files are whole."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.datasets.files import is_whole
from bench.datasets.model import PICTURES, Place, Request, Row

NOT_THERE = -1


class Journal:
    """Finds a picture's line by sequence and frame; keeps only offsets in memory, eight bytes a picture.

    A line that a crash or a full disk cut off counts as not written. Of two lines for one picture the later
    counts.

    Parameters
    ----------
    root : Path
        Of the data set.
    """

    def __init__(self, root: Path, request: Request) -> None:
        self._root, self._path, self._request = root, root / PICTURES, request
        self._offsets: dict[str, NDArray[np.int64]] = {
            s.name: np.full(s.place.frames, NOT_THERE, dtype=np.int64) for s in request.sequences()
        }
        self._end = 0
        if self._path.exists():
            self._scan()

    def append(self, rows: Iterable[Row]) -> None:
        """Add the pictures of a frame; OSError if there is no room."""
        with self._path.open("r+b" if self._path.exists() else "wb") as file:
            file.truncate(self._end)
            file.seek(self._end)
            for row in rows:
                line = to_line(row)
                file.write(line)
                self._offsets[row.sequence][row.frame] = self._end
                self._end += len(line)

    def rows(self, sequence: str) -> Rows:
        """The pictures of a sequence that are there, in the order of their frames."""
        return Rows(self._path, self._offsets[sequence])

    def count(self) -> int:
        """How many pictures have a line."""
        return sum(int((offsets != NOT_THERE).sum()) for offsets in self._offsets.values())

    def missing(self, place: Place) -> list[int]:
        """The frames of a place of which some picture has no line, or some file that is not whole."""
        names = [s.name for s in self._request.sequences() if s.place == place]
        whole = np.ones(place.frames, dtype=np.bool_)
        for name in names:
            there = np.zeros(place.frames, dtype=np.bool_)
            for row in self.rows(name):
                there[row.frame] = all(is_whole(self._root, file) for file in row.files())
            whole &= there
        return [int(frame) for frame in np.flatnonzero(~whole)]

    def _scan(self) -> None:
        with self._path.open("rb") as file:
            for line in file:
                if not line.endswith(b"\n"):
                    break  # cut off; the next line takes its place
                row = _row(line)
                if row is not None and row.sequence in self._offsets:
                    offsets = self._offsets[row.sequence]
                    if 0 <= row.frame < len(offsets):
                        offsets[row.frame] = self._end
                self._end += len(line)


class Rows:
    """The rows of one sequence, read from the file each time they are gone through."""

    def __init__(self, path: Path, offsets: NDArray[np.int64]) -> None:
        self._path, self._offsets = path, offsets

    def __iter__(self) -> Iterator[Row]:
        offsets = self._offsets[self._offsets != NOT_THERE]
        if not len(offsets):
            return
        with self._path.open("rb") as file:
            for offset in offsets:
                file.seek(int(offset))
                yield Row.from_json(json.loads(file.readline()))


def to_line(row: Row) -> bytes:
    """A row as a line of JSON."""
    return json.dumps(row.to_json(), separators=(",", ":"), allow_nan=False).encode() + b"\n"


def _row(line: bytes) -> Row | None:
    try:
        return Row.from_json(json.loads(line))
    except (ValueError, KeyError, TypeError, AttributeError):
        return None
