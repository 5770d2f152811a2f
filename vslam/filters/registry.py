"""The light filters by name. A filter is known because its module lies in this folder."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeVar

from vslam.errors import VslamError
from vslam.filters.base import LightFilter, PictureForm, wanted_form
from vslam.filters.parameters import FilterParameter, parameters_of


class UnknownFilterError(VslamError):
    """No filter has this name.

    Attributes
    ----------
    name : str
        What was asked for.
    known : tuple of str
        All names that exist, sorted.
    """

    def __init__(self, name: str, known: tuple[str, ...]) -> None:
        super().__init__(f"unknown light filter {name!r}: known are {', '.join(known)}")
        self.name = name
        self.known = known


class FilterParameterError(VslamError):
    """A filter was given a parameter that it does not have, or a value that makes no sense."""


@dataclass(frozen=True)
class FilterDescription:
    """What ``list`` shows of a filter.

    Attributes
    ----------
    name : str
    summary : str
        What it does, one line.
    source : str
        Paper and equations.
    parameters : tuple of FilterParameter
        What a study may set, in the order of their definition.
    wants : PictureForm
        The picture it takes.
    """

    name: str
    summary: str
    source: str
    parameters: tuple[FilterParameter, ...] = ()
    wants: PictureForm = PictureForm.SRGB8


@dataclass(frozen=True)
class _Entry:
    description: FilterDescription
    factory: Callable[..., LightFilter]


F = TypeVar("F", bound=Callable[..., LightFilter])
_entries: dict[str, _Entry] = {}


def register(name: str, summary: str, source: str) -> Callable[[F], F]:
    """Class decorator: make a filter known under ``name``.

    Parameters
    ----------
    name : str
        Unique, as written in studies.
    summary : str
        What it does, one line.
    source : str
        Paper and equations.

    Raises
    ------
    VslamError
        When another filter already has this name.
    """

    def add(factory: F) -> F:
        # the same class again is a reload of its module, not a clash
        taken = _entries.get(name)
        if taken is not None and _place(taken.factory) != _place(factory):
            raise VslamError(
                f"light filter {name!r} is registered twice, by {_place(taken.factory)} and "
                f"{_place(factory)}: rename one"
            )
        description = FilterDescription(name, summary, source, parameters_of(factory), wanted_form(factory))
        _entries[name] = _Entry(description, factory)
        return factory

    return add


def create(name: str, **parameters: Any) -> LightFilter:
    """Build the filter ``name``, ready to run: whatever has to be compiled is compiled here.

    Raises
    ------
    UnknownFilterError
        When there is no such filter.
    FilterParameterError
        When it has no such parameter or refuses a value.
    """
    entry = _found().get(name)
    if entry is None:
        raise UnknownFilterError(name, names())
    try:
        inspect.signature(entry.factory).bind(**parameters)
    except TypeError as error:
        raise FilterParameterError(f"light filter {name!r}: {error}") from None
    try:
        return entry.factory(**parameters)
    except (TypeError, ValueError) as error:
        raise FilterParameterError(f"light filter {name!r}: a parameter does not fit: {error}") from None


def names() -> tuple[str, ...]:
    """All names, sorted."""
    return tuple(sorted(_found()))


def describe() -> tuple[FilterDescription, ...]:
    """All filters with their summaries and sources, sorted by name."""
    return tuple(_found()[name].description for name in names())


def _place(factory: Callable[..., LightFilter]) -> str:
    return f"{factory.__module__}.{factory.__qualname__}"


def _found() -> dict[str, _Entry]:
    _import_folder()
    return _entries


@cache
def _import_folder() -> None:
    package = importlib.import_module("vslam.filters")
    for module in pkgutil.iter_modules(package.__path__):
        # sub-packages hold stages, which import numba: listing names must not wait for that
        if not module.ispkg:
            importlib.import_module(f"{package.__name__}.{module.name}")
