"""The engine that a run renders with, and the notice about it."""

from __future__ import annotations

from bench.progress import Progress
from bench.run_facts import RunFacts
from renderers.engine import choose_engine


def chosen_engine(wanted: str, progress: Progress) -> RunFacts:
    """The facts of a run that renders; says on the way where another engine has to stand in.

    Raises
    ------
    RendererError
        As `renderers.engine.choose_engine`.
    """
    engine = choose_engine(wanted)
    if engine.notice:
        progress.notice(engine.notice)
    return RunFacts(engine.name, engine.notice)
