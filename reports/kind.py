"""What a report does differently for each kind of study: ``KIND`` of ``reports/page_<sequence>.py``."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING

from reports.errors import ReportError

if TYPE_CHECKING:
    from rich.console import RenderableType

    from reports.page import Page
    from reports.run import Run
    from reports.tables import Failure


@dataclass(frozen=True)
class Kind:
    """How runs of one kind of study are told.

    Attributes
    ----------
    compose : callable
        Draws the figures and lays out the page.
    summary : callable
        The run in a terminal of 100 columns.
    failures : callable
        What failed in it, so that the program can exit accordingly.
    filtered : bool
        Whether such a run filters pictures: it then has frames, and among them the baseline's.
    rendered : bool
        Whether its pictures are rendered, by an engine that the page names.
    """

    compose: Callable[[Run], Page]
    summary: Callable[[Run], RenderableType]
    failures: Callable[[Run], tuple[Failure, ...]]
    filtered: bool = True
    rendered: bool = False


def kind_of(sequence: str) -> Kind:
    """The kind of a study by its key ``sequence``.

    Raises
    ------
    ReportError
        When no page tells of such studies.
    """
    name = f"reports.page_{sequence}"
    if not sequence.isidentifier() or find_spec(name) is None:
        raise ReportError(f"studies of the kind {sequence!r} have no report: update glarebench")
    kind: Kind = importlib.import_module(name).KIND
    return kind
