"""Rows to Arrow tables and back: exactly the columns of `bench.schema`, the same bytes for the same rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bench.errors import BenchError

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

Row = Mapping[str, object]
_KINDS: dict[str, tuple[type, ...]] = {
    "string": (str,),
    "int64": (int, np.integer),
    "float64": (float, int, np.floating, np.integer),
}


def _schema(columns: Mapping[str, str]) -> pa.Schema:
    import pyarrow as pa

    types = {"string": pa.string(), "int64": pa.int64(), "float64": pa.float64()}
    return pa.schema([(name, types[kind]) for name, kind in columns.items()])


def to_table(rows: Sequence[Row], columns: Mapping[str, str], name: str) -> pa.Table:
    """Make a table of columns in the schema's order, without metadata that would differ between equal runs.

    Parameters
    ----------
    rows : sequence of mappings
        Each with exactly the schema's columns; a metric without a meaning is NaN.
    columns : mapping of str to str
        Out of `bench.schema`: name to "string", "int64" or "float64".
    name : str
        Of the table, for errors.

    Raises
    ------
    BenchError
        For a row with other columns, or a value of another type.
    """
    import pyarrow as pa

    for number, row in enumerate(rows):
        _check_row(row, columns, f"{name} row {number}")
    schema = _schema(columns)
    arrays = []
    for column, kind in columns.items():
        values: Any = [row[column] for row in rows]
        if kind == "float64":
            values = np.array(values, dtype=np.float64)
            values[np.isnan(values)] = np.nan  # one bit pattern for all NaNs
        arrays.append(pa.array(values, type=schema.field(column).type))
    return pa.Table.from_arrays(arrays, schema=schema)


def _check_row(row: Row, columns: Mapping[str, str], where: str) -> None:
    if row.keys() != columns.keys():
        missing, extra = sorted(columns.keys() - row.keys()), sorted(row.keys() - columns.keys())
        raise BenchError(f"{where}: columns missing {missing}, unknown {extra}; see bench/schema.py")
    for column, kind in columns.items():
        value = row[column]
        if not isinstance(value, _KINDS[kind]) or isinstance(value, bool | np.bool_):
            raise BenchError(f"{where}: {column} is {value!r}, not {kind}")


def read_table(path: Path, columns: Mapping[str, str]) -> pd.DataFrame:
    """Read a table whose columns must be the schema's.

    Raises
    ------
    BenchError
        If the file cannot be read or has other columns.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(path)
    except (OSError, pa.ArrowException) as error:
        raise BenchError(f"{path}: cannot be read: {' '.join(str(error).split())}") from None
    if table.schema != _schema(columns):
        raise BenchError(f"{path}: its columns are not those of this version; make the run again")
    return table.to_pandas()
