"""The headline table: filter × condition, each number with its unit and, where it has one, its interval."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.comparison import Comparison, Condition
from reports.run import BASELINE, OK, Run
from reports.statistics import Estimate, plain
from reports.wording import interval, number, plural

if TYPE_CHECKING:
    from pandas import DataFrame

Measure = Callable[[Comparison, str, Condition], Estimate]

ALL_NEGATIVE = "all-negative mask"
DO_NOTHING = "do nothing"
MARK_NOTE = (
    "With a value its 95 % interval. ▲ better, ▼ worse than doing nothing: the interval of the paired "
    "difference excludes zero."
)
BASELINE_NOTE = (
    f"“{ALL_NEGATIVE}” and “{DO_NOTHING}” are both the filter {BASELINE}: "
    "it masks nothing and repairs nothing."
)


@dataclass(frozen=True)
class Column:
    """One number of the table.

    Attributes
    ----------
    key, title, unit : str
        ``unit`` is empty for a number without one.
    digits : int
        Decimals shown.
    measure : callable
        (comparison, filter, condition) → Estimate, already in ``unit``.
    of_mask : bool
        Whether the baseline's number belongs to the all-negative mask, not to doing nothing.
    better : str
        "higher" or "lower".
    signed : bool
        Whether it is a change, shown with its sign.
    group : str
        Heads the group that starts with this column.
    change : callable or None
        The paired difference to doing nothing, where there is one.
    """

    key: str
    title: str
    unit: str
    digits: int
    measure: Measure
    of_mask: bool = False
    better: str = "higher"
    signed: bool = False
    group: str = ""
    change: Measure | None = None

    @property
    def heading(self) -> str:
        """Title and unit: "RMSE, m"."""
        return f"{self.title}, {self.unit}" if self.unit else self.title


@dataclass(frozen=True)
class Row:
    """One filter under one condition.

    Attributes
    ----------
    label, filter : str
        Shown name, and stored name.
    cells : dict
        Column key → Estimate; a column that does not apply to the row is absent.
    changes : dict
        Column key → paired difference to doing nothing.
    failed, runs : int
        SLAM runs that failed, and all.
    """

    label: str
    filter: str
    cells: dict[str, Estimate]
    changes: dict[str, Estimate]
    failed: int
    runs: int


def _percent(value: Estimate) -> Estimate:
    return Estimate(100 * value.value, 100 * value.low, 100 * value.high, value.units, value.unit, value.note)


def _same(value: Estimate) -> Estimate:
    return value


def _run_column(key: str, title: str, unit: str, digits: int, metric: str, **options: Any) -> Column:
    """A column that comes from the SLAM runs; percent where the unit says so."""
    to_unit = _percent if unit == "%" else _same
    return Column(
        key,
        title,
        unit,
        digits,
        lambda c, f, w: to_unit(c.run_metric(f, metric, w)),
        change=lambda c, f, w: c.run_change(f, metric, w),
        **options,
    )


COLUMNS: tuple[Column, ...] = (
    Column("iou", "mask IoU", "", 3, lambda c, f, w: c.mask(f, "iou", w), of_mask=True, group="Mask"),
    Column("f1", "mask F1", "", 3, lambda c, f, w: c.mask(f, "f1", w), of_mask=True),
    Column("ap", "mask AP", "", 3, lambda c, f, w: c.mask(f, "ap", w), of_mask=True),
    Column(
        "psnr_in_mask_change",
        "in-mask PSNR change",
        "dB",
        2,
        lambda c, f, w: c.psnr_in_mask_change(f, w),
        signed=True,
        group="Picture",
        change=lambda c, f, w: c.psnr_in_mask_change(f, w),
    ),
    Column("psnr", "PSNR", "dB", 2, lambda c, f, w: c.psnr(f, w), change=lambda c, f, w: c.psnr_change(f, w)),
    Column(
        "recall",
        "landmark recall",
        "%",
        1,
        lambda c, f, w: _percent(c.recall(f, w)),
        group="Landmarks",
        change=lambda c, f, w: c.recall_change(f, w),
    ),
    Column(
        "precision",
        "landmark precision",
        "%",
        1,
        lambda c, f, w: _percent(c.precision(f, w)),
        change=lambda c, f, w: c.precision_change(f, w),
    ),
    _run_column("rmse", "RMSE", "m", 3, "rmse_m", better="lower", group="SLAM and navigation"),
    _run_column("mapped", "landmarks mapped", "", 1, "landmarks_mapped"),
    _run_column("nav_success", "nav success", "%", 1, "nav_success"),
    _run_column("nav_cost", "path cost ratio", "", 4, "nav_cost_ratio", better="lower"),
    Column(
        "filter_ms",
        "filter time",
        "ms",
        2,
        lambda c, f, w: plain(c.filter_ms(f, w)),
        better="lower",
        group="Cost",
    ),
)


def headline(run: Run, comparison: Comparison, condition: Condition = None) -> tuple[Row, ...]:
    """The rows of one condition (None: all of them pooled), the two baselines first."""
    rows: list[Row] = []
    for name in run.filters:
        cells = {column.key: column.measure(comparison, name, condition) for column in COLUMNS}
        failed, total = comparison.runs.failed(name, condition)
        if name == BASELINE:
            rows += _baselines(cells, failed, total)
        else:
            changes = {c.key: c.change(comparison, name, condition) for c in COLUMNS if c.change}
            rows.append(Row(name, name, cells, changes, failed, total))
    return tuple(rows)


def _baselines(cells: dict[str, Estimate], failed: int, total: int) -> list[Row]:
    mask = {c.key: cells[c.key] for c in COLUMNS if c.of_mask}
    rest = {c.key: cells[c.key] for c in COLUMNS if not c.of_mask}
    return [Row(ALL_NEGATIVE, BASELINE, mask, {}, 0, 0), Row(DO_NOTHING, BASELINE, rest, {}, failed, total)]


def cell_text(column: Column, row: Row) -> tuple[str, str]:
    """Value and interval of a cell as text; ("", "") where the column does not apply to the row."""
    value = row.cells.get(column.key)
    if value is None:
        return "", ""
    return (
        number(value.value, column.digits, signed=column.signed),
        interval(value, column.digits, signed=column.signed),
    )


def mark(column: Column, row: Row) -> str:
    """Whether a row is better or worse than doing nothing, where its interval can tell; otherwise empty."""
    change = row.changes.get(column.key)
    if change is None or not change.excludes_zero:
        return ""
    return "better" if (change.value > 0.0) == (column.better == "higher") else "worse"


@dataclass(frozen=True)
class Failure:
    """Why a filter failed on pictures, or its SLAM runs did ("picture", "SLAM run"), how often."""

    filter: str
    what: str
    reason: str
    count: int

    @property
    def text(self) -> str:
        """In one line."""
        return f"{self.filter}: {plural(self.count, self.what)}: {self.reason}"


def failures(run: Run) -> tuple[Failure, ...]:
    """Every reason of failure, by filter: of pictures, then of SLAM runs."""
    bad_runs = run.runs[run.runs["status"] != OK]
    return (*counted(run.failed_frames, "picture"), *counted(bad_runs, "SLAM run"))


def counted(bad: DataFrame, what: str, column: str = "status") -> tuple[Failure, ...]:
    """The reasons in rows that failed, each with how often it stands there; sorted by filter and reason."""
    reasons = Counter(zip(bad["filter"], bad[column], strict=True))
    return tuple(
        Failure(name, what, status.removeprefix("failed:").strip(), count)
        for (name, status), count in sorted(reasons.items())
    )
