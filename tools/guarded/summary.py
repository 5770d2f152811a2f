"""Tables out of `tools.guarded.evaluate`'s rows, with 95 % intervals from resampled poses."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import pandas as pd
from numpy.typing import NDArray

DRAWS, SEED = 2000, 0
POSE = ["place", "frame"]
Statistic = Callable[[pd.DataFrame], "pd.Series[float]"]


def report(rows: pd.DataFrame, split: str) -> str:
    """All tables as Markdown."""
    lit, matt = rows[~rows["matt"]], rows[rows["matt"]]
    places = ", ".join(sorted(rows["place"].unique()))
    poses = len(rows[POSE].drop_duplicates())
    strongest = lit[lit["light"].map(_strength) == lit.groupby("family")["light"].transform(_strongest)]
    return "\n\n".join(
        [
            f"# Split `{split}`: {places}; {poses} poses, {len(lit) // _filters(rows)} pictures",
            "## Detection and repair, all lights\n" + _table(lit, _overall(lit)),
            "## By family: mean IoU\n" + _pivot(lit, "family", "iou", np.nanmean),
            "## By family: PSNR inside the true mask, dB\n"
            + _pivot(lit, "family", "psnr_in_mask_db", _mean_db),
            "## Change of whole-frame PSNR against doing nothing, dB, worst condition (place × light)\n"
            + _worst(lit, "psnr_db", _mean_db),
            "## White and grey objects: change of PSNR, dB, worst condition\n"
            + _worst(lit.assign(db=_to_db(lit["colourless_mse"])), "db", _mean_db),
            "## Pictures free of highlights (recorded without specular light)\n" + _harm(matt),
            "## Pictures whose true mask is empty\n" + _harm(lit[lit["true_share"] == 0]),
            "## Landmark recall under the strongest light\n"
            + "\n\n".join(_recall(group, family) for family, group in strongest.groupby("family")),
        ]
    )


def _filters(rows: pd.DataFrame) -> int:
    return rows["filter"].nunique()


def _strength(light: str) -> float:
    """Sun first, then lamps: of a name such as ``sun90000-bulb1600``."""
    sun, bulb = light.split("-")[:2]
    return float(sun.removeprefix("sun")) * 1e7 + float(bulb.removeprefix("bulb"))


def _strongest(lights: pd.Series[str]) -> float:
    return max(map(_strength, lights))


def _to_db(mse: pd.Series[float]) -> pd.Series[float]:
    with np.errstate(divide="ignore"):
        return 10 * np.log10(255**2 / mse)


def _mean_db(values: Iterable[float]) -> float:
    """As `bench.metrics.restoration.mean_psnr_db`."""
    mse = 10 ** (-np.asarray(values, dtype=float) / 10)
    return float(-10 * np.log10(np.nanmean(mse))) if np.isfinite(mse).any() else float("nan")


def _overall(rows: pd.DataFrame) -> dict[str, Statistic]:
    by = "filter"
    return {
        "IoU": lambda r: r.groupby(by)["iou"].mean(),
        "AP": lambda r: r.groupby(by)["ap"].mean(),
        "masked %": lambda r: 100 * r.groupby(by)["masked_share"].mean(),
        "PSNR dB": lambda r: r.groupby(by)["psnr_db"].apply(_mean_db),
        "in mask dB": lambda r: r.groupby(by)["psnr_in_mask_db"].apply(_mean_db),
        "recall %": lambda r: 100 * r.groupby(by)["detected"].sum() / r.groupby(by)["visible"].sum(),
        "ms": lambda r: r.groupby(by)["ms"].median(),
    }


def _table(rows: pd.DataFrame, statistics: dict[str, Statistic]) -> str:
    """One row a filter, each value with its interval."""
    sums = _Resampled(rows)
    lines = {name: [f"`{name}`"] for name in sums.names}
    for statistic in statistics.values():
        values = statistic(rows)
        spread = sums.interval(statistic)
        for name in lines:
            low, high = spread[name]
            lines[name].append(f"{values[name]:.3g} ({low:.3g} … {high:.3g})")
    return _markdown(["filter", *statistics], lines.values())


class _Resampled:
    """The rows of each pose, and which poses each draw takes."""

    def __init__(self, rows: pd.DataFrame, draws: int = 300) -> None:
        self.names = list(dict.fromkeys(rows["filter"]))
        self._groups = [group for _, group in rows.groupby(POSE, sort=True)]
        rng = np.random.default_rng(SEED)
        self._draws = rng.integers(len(self._groups), size=(draws, len(self._groups)))

    def interval(self, statistic: Statistic) -> dict[str, NDArray[np.float64]]:
        """95 % of each filter's statistic."""
        drawn = [statistic(pd.concat([self._groups[k] for k in draw])) for draw in self._draws]
        table = pd.DataFrame(drawn)
        return {name: np.nanpercentile(table[name], [2.5, 97.5]) for name in self.names}


