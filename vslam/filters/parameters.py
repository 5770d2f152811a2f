"""What a filter can be given: read from its signature and its docstring, so that nothing is said twice."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

NO_DEFAULT = inspect.Parameter.empty
"""The default of a parameter that has none."""

_ENTRY = re.compile(r"^(?P<names>\w+(?:, \w+)*) : .+$")  # numpydoc: "patch : int", "low, high : float"
_SECTIONS = ("Attributes", "Parameters")


@dataclass(frozen=True)
class FilterParameter:
    """A parameter of a filter.

    Attributes
    ----------
    name : str
    type : str
        As annotated; empty where it is not.
    default : object
        `NO_DEFAULT` where it has none.
    meaning : str
        One line, from the docstring's section "Attributes" or "Parameters"; empty where it says nothing.
    """

    name: str
    type: str
    default: Any
    meaning: str


def parameters_of(factory: Callable[..., Any]) -> tuple[FilterParameter, ...]:
    """The parameters that a class, or another callable that builds a filter, can be given by name."""
    meanings: dict[str, str] = {}
    for one in reversed(inspect.getmro(factory) if isinstance(factory, type) else (factory,)):
        meanings |= _meanings(inspect.cleandoc(one.__doc__ or ""))
    by_name = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    return tuple(
        FilterParameter(p.name, _type(p.annotation), p.default, meanings.get(p.name, ""))
        for p in inspect.signature(factory).parameters.values()
        if p.kind in by_name
    )


def _type(annotation: Any) -> str:
    if annotation is inspect.Parameter.empty:
        return ""
    return annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)


def _meanings(doc: str) -> dict[str, str]:
    """What numpydoc sections say about each name, on one line."""
    lines = doc.splitlines()
    meanings: dict[str, list[str]] = {}
    inside, current = False, []  # type: bool, list[str]
    for number, line in enumerate(lines):
        if number + 1 < len(lines) and set(lines[number + 1].strip()) == {"-"}:
            inside, current = line.strip() in _SECTIONS, []
            continue
        entry = _ENTRY.match(line)
        if inside and entry:
            current = []
            meanings |= dict.fromkeys(entry["names"].split(", "), current)
        elif inside and line.startswith(" "):
            current.append(line.strip())
    return {name: " ".join(text) for name, text in meanings.items()}
