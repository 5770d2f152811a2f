"""Back-ends compared on drives: one group of repetitions for each drive and back-end."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports import style
from reports.run import OK, Run, records
from reports.wording import number, plural

if TYPE_CHECKING:
    from pandas import DataFrame

FloatArray = NDArray[np.float64]

POSE_DOF = 3


@dataclass(frozen=True, eq=False)
class Group:
    """All repetitions of one back-end on one drive.

    Attributes
    ----------
    scene, label, colour : str
    rows : DataFrame
        Those that went through, ``bench.schema.RUN_COLUMNS``.
    failures : tuple of str
        Statuses of the others.
    """

    scene: str
    label: str
    colour: str
    rows: DataFrame
    failures: tuple[str, ...]

    def values(self, column: str) -> FloatArray:
        """What is known of a column."""
        values = self.rows[column].to_numpy(np.float64)
        return values[np.isfinite(values)]


def groups(run: Run, scene: str) -> tuple[Group, ...]:
    """Back-ends on a drive, in the order they were run."""
    table = run.runs[run.runs["scene"] == scene]
    made = []
    for i, label in enumerate(dict.fromkeys(table["backend"])):
        rows = table[table["backend"] == label]
        bad = tuple(str(s) for s in rows["status"] if s != OK)
        colour = style.SERIES[i % len(style.SERIES)]
        made.append(Group(scene, str(label), colour, rows[rows["status"] == OK], bad))
    return tuple(made)


def scenes(run: Run) -> tuple[str, ...]:
    """Drives in the order of the study."""
    return tuple(dict.fromkeys(str(s) for s in run.runs["scene"]))


def bound_m(run: Run, scene: str) -> float:
    """Cramér–Rao bound on the position RMSE, mean over the repetitions; NaN where there is none."""
    values = run.runs.loc[run.runs["scene"] == scene, "bound_m"].dropna()
    return float(values.mean()) if len(values) else nan


def nees_band(repetitions: int) -> tuple[float, float]:
    """95 % band of the mean NEES of independent repetitions at one step (χ² of 3 each)."""
    from scipy.stats import chi2

    low, high = (float(chi2.ppf(p, df=POSE_DOF * repetitions)) / repetitions for p in (0.025, 0.975))
    return low, high


@dataclass(frozen=True)
class BackendColumn:
    """One number of the table."""

    title: str
    key: str
    digits: int


COLUMNS = (
    BackendColumn("RMSE, m", "rmse_m", 3),
    BackendColumn("RMSE after SE(2) alignment (ATE), m", "rmse_aligned_m", 3),
    BackendColumn("RPE over 10 steps, m", "rpe_m", 3),
    BackendColumn("RPE over 10 steps, °", "rpe_deg", 2),
    BackendColumn("landmark RMSE, m", "landmark_rmse_m", 3),
    BackendColumn("NEES (3 ideal)", "nees", 2),
    BackendColumn("landmarks mapped", "landmarks_mapped", 0),
    BackendColumn("ms per step", "step_ms", 2),
    BackendColumn("memory, MB", "memory_mb", 2),
)


def shown(group: Group, column: BackendColumn) -> tuple[str, str]:
    """Mean over the repetitions, and their smallest and largest value where there are several."""
    values = group.values(column.key)
    if not len(values):
        return "", ""
    spread = ""
    if len(values) > 1 and np.ptp(values) > 0.0:
        spread = f"{number(values.min(), column.digits)} … {number(values.max(), column.digits)}"
    return number(float(values.mean()), column.digits), spread


def verdict(run: Run) -> str:
    """One sentence per drive: the best online back-end beside the bound, and the textbook EKF."""
    return " ".join(filter(None, (_sentence(run, scene) for scene in scenes(run))))


def _sentence(run: Run, scene: str) -> str:
    every = groups(run, scene)
    lost = sum(len(g.failures) for g in every)
    online = [g for g in every if len(g.rows) and not g.label.endswith("_smoothed")]
    if not online:
        return f"On {scene} none of the {plural(lost, 'run')} went through."
    best = min(online, key=_mean_rmse)
    parts = [f"On {scene} {best.label} is nearest online, {number(_mean_rmse(best), 3)} m"]
    bound = bound_m(run, scene)
    if np.isfinite(bound):
        parts.append(f" (bound {number(bound, 3)} m)")
    others = [g for g in every if g.label == "ekf" and g is not best and len(g.rows)]
    others += [g for g in every if g.label.endswith("_smoothed") and len(g.rows)]
    parts += [f"; {g.label} {number(_mean_rmse(g), 3)} m" for g in others]
    return "".join(parts) + (f"; {plural(lost, 'run')} failed." if lost else ".")


def _mean_rmse(group: Group) -> float:
    return float(group.values("rmse_m").mean())


def simulates_dissertation(run: Run, scene: str | None = None) -> bool:
    """Whether a drive has a virtual sensor in the building, as the dissertation has."""
    drives: Any = run.study.get("drives") or ()
    return any(
        isinstance(drive, dict)
        and drive.get("source") == "virtual"
        and scene in (None, drive.get("name", scene))
        for drive in drives
    )


def truth_fed(run: Run) -> tuple[str, ...]:
    """Names of drives whose odometry was fed by the truth."""
    drives: Any = run.study.get("drives") or ()
    return tuple(
        str(drive.get("name"))
        for drive in drives
        if isinstance(drive, dict) and (drive.get("odometry") or {}).get("protocol") == "truth_fed"
    )


def frame(run: Run, scene: str) -> DataFrame:
    """Position RMSE of every repetition, for the figure: back-end, seed, rmse_m, bound_m."""
    import pandas as pd

    rows = [
        (g.label, int(r["seed"]), float(r["rmse_m"]), float(r["bound_m"]))
        for g in groups(run, scene)
        for r in records(g.rows)
    ]
    return pd.DataFrame(rows, columns=["backend", "seed", "rmse_m", "bound_m"])
