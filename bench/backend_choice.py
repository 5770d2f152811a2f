"""SLAM back-ends as parts of a study."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, Field, model_validator

from bench.study_parts import Name, Part


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


def _distinct(choices: tuple[BackendChoice, ...]) -> tuple[BackendChoice, ...]:
    labels = [choice.label for choice in choices]
    for label in labels:
        if labels.count(label) > 1:
            raise ValueError(f"the label {label!r} stands twice; give one of them another label")
    return choices


Backends = Annotated[tuple[BackendChoice, ...], Field(min_length=1), AfterValidator(_distinct)]
