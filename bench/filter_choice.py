"""The light filters that a study chooses: by name, by class or by file, with parameters, swept or not."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import PurePath
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, TypeAdapter, ValidationError, model_validator

from bench.errors import BenchError
from bench.study_errors import reason
from bench.study_parts import Part, distinct
from vslam.errors import VslamError
from vslam.filters import discovery, registry

_NAME = re.compile(r"^[a-z0-9][a-z0-9_-]*$")
BASELINE = "none"
ALL = "all"


def _filter_name(name: str) -> str:
    if _NAME.match(name) or discovery.is_class(name) or discovery.is_onnx(name):
        return name
    raise ValueError(
        f"{name!r} should be a name of small letters, digits, - and _, a class as module:Class, "
        "or the path of an .onnx file"
    )


class FilterChoice(Part):
    """A light filter (`vslam.filters`), its parameters, and the label of its rows.

    ``name`` is a registered name, ``module:Class`` (from the folder that the program is started in, or
    installed), or the path of an ONNX file. The label is by default the name, the class's name in small
    letters, or the file's name without its suffix.
    """

    name: Annotated[str, AfterValidator(_filter_name)]
    parameters: dict[str, Any] = Field(default_factory=dict)
    label: Annotated[str, Field(pattern=r"^[a-z0-9][A-Za-z0-9_.=,+ -]*$")] = ""

    @model_validator(mode="before")
    @classmethod
    def _from_name_alone(cls, value: Any) -> Any:
        value = {"name": value} if isinstance(value, str) else value
        if isinstance(value, dict) and isinstance(value.get("name"), str):
            return {**value, "label": value.get("label") or _label(value["name"])}
        return value


def _label(name: str) -> str:
    if discovery.is_onnx(name):
        return _plain(PurePath(name).stem)
    return name if _NAME.match(name) else _plain(name.rpartition(":")[2])


def _plain(text: str) -> str:
    """As the label of a row and part of a file's name."""
    return re.sub(r"[^a-z0-9_-]+", "-", text.lower()).strip("-_") or "filter"


def _swept(filters: Any) -> Any:
    """A parameter with a list of values, where it takes one value, stands for one filter for each of them."""
    if filters == ALL:
        filters = list(registry.names())
    if not isinstance(filters, list | tuple):
        return filters
    return [variant for choice in filters for variant in _variants(choice)]


def _variants(choice: Any) -> Iterator[Any]:
    parameters = choice.get("parameters") if isinstance(choice, dict) else None
    if not isinstance(parameters, dict) or not isinstance(choice.get("name"), str):
        yield choice
        return
    lists = {key: values for key, values in parameters.items() if isinstance(values, list)}
    swept = {k: v for k, v in lists.items() if not _takes_list(choice["name"], k)}
    label = choice.get("label") or _label(choice["name"])
    for key, values in swept.items():
        if not values:
            raise ValueError(f"{label}: the list of {key} is empty; give values to sweep over")
    for one_each in product(*swept.values()):
        chosen = dict(zip(swept, one_each, strict=True))
        ending = "".join(f" {key}={_shown(value)}" for key, value in chosen.items())
        yield {**choice, "parameters": parameters | chosen, "label": label + ending}


def _takes_list(name: str, parameter: str) -> bool:
    try:
        known = registry.parameters(name)
    except VslamError:  # an unknown filter is refused with all other unknown names, by `bench.study_checks`
        return False
    return any(p.name == parameter and isinstance(p.default, list | tuple) for p in known)


def _shown(value: object) -> str:
    if isinstance(value, bool) or value is None:
        return str(value).lower()
    return re.sub(r"[^A-Za-z0-9_.+-]+", "-", f"{value:g}" if isinstance(value, float) else str(value))


def _none_first(filters: tuple[FilterChoice, ...]) -> tuple[FilterChoice, ...]:
    """Doing nothing always stands beside the filters."""
    return (FilterChoice(name=BASELINE), *(f for f in filters if f.name != BASELINE))


def from_option(names: Sequence[str]) -> tuple[FilterChoice, ...]:
    """The filters that ``--filter`` names, with their defaults, beside doing nothing.

    Raises
    ------
    BenchError
        For what cannot be a filter's name, and for two filters of one label.
    """
    try:
        choices = tuple(FilterChoice.model_validate(name) for name in names)
        return TypeAdapter(Filters).validate_python(choices)
    except ValidationError as error:
        raise BenchError(f"--filter: {reason(FilterChoice, error).removeprefix('name: ')}") from None


Filters = Annotated[
    tuple[FilterChoice, ...],
    BeforeValidator(_swept),
    AfterValidator(_none_first),
    AfterValidator(distinct("label")),
]
"""A study's filters, or "all" that are registered: sweeps written out, doing nothing first, each with a label
of its own."""
