"""A stored run folder, read and checked once; everything else in the room starts from it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bench.schema import FRAME_COLUMNS, RUN_COLUMNS
from reports.errors import ReportError
from reports.kind import kind_of

if TYPE_CHECKING:
    from pandas import DataFrame, Series

BASELINE = "none"
"""The filter that does nothing: the do-nothing picture and the all-negative mask at once."""

OK = "ok"


@dataclass(frozen=True, eq=False)
class Run:
    """What a run left behind.

    Attributes
    ----------
    folder : Path
        Where it lies.
    study, provenance : mapping
        ``study.yaml`` and ``provenance.json`` as parsed.
    frames : DataFrame
        ``bench.schema.FRAME_COLUMNS`` of the pictures that were filtered; empty for a study without pictures.
    failed_frames : DataFrame
        The same of pictures that a filter failed on.
    runs : DataFrame
        ``bench.schema.RUN_COLUMNS``.
    filters : tuple of str
        In the study's order, the baseline first.
    """

    folder: Path
    study: Mapping[str, Any]
    provenance: Mapping[str, Any]
    frames: DataFrame
    failed_frames: DataFrame
    runs: DataFrame
    filters: tuple[str, ...]

    @property
    def sequence(self) -> str:
        """The kind of study (`reports.kind`)."""
        return str(self.study.get("sequence"))

    @property
    def title(self) -> str:
        """What the page is called."""
        return str(self.study.get("title") or self.study.get("name") or self.folder.name)

    @property
    def description(self) -> str:
        """What the study is about, or an empty string."""
        return str(self.study.get("description") or "")

    @property
    def light_filters(self) -> tuple[str, ...]:
        """The filters without the baseline."""
        return tuple(f for f in self.filters if f != BASELINE)

    @property
    def scenes(self) -> tuple[str, ...]:
        """Names of the scenes, sorted."""
        return tuple(sorted({*self.frames["scene"], *self.runs["scene"]}))

    def in_scene(self, scene: str) -> Run:
        """What was measured in one scene."""

        def there(table: DataFrame) -> DataFrame:
            return _part(table, table["scene"] == scene)

        return replace(
            self,
            frames=there(self.frames),
            failed_frames=there(self.failed_frames),
            runs=there(self.runs),
        )


def load(folder: Path) -> Run:
    """Read and check a run folder.

    Parameters
    ----------
    folder : Path
        A folder of ``results/``.

    Raises
    ------
    ReportError
        A file is missing or damaged, or the baseline was not run.
    """
    if not folder.is_dir():
        raise ReportError(f"no run folder at {folder}: give a folder that `python -m bench run` wrote")
    study = _study(folder / "study.yaml")
    filtered = kind_of(str(study.get("sequence"))).filtered
    runs = read_table(folder / "runs.parquet", RUN_COLUMNS)
    frames = _frames(folder / "frames.parquet", optional=not filtered)
    filters = _filter_order(study, frames, runs)
    if filtered and BASELINE not in filters:
        raise ReportError(
            f"{folder} has no rows of the filter {BASELINE!r} to compare with: add it to the study's filters"
        )
    good = frames["status"] == OK
    provenance = _provenance(folder / "provenance.json")
    return Run(folder, study, provenance, _part(frames, good), _part(frames, ~good), runs, filters)


def records(table: DataFrame) -> list[dict[str, Any]]:
    """The rows of a table as dictionaries."""
    return [{str(key): value for key, value in row.items()} for row in table.to_dict("records")]


def _study(path: Path) -> Mapping[str, Any]:
    import yaml

    try:
        study = yaml.safe_load(_text(path))
    except yaml.YAMLError as error:
        raise _damaged(path, "is not YAML") from error
    if not isinstance(study, dict):
        raise _damaged(path, "holds no mapping")
    return study


def _provenance(path: Path) -> Mapping[str, Any]:
    try:
        provenance = json.loads(_text(path))
    except json.JSONDecodeError as error:
        raise _damaged(path, f"is not JSON (line {error.lineno})") from error
    if not isinstance(provenance, dict):
        raise _damaged(path, "holds no object")
    return provenance


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise ReportError(f"{path} is missing: run the study again") from error
    except (OSError, UnicodeDecodeError) as error:
        raise _damaged(path, "cannot be read") from error


def _frames(path: Path, *, optional: bool) -> DataFrame:
    if optional and not path.exists():
        return _empty(FRAME_COLUMNS)
    frames = read_table(path, FRAME_COLUMNS)
    if frames.empty and not optional:
        raise _damaged(path, "has no rows")
    return frames


def _empty(columns: dict[str, str]) -> DataFrame:
    import pandas as pd

    return pd.DataFrame({name: pd.Series(dtype=np.dtype(object)) for name in columns})


def read_table(path: Path, columns: dict[str, str]) -> DataFrame:
    """Read a Parquet file of the run folder and check its columns and types.

    Raises
    ------
    ReportError
        When it is missing or damaged.
    """
    import pandas as pd
    import pyarrow as pa

    if not path.exists():
        raise ReportError(f"{path} is missing: run the study again")
    try:
        table = pd.read_parquet(path, engine="pyarrow")
    except (OSError, pa.ArrowException) as error:
        raise _damaged(path, "is no readable Parquet file") from error
    missing = [name for name in columns if name not in table.columns]
    if missing:
        raise _damaged(path, f"lacks the column{'s' * (len(missing) > 1)} {', '.join(missing)}")
    return _typed(table, columns, path)


def _part(table: DataFrame, chosen: Series) -> DataFrame:
    return table[chosen].reset_index(drop=True)


def _typed(table: DataFrame, columns: dict[str, str], path: Path) -> DataFrame:
    """The table with numbers as numbers; strings keep whatever type pandas gave them."""
    table = table.copy()
    for name, kind in columns.items():
        if kind == "string":
            if table[name].isna().any():
                raise _damaged(path, f"has an empty field in column {name}")
            table[name] = table[name].astype(str)
            continue
        try:
            table[name] = table[name].astype(np.dtype(kind))
        except (TypeError, ValueError) as error:
            raise _damaged(path, f"has a value in column {name} that is no {kind}") from error
    return table.reset_index(drop=True)


def _damaged(path: Path, why: str) -> ReportError:
    return ReportError(f"{path} {why}: run the study again")


def _filter_order(study: Mapping[str, Any], frames: DataFrame, runs: DataFrame) -> tuple[str, ...]:
    present = {*frames["filter"], *runs["filter"]}
    listed = [_name(entry) for entry in study.get("filters") or ()]
    order = [BASELINE, *listed, *sorted(present)]
    return tuple(name for name in dict.fromkeys(order) if name in present)


def _name(entry: object) -> str:
    """A study lists a filter by name, or as a mapping; rows carry the label, by default the name."""
    return str(entry.get("label") or entry.get("name", "")) if isinstance(entry, dict) else str(entry)