def _pivot(rows: pd.DataFrame, by: str, value: str, mean: Callable[[pd.Series[float]], float]) -> str:
    table = (
        rows.groupby(["filter", by])[value].apply(mean).unstack(by).loc[list(dict.fromkeys(rows["filter"]))]
    )
    lines = [[f"`{name}`", *(f"{v:.3g}" for v in line)] for name, line in table.iterrows()]
    return _markdown(["filter", *table.columns], lines)


def _worst(rows: pd.DataFrame, value: str, mean: Callable[[pd.Series[float]], float]) -> str:
    """Of each filter: where it loses most against doing nothing, and in how many conditions it loses."""
    rows = rows[np.isfinite(rows[value])]
    table = rows.groupby(["filter", "place", "light"])[value].apply(mean).unstack("filter")
    change = table.sub(table["none"], axis=0)
    lines = [
        [
            f"`{name}`",
            f"{change[name].min():+.2f}",
            " ".join(change[name].idxmin()),
            f"{(change[name] < -0.005).sum()} of {len(change)}",
            f"{change[name].mean():+.2f}",
        ]
        for name in dict.fromkeys(rows["filter"])
    ]
    return _markdown(["filter", "worst", "where", "worse in", "mean change"], lines)


def _harm(rows: pd.DataFrame) -> str:
    if rows.empty:
        return "none"
    none = rows[rows["filter"] == "none"]
    before = 100 * none["detected"].sum() / none["visible"].sum()
    lines = []
    for name, own in rows.groupby("filter", sort=False):
        recall = 100 * own["detected"].sum() / own["visible"].sum()
        lines.append(
            [
                f"`{name}`",
                f"{100 * own['masked_share'].mean():.3f}",
                f"{100 * own['masked_share'].max():.2f}",
                f"{recall:.2f}",
                f"{recall - before:+.2f}",
            ]
        )
    return f"{len(none)} pictures\n\n" + _markdown(
        ["filter", "masked %", "most masked %", "recall %", "change"], lines
    )


def _recall(rows: pd.DataFrame, family: str) -> str:
    wide = rows.pivot_table(index=POSE, columns="filter", values="detected", aggfunc="sum")
    seen = rows[rows["filter"] == "none"].groupby(POSE)["visible"].sum().loc[wide.index].to_numpy()
    rng = np.random.default_rng(SEED)
    draws = rng.integers(len(seen), size=(DRAWS, len(seen)))
    lines = []
    for name in dict.fromkeys(rows["filter"]):
        gained = (wide[name] - wide["none"]).to_numpy()
        low, high = np.percentile(100 * gained[draws].sum(1) / seen[draws].sum(1), [2.5, 97.5])
        lines.append(
            [
                f"`{name}`",
                f"{100 * wide[name].sum() / seen.sum():.1f}",
                f"{100 * gained.sum() / seen.sum():+.1f} ({low:+.1f} … {high:+.1f})",
            ]
        )
    heading = (
        f"{family}: {', '.join(sorted(rows['light'].unique()))}, {len(seen)} poses, {seen.sum():.0f} visible"
    )
    return heading + "\n\n" + _markdown(["filter", "recall %", "change"], lines)


def _markdown(heading: list[str], lines: Iterable[list[str]]) -> str:
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (heading, ["---"] * len(heading), *lines))
