"""The runs over the DLR log: one for each association and observation form, and their table."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import nan
from typing import Any

from reports import dissertation, style
from reports.run import OK, Run, records
from reports.wording import MISSING, listing, number, plural


@dataclass(frozen=True, eq=False)
class DlrRun:
    """One run over the log.

    Attributes
    ----------
    label, colour : str
    row : mapping
        ``bench.schema.RUN_COLUMNS``.
    """

    label: str
    colour: str
    row: Mapping[str, Any]

    @property
    def ok(self) -> bool:
        """Whether it went through."""
        return bool(self.row["status"] == OK)


def dlr_runs(run: Run) -> tuple[DlrRun, ...]:
    """All runs in the order they are stored, named by what tells them apart."""
    rows = records(run.runs)
    always = ("association", "observation")
    varying = tuple(k for k in ("filter", "backend", "seed") if len({r[k] for r in rows}) > 1)
    return tuple(
        DlrRun(
            " · ".join(str(row[k]).replace("_", "-") for k in (*always, *varying)),
            style.SERIES[i % len(style.SERIES)],
            row,
        )
        for i, row in enumerate(rows)
    )


def bound_m(run: Run) -> float:
    """Cramér–Rao bound on the position RMSE of any online estimator, metres; NaN where none is stored."""
    values = run.runs["bound_m"].dropna()
    return float(values.mean()) if len(values) else nan


@dataclass(frozen=True)
class DlrColumn:
    """One number of the table: how it reads for a run, and for a published result."""

    title: str
    ours: Callable[[Mapping[str, Any]], str]
    theirs: Callable[[dissertation.Published], str]


def _value(key: str, digits: int) -> Callable[[Mapping[str, Any]], str]:
    return lambda row: number(float(row.get(key, nan)), digits)


def _nothing(_: dissertation.Published) -> str:
    return ""


def _mapped(row: Mapping[str, Any]) -> str:
    return f"{row['landmarks_mapped']} of {row['landmarks_total']}"


def _association(row: Mapping[str, Any]) -> str:
    precision, recall = row["association_precision"], row["association_recall"]
    return f"{number(precision, 3)} / {number(recall, 3)}"


COLUMNS: tuple[DlrColumn, ...] = (
    DlrColumn("RMSE, m", _value("rmse_m", 3), lambda p: number(p.rmse_m, 2)),
    DlrColumn("RMSE after SE(2) alignment, m", _value("rmse_aligned_m", 3), _nothing),
    DlrColumn("max squared error X, m²", _value("sq_err_x_max", 3), lambda p: number(p.sq_err_x_max, 3)),
    DlrColumn("max squared error Y, m²", _value("sq_err_y_max", 3), lambda p: number(p.sq_err_y_max, 3)),
    DlrColumn("landmarks mapped", _mapped, lambda p: p.landmarks or MISSING),
    DlrColumn("duplicates", lambda row: str(row["landmarks_duplicated"]), _nothing),
    DlrColumn("NEES", _value("nees", 1), _nothing),
    DlrColumn("association precision / recall", _association, _nothing),
)


def verdict(run: Run) -> str:
    """One sentence: where each run over the log ended."""
    good = [r for r in dlr_runs(run) if r.ok]
    failed = len(run.runs) - len(good)
    if not good:
        return f"None of the {plural(failed, 'run')} over the DLR log went through."
    parts = [
        f"{number(r.row['rmse_m'], 3)} m ({r.label}; {number(r.row['rmse_aligned_m'], 3)} m after alignment, "
        f"{_mapped(r.row)} landmarks mapped, {plural(int(r.row['landmarks_duplicated']), 'duplicate')})"
        for r in good
    ]
    lost = f"; {plural(failed, 'run')} failed" if failed else ""
    return f"Against the log's reference track, EKF-SLAM ends with a position RMSE of {listing(parts)}{lost}."
