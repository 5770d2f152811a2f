"""What the parts of a study are made of: their base class, and numbers with a range."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from difflib import get_close_matches
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from renderers import illuminant
from renderers.errors import RendererError


def _illuminant(name: str) -> str:
    """Refuse what `renderers.illuminant` does not know, so that the error names file and key."""
    try:
        illuminant.check_name(name)
    except RendererError as error:
        raise ValueError(str(error)) from None
    return name


Parts = TypeVar("Parts", bound=Sequence[Any])

Name = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]*$")]  # also the name of a folder
Share = Annotated[float, Field(gt=0, le=1)]
Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Engine = Literal["auto", "rasterise", "raycast"]
Split = Literal["train", "test", "validation"]  # as `scenes.splits` has them
Illuminant = Annotated[str, Field(min_length=1), AfterValidator(_illuminant)]


class Part(BaseModel):
    """Base of all parts: unknown keys refused, immutable, finite numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def distinct(key: str) -> Callable[[Parts], Parts]:
    """A validator that refuses two parts of one ``key``, such as two of one name."""

    def check(parts: Parts) -> Parts:
        values = [getattr(part, key) for part in parts]
        for value in values:
            if values.count(value) > 1:
                raise ValueError(f"the {key} {value!r} stands twice; give one of them another {key}")
        return parts

    return check


def refuse_unknown(keys: Iterable[object], known: Sequence[str]) -> None:
    """Refuse keys of a short form, such as ``{log: …, steps: …}``, that it does not have.

    Raises
    ------
    ValueError
        With near names.
    """
    for key in keys:
        if key not in known:
            near = get_close_matches(str(key), known, n=1, cutoff=0.5)
            hint = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(known)}"
            raise ValueError(f"unknown key {key!r}: {hint}")
