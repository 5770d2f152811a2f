"""Errors that the command line turns into one line and exit code 2."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class BenchError(Exception):
    """What is wrong, where, and what to do about it, in one line."""


def unknown_name(kind: str, name: str, known: Iterable[str]) -> BenchError:
    """The error for a name that no registry holds, with the nearest known names.

    Parameters
    ----------
    kind : str
        What was looked up ("scene", "filter", "study").
    name : str
        What the user asked for.
    known : iterable of str
        All names that exist.
    """
    names = sorted(known)
    near = get_close_matches(name, names, n=2, cutoff=0.5)
    hint = f"did you mean {' or '.join(repr(n) for n in near)}?" if near else f"known: {', '.join(names)}"
    return BenchError(f"unknown {kind} {name!r}: {hint}")
