"""SLAM back-ends as parts of a study."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, Field, model_validator

from bench.study_parts import Name, Part, distinct


class BackendChoice(Part):
    """A SLAM back-end (`vslam.backends`), its parameters, and the label of its rows (by default its name)."""

    name: Name
    parameters: dict[str, Any] = Field(default_factory=dict)
    label: Name = ""

    @model_validator(mode="before")
    @classmethod
    def _from_name_alone(cls, value: Any) -> Any:
        value = {"name": value} if isinstance(value, str) else value
        if isinstance(value, dict) and "name" in value:
            return {**value, "label": value.get("label") or value["name"]}
        return value


Backends = Annotated[tuple[BackendChoice, ...], Field(min_length=1), AfterValidator(distinct("label"))]
