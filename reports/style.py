"""One look for all figures, and how they are saved: a picture with its data beside it.

Sources
-------
Filter colours: Okabe & Ito 2008, *Color universal design*, told apart with every common colour blindness.
Heat maps: cividis (Nuñez, Anderton & Renslow 2018), even in lightness and colour-blind safe.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from reports.errors import ReportError
from reports.run import BASELINE

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

INK = "#1f2328"
MUTED = "#6a7178"
RULE = "#d4d7da"
PAPER = "#ffffff"
BASELINE_COLOUR = "#767676"
SERIES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")

RC: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "text.color": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "grid.color": RULE,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "figure.facecolor": PAPER,
    "axes.facecolor": "none",
    "savefig.facecolor": PAPER,
    "svg.fonttype": "none",
    "svg.hashsalt": "glarebench",
    "path.simplify_threshold": 0.4,
}


def filter_colours(filters: Sequence[str]) -> dict[str, str]:
    """A colour for each filter, the same in each figure of a run."""
    others = [f for f in filters if f != BASELINE]
    colours = {name: SERIES[i % len(SERIES)] for i, name in enumerate(others)}
    return {BASELINE: BASELINE_COLOUR, **colours}


def filter_label(name: str) -> str:
    """What a figure calls a filter."""
    return "none (do nothing)" if name == BASELINE else name


@contextmanager
def styled() -> Iterator[None]:
    """Draw in the house style, off screen, without touching matplotlib's global state."""
    import matplotlib

    rc: Any = RC
    with matplotlib.rc_context(rc):
        yield


def new_figure(width: float, height: float, layout: Literal["constrained"] | None = "constrained") -> Figure:
    """A figure that no window system knows of, sized in inches."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout=layout)
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, data: DataFrame, folder: Path, name: str) -> Path:
    """Write ``figures/<name>.svg`` and ``figures/<name>.csv``, aside first; returns the picture's path.

    Raises
    ------
    ReportError
        The folder cannot be written.
    """
    target = folder / "figures" / f"{name}.svg"
    try:
        target.parent.mkdir(exist_ok=True)
        aside = target.with_suffix(".svg.part")
        figure.savefig(aside, format="svg", metadata={"Date": None, "Creator": None})
        os.replace(aside, target)
        write_csv(data, target.with_suffix(".csv"))
    except OSError as error:
        raise ReportError(f"cannot write {target} ({error.strerror}): free or unlock the folder") from error
    return target


def write_csv(data: DataFrame, path: Path) -> None:
    """Write a table, aside first."""
    aside = path.with_suffix(".csv.part")
    data.to_csv(aside, index=False, lineterminator="\n")
    os.replace(aside, path)
