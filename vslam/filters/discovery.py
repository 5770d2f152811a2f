"""Filters from elsewhere: installed packages (entry points), and classes named as ``module:Class``."""

from __future__ import annotations

import importlib
import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from vslam.errors import VslamError

GROUP = "glarebench.filters"
"""The entry-point group: ``[project.entry-points."glarebench.filters"]  mine = "package.module:Mine"``."""

_CLASS = re.compile(r"^[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*$")


def is_class(name: str) -> bool:
    """Whether a filter is named as ``module:Class``."""
    return _CLASS.match(name) is not None


def is_onnx(name: str) -> bool:
    """Whether a filter is named by its ONNX file."""
    return name.lower().endswith(".onnx")


@cache
def installed() -> dict[str, EntryPoint]:
    """The filters of installed packages by name; none of them is imported here."""
    return {point.name: point for point in entry_points(group=GROUP)}


def load(name: str, where: str = "") -> Callable[..., Any]:
    """Import a class named as ``module:Class``, from the working directory or the environment.

    Parameters
    ----------
    name : str
        As matched by `is_class`.
    where : str
        Whose it is, for errors.

    Raises
    ------
    VslamError
        When the module cannot be imported, or holds no such class.
    """
    module_name, _, attribute = name.partition(":")
    shown = f"light filter {name!r}{where}"
    try:
        with _working_directory():
            module = importlib.import_module(module_name)
    except Exception as error:  # whatever a stranger's module does while it is imported
        if isinstance(error, ModuleNotFoundError) and error.name == module_name.split(".")[0]:
            raise VslamError(
                f"{shown}: there is no module {module_name!r}, neither in {os.getcwd()} nor installed"
            ) from None
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise VslamError(f"{shown}: its module cannot be imported: {reason}") from error
    factory = getattr(module, attribute, None)
    if not callable(factory):
        near = get_close_matches(attribute, vars(module), n=1, cutoff=0.5)
        hint = f"did you mean {near[0]!r}?" if near else "name a class of it"
        raise VslamError(f"{shown}: the module has no class {attribute!r}; {hint}")
    return factory  # type: ignore[no-any-return]


def summary_of(factory: Callable[..., Any]) -> str:
    """The first line of its docstring, without the full stop."""
    lines = (factory.__doc__ or "").strip().splitlines()
    return lines[0].rstrip(".") if lines else ""


@contextmanager
def _working_directory() -> Iterator[None]:
    """Import from the working directory too, whichever way the program was started."""
    here = os.getcwd()
    sys.path.insert(0, here)
    try:
        yield
    finally:
        sys.path.remove(here)
