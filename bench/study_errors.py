"""Pydantic's errors as one line: which key, what is allowed, and near names for an unknown key."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

Path = tuple[str | int, ...]

# pydantic speaks of Python types; a study file has lists and mappings
_WORDS = {
    "tuple_type": "should be a list",
    "list_type": "should be a list",
    "dict_type": "should be a mapping of keys and values",
    "model_type": "should be a mapping of keys and values",
    "invalid_key": "keys should be text",
    "string_type": "should be text",
    "int_parsing": "should be a whole number",
    "int_type": "should be a whole number",
    "int_from_float": "should be a whole number",
    "float_parsing": "should be a number",
    "float_type": "should be a number",
    "string_pattern_mismatch": "should be a name of small letters, digits, - and _",
    "missing": "is missing",
    "too_short": "should hold at least one entry",
    "string_too_short": "should not be empty",
}


def reason(model: type[BaseModel], error: ValidationError) -> str:
    """Describe the first error in one line.

    Parameters
    ----------
    model : type of pydantic.BaseModel
        What was to be validated; unknown keys are compared with its fields.
    error : pydantic.ValidationError
        What pydantic raised. An unknown key goes first: it explains what follows from it.

    Returns
    -------
    str
        ``key.path: what is wrong and what is allowed``, with the number of further errors.
    """
    errors = sorted(_causes(error.errors()), key=lambda e: e["type"] != "extra_forbidden")
    path = _key_path(errors[0])
    here = [e for e in errors if _key_path(e) == path]
    line = _unknown_key(model, path) if here[0]["type"] == "extra_forbidden" else _wrong_value(here)
    key = ".".join(str(part) for part in path)
    more = f" (and {len(errors) - len(here)} more)" if len(errors) > len(here) else ""
    return " ".join(f"{key + ': ' if key else ''}{line}{more}".split())


def _causes(errors: list[ErrorDetails]) -> list[ErrorDetails]:
    """Without lists that are too short because an entry in them is wrong."""
    wrong = [e["loc"] for e in errors]
    return [
        e
        for e in errors
        if e["type"] != "too_short" or not any(w[:-1] == e["loc"] for w in wrong if w != e["loc"])
    ]


def _key_path(error: ErrorDetails) -> Path:
    """Where the error is, without the branches of a union that pydantic adds: ``literal['auto']``."""
    return tuple(
        p for p in error["loc"] if isinstance(p, int) or not p.startswith(("literal[", "constrained-"))
    )


def _unknown_key(model: type[BaseModel], path: Path) -> str:
    known = [model]
    for part in path[:-1]:
        if isinstance(part, str):
            known = list(_below(known, part))
    model = known[0]
    near = get_close_matches(str(path[-1]), model.model_fields, n=2, cutoff=0.5)
    hint = (
        f"did you mean {' or '.join(map(repr, near))}?" if near else f"known: {', '.join(model.model_fields)}"
    )
    return f"unknown key: {hint}"


def _below(models: list[type[BaseModel]], part: str) -> Iterator[type[BaseModel]]:
    """Models of a field, or the one of a union that carries this tag."""
    for model in models:
        if part in model.model_fields:
            yield from _models_in(model.model_fields[part].annotation)
        elif any(get_args(field.annotation) == (part,) for field in model.model_fields.values()):
            yield model


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in get_args(annotation):
        yield from _models_in(argument)


def _wrong_value(errors: list[ErrorDetails]) -> str:
    """Each branch of a union says what it would take; together they are what is allowed."""
    messages = [_WORDS.get(e["type"], e["msg"].replace("Input should", "should")) for e in errors]
    message = " or ".join([messages[0], *(m.removeprefix("should be ") for m in messages[1:])])
    if errors[0]["type"] in ("value_error", "missing"):
        return message.removeprefix("Value error, ")
    given = errors[0]["input"]
    return f"{message}, not {'a mapping' if isinstance(given, dict) else repr(given)}"
