"""The light filters by name: known because their module lies in this folder, or by an entry point."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, TypeVar

from vslam.errors import VslamError
from vslam.filters import discovery
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

    Parameters
    ----------
    name : str
        A registered name, a class as ``module:Class``, or the path of an ONNX file
        (`vslam.filters.onnx_file`).
    **parameters
        Of the filter.

    Raises
    ------
    UnknownFilterError
        When there is no such filter.
    FilterParameterError
        When it has no such parameter or refuses a value.
    VslamError
        When it cannot be loaded or built.
    """
    factory = _factory(name)
    try:
        inspect.signature(factory).bind(**parameters)
    except TypeError as error:
        raise FilterParameterError(f"light filter {name!r}: {error}") from None
    try:
        light_filter = factory(**parameters)
    except (TypeError, ValueError) as error:
        raise FilterParameterError(f"light filter {name!r}: a parameter does not fit: {error}") from None
    except VslamError:
        raise
    except Exception as error:  # whatever a plug-in does while it is built
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise VslamError(f"light filter {name!r} cannot be built: {reason}") from error
    if not callable(light_filter):
        raise VslamError(f"light filter {name!r}: what it builds cannot be called with a picture")
    wanted_form(light_filter)
    return light_filter


def names() -> tuple[str, ...]:
    """All registered names, sorted: of this folder and of installed packages."""
    return tuple(sorted({*_found(), *discovery.installed()}))


def describe() -> tuple[FilterDescription, ...]:
    """All registered filters, sorted by name; an installed one that cannot be loaded says so."""
    return tuple(_described(name) for name in names())


def parameters(name: str) -> tuple[FilterParameter, ...]:
    """What the filter ``name``, as `create` takes it, can be given.

    Raises
    ------
    VslamError
        As `create` does for the name.
    """
    return parameters_of(_factory(name))


def _factory(name: str) -> Callable[..., LightFilter]:
    if discovery.is_onnx(name):
        from vslam.filters.onnx_file import OnnxFilter

        return partial(OnnxFilter, name)
    if discovery.is_class(name):
        return discovery.load(name)
    _load_installed(name)
    entry = _found().get(name)
    if entry is None:
        raise UnknownFilterError(name, names())
    return entry.factory


def _load_installed(name: str) -> None:
    """Register the filter of an installed package, unless its module does so when it is imported."""
    point = discovery.installed().get(name)
    if point is None:
        return
    owner = f" of the package {point.dist.name!r}" if point.dist else ""
    factory = discovery.load(f"{point.module}:{point.attr}", owner)
    entry = _found().get(name)
    if entry is None or entry.factory is not factory:
        register(name, discovery.summary_of(factory), f"plug-in{owner}")(factory)


def _described(name: str) -> FilterDescription:
    try:
        _load_installed(name)
    except VslamError as error:
        return FilterDescription(name, f"cannot be loaded: {error}", "plug-in")
    return _found()[name].description


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
