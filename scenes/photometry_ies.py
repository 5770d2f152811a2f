"""Lamps as their makers measured them: IES LM-63 files (1986 to 2019), type C."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError
from scenes.photometry import Photometry

FloatArray = NDArray[np.float64]
TYPE_C = 1
MOST_ANGLES = 3601
"""No web is finer than a tenth of a degree; more is a damaged count."""


class PhotometryFileError(SceneError):
    """A photometric file that does not parse."""


def read_ies(path: Path) -> Photometry:
    """Read an LM-63 file.

    Returns
    -------
    Photometry
        Horizontal angles unfolded to 0…360°; ``lumen`` is the flux of the web with all of the file's factors.

    Raises
    ------
    PhotometryFileError
        Naming file and line.
    """
    try:
        lines = path.read_text(encoding="latin-1").splitlines()
    except OSError as error:
        raise PhotometryFileError(f"{path}: cannot be read ({error.strerror})") from error
    numbers = _Numbers(path, lines, *_after_header(path, lines))
    numbers.skip_tilt()
    head = numbers.take(10, "lamp count … height")
    vertical_count = numbers.count(head[3], "vertical angles")
    horizontal_count = numbers.count(head[4], "horizontal angles")
    if head[5] != TYPE_C:
        raise numbers.error(f"photometric type {head[5]:g}; only type C (1) is read")
    ballast, ballast_lamp, _watts = numbers.take(3, "ballast factors and watts")
    vertical = numbers.ascending(vertical_count, "vertical angles")
    horizontal = numbers.ascending(horizontal_count, "horizontal angles")
    candela = numbers.take(vertical_count * horizontal_count, "candela values")
    if (candela < 0).any():
        raise numbers.error("a candela value is negative")
    web = candela.reshape(horizontal_count, vertical_count) * head[2] * ballast * ballast_lamp
    if vertical[0] < 0 or vertical[-1] > 180 or vertical_count < 2:
        raise numbers.error("vertical angles must span a part of 0…180°")
    try:
        return Photometry.of(vertical, *_unfolded(horizontal, web, numbers))
    except PhotometryFileError:
        raise
    except SceneError as error:
        raise numbers.error(str(error)) from error


def _after_header(path: Path, lines: list[str]) -> tuple[int, str]:
    """Index of the first line of numbers, and what TILT is."""
    for k, line in enumerate(lines):
        if line.strip().upper().startswith("TILT="):
            return k + 1, line.split("=", 1)[1].strip().upper()
    raise PhotometryFileError(f"{path}, line {max(len(lines), 1)}: no TILT= line; is it an IES LM-63 file?")


def _unfolded(horizontal: FloatArray, web: FloatArray, numbers: _Numbers) -> tuple[FloatArray, FloatArray]:
    """Half-planes 0…360° from those the file states: its last angle says which symmetry it leaves out."""
    last = horizontal[-1]
    if horizontal[0] != 0 or last not in (0, 90, 180, 360):
        raise numbers.error(
            f"horizontal angles {horizontal[0]:g}…{last:g}°; must run from 0 to 0, 90, 180 or 360"
        )
    while 0 < last < 360:
        horizontal = np.concatenate([horizontal, 2 * last - horizontal[-2::-1]])
        web = np.concatenate([web, web[-2::-1]])
        last = horizontal[-1]
    return horizontal, web


@dataclass
class _Numbers:
    """The numbers after the header, each with its line, for messages."""

    path: Path
    lines: list[str]
    first: int
    tilt: str

    def __post_init__(self) -> None:
        self._line = self.first
        self._words = self._read()

    def error(self, what: str) -> PhotometryFileError:
        return PhotometryFileError(f"{self.path}, line {self._line}: {what}")

    def take(self, count: int, what: str) -> FloatArray:
        values = np.empty(count)
        for k in range(count):
            word = next(self._words, None)
            if word is None:
                raise self.error(f"ends after {k} of {count} numbers ({what})")
            try:
                values[k] = float(word)
            except ValueError:
                raise self.error(f"{word!r} is not a number ({what})") from None
            if not np.isfinite(values[k]):
                raise self.error(f"{word!r} is not a finite number ({what})")
        return values

    def count(self, value: float, what: str) -> int:
        if value != int(value) or not 1 <= value <= MOST_ANGLES:
            raise self.error(f"{value:g} {what} is no count")
        return int(value)

    def ascending(self, count: int, what: str) -> FloatArray:
        values = self.take(count, what)
        if (np.diff(values) <= 0).any():
            raise self.error(f"{what} do not ascend")
        return values

    def skip_tilt(self) -> None:
        """TILT changes a lamp's output with its tilt; the web itself was measured upright."""
        if self.tilt == "INCLUDE":
            _geometry, pairs = self.take(2, "tilt")
            self.take(2 * self.count(pairs, "tilt angles"), "tilt")

    def _read(self) -> Iterator[str]:
        for k in range(self.first, len(self.lines)):
            self._line = k + 1
            yield from self.lines[k].replace(",", " ").split()
