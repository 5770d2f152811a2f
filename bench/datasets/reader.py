"""A data set as a sequence of NumPy arrays, in the form that PyTorch's ``DataLoader`` takes as it is."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.datasets.files import read_json
from bench.datasets.layout import check_names, layouts
from bench.datasets.model import MANIFEST, TABLE
from bench.errors import BenchError, unknown_name


@dataclass(frozen=True)
class _Entry:
    sequence: str
    frame: int
    stamp_s: float
    pose: tuple[float, float, float]


class PictureSet:
    """The pictures of a data set, each a dictionary of arrays.

    It holds no open file, so worker processes may share or pickle it.

    Parameters
    ----------
    root : Path or str
        Folder with ``dataset.json``.
    layout : str, optional
        Which of the data set's layouts to read; its first one without.
    split : str, optional
        "train", "validation" or "test"; all pictures without.

    Raises
    ------
    BenchError
        If the folder holds no finished data set, or not that layout or split.

    Examples
    --------
    >>> pictures = PictureSet("pictures")  # doctest: +SKIP
    >>> pictures[0]["image"].shape, pictures[0]["mask"].dtype  # doctest: +SKIP
    ((240, 320, 3), dtype('bool'))
    """

    def __init__(self, root: Path | str, layout: str | None = None, split: str | None = None) -> None:
        self.root = Path(root)
        there = self._manifest()
        self.layout = layout if layout is not None else next(iter(there["layouts"]))
        if self.layout not in there["layouts"]:
            check_names([self.layout])
            raise unknown_name(f"layout of {self.root}", self.layout, there["layouts"])
        if split is not None and split not in there["splits"]:
            raise unknown_name(f"split of {self.root}", split, there["splits"])
        self._entries = self._table(split)

    def __len__(self) -> int:
        return len(self._entries)

    def __getitem__(self, index: int) -> dict[str, Any]:
        """Read one picture.

        Returns
        -------
        dict
            ``sequence`` (str), ``frame`` (int), ``stamp_s`` (float), ``pose`` of the robot ((3,) float64:
            x, y, heading) and what the layout holds:

            - tum: ``image`` (H, W, 3) uint8 sRGB, ``depth`` (H, W) float32 metres, ``mask`` (H, W) bool,
              ``diffuse`` and ``specular`` (H, W, 3) float32, linear, 1 = where the sensor clips;
            - exr, exr-float: ``full``, ``diffuse``, ``specular`` (H, W, 3) float32 cd/m², ``depth``;
            - raw: ``raw`` int32; euroc, coco: ``image``.

        Raises
        ------
        IndexError
            Beyond the last picture.
        BenchError
            If a file cannot be read.
        """
        entry = self._entries[index]
        folder = self.root / self.layout / entry.sequence
        arrays = layouts()[self.layout].load(folder, vars(entry))
        return {**vars(entry), "pose": np.array(entry.pose), **arrays}

    def _manifest(self) -> dict[str, Any]:
        path = self.root / MANIFEST
        try:
            content: dict[str, Any] = read_json(path)
        except (OSError, ValueError) as error:
            raise BenchError(
                f"{path}: cannot be read ({error}); finish it with: bench generate --resume {self.root}"
            ) from None
        del content["files"]
        return content

    def _table(self, split: str | None) -> list[_Entry]:
        path = self.root / TABLE
        try:
            with path.open(encoding="utf-8", newline="") as file:
                rows = csv.DictReader(file)
                return [_entry(row) for row in rows if split is None or row["split"] == split]
        except (OSError, ValueError, KeyError) as error:
            raise BenchError(f"{path}: cannot be read ({error})") from None


def _entry(row: dict[str, str]) -> _Entry:
    pose = (float(row["x_m"]), float(row["y_m"]), float(row["heading_rad"]))
    return _Entry(row["sequence"], int(row["frame"]), float(row["stamp_s"]), pose)
