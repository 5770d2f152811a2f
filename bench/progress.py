"""How a long job tells where it is. Library code knows only `Progress`; the command line draws it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Protocol

Advance = Callable[[int], None]


class Progress(Protocol):
    """Shows stages and one-line notices.

    Examples
    --------
    >>> with progress.stage("render", total=195) as advance:  # doctest: +SKIP
    ...     for frame in frames:
    ...         advance(1)
    """

    def stage(self, title: str, total: int) -> AbstractContextManager[Advance]:
        """Open a bar of ``total`` steps; call what it gives with the number of steps done."""
        ...

    def notice(self, text: str) -> None:
        """Say one line that the user should know, such as the fallback to another engine."""
        ...


class Silent:
    """Shows nothing: for tests and for use as a library."""

    @contextmanager
    def stage(self, title: str, total: int) -> Iterator[Advance]:
        """Accept the steps and show nothing."""
        yield lambda steps: None

    def notice(self, text: str) -> None:
        """Say nothing."""


class Bars:
    """Draws bars on standard error with rich; where that is no terminal, one line per finished stage."""

    def __init__(self) -> None:
        from rich.console import Console

        self._console = Console(stderr=True)

    @contextmanager
    def stage(self, title: str, total: int) -> Iterator[Advance]:
        """Draw one bar until the block ends."""
        from rich import progress

        columns = (
            progress.TextColumn("{task.description:<10}"),
            progress.BarColumn(bar_width=30),
            progress.MofNCompleteColumn(),
            progress.TimeElapsedColumn(),
        )
        with progress.Progress(*columns, console=self._console) as bars:
            task = bars.add_task(title, total=total)
            yield lambda steps: bars.advance(task, steps)

    def notice(self, text: str) -> None:
        """Print the line above the bars."""
        self._console.print(f"notice: {text}", highlight=False, markup=False, soft_wrap=True)
