"""Strict reading of text files row by row: what is malformed is named by file and line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bench.errors import BenchError

FloatArray = NDArray[np.float64]

# Line number and fields of each row.
Rows = list[tuple[int, list[str]]]

REMEDY = "get the log with: python -m bench fetch dlr"


def lines(path: Path) -> list[str]:
    """Read all lines of a text file.

    Raises
    ------
    BenchError
        When it is missing or no ASCII text.
    """
    try:
        return path.read_text(encoding="ascii").splitlines()
    except UnicodeDecodeError as error:
        raise BenchError(f"cannot read {path}: it is not a plain text file; {REMEDY}") from error
    except OSError as error:
        raise BenchError(
            f"cannot read {path}: {error.strerror}; {REMEDY}, or name its folder with --data"
        ) from error


def csv_rows(path: Path, header: str) -> Rows:
    """Rows of a comma-separated file with exactly this header.

    Raises
    ------
    BenchError
        For another header or number of fields.
    """
    text = lines(path)
    if not text or text[0].strip() != header:
        fail(path, 1, f"expected the header {header!r}")
    rows = [(number, line.split(",")) for number, line in enumerate(text[1:], start=2) if line.strip()]
    for number, fields in rows:
        expect(path, number, "the row", fields, header.count(",") + 1)
    return rows


def list_rows(path: Path, count: int) -> Rows:
    """Rows that are bracketed lists of ``count`` numbers, as JSON.

    Raises
    ------
    BenchError
        For anything else.
    """
    rows: Rows = []
    for number, line in enumerate(lines(path), start=1):
        if not line.strip():
            continue
        try:
            fields = json.loads(line, parse_float=str, parse_int=str, parse_constant=str)
        except ValueError:
            fail(path, number, "not a bracketed list of numbers")
        if not isinstance(fields, list) or not all(isinstance(f, str) for f in fields):
            fail(path, number, "not a bracketed list of numbers")
        expect(path, number, "the list", fields, count)
        rows.append((number, fields))
    return rows


def values(path: Path, rows: Rows) -> FloatArray:
    """Turn rows of one length into (n, k) float64.

    Raises
    ------
    BenchError
        Naming the first field that is no finite number, or when there are no rows.
    """
    if not rows:
        raise BenchError(f"{path}: no data rows; {REMEDY}")
    try:
        numbers = np.array([fields for _, fields in rows], dtype=np.float64)
    except ValueError:
        number, field = next((n, f) for n, fields in rows for f in fields if not _is_number(f))
        fail(path, number, f"{field!r} is not a number")
    refuse(path, rows, ~np.isfinite(numbers).all(axis=1), "a value is not finite")
    return numbers


def expect(path: Path, number: int, what: str, fields: list[str], count: int) -> None:
    """Check the number of fields of a row.

    Raises
    ------
    BenchError
    """
    if len(fields) != count:
        fail(path, number, f"{what} has {len(fields)} fields, expected {count}")


def refuse(path: Path, rows: Rows, bad: ArrayLike, reason: str) -> None:
    """Name the first row for which ``bad`` is true, if any.

    Raises
    ------
    BenchError
    """
    if np.any(bad):
        fail(path, rows[int(np.argmax(bad))][0], reason)


def fail(path: Path, number: int, reason: str) -> NoReturn:
    """Name file and line.

    Raises
    ------
    BenchError
    """
    raise BenchError(f"{path}, line {number}: {reason}")


def _is_number(field: str) -> bool:
    try:
        np.array([field], dtype=np.float64)
    except ValueError:
        return False
    return True
