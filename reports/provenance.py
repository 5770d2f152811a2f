"""Where the numbers come from, as lines for a person."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from reports.kind import kind_of
from reports.run import Run
from reports.wording import number

LABELS = {"dirty": "uncommitted changes", "memory_gb": "memory in GB"}


def lines(run: Run) -> tuple[tuple[str, str], ...]:
    """Key and value of everything that ``provenance.json`` says."""
    shown: list[tuple[str, str]] = []
    for key, value in run.provenance.items():
        if key == "seconds" and isinstance(value, Mapping):
            shown.append(("time", _seconds(value)))
        elif key == "files_sha256" and isinstance(value, Mapping):
            shown += [("SHA-256", f"{path} {digest}") for path, digest in value.items()]
        elif value not in (None, ""):
            shown.append((LABELS.get(key, _words(key)), _text(value)))
    return tuple(shown)


def subtitle(run: Run) -> str:
    """One line under the title: study, scenes, when, which engine."""
    engine, rendered = run.provenance.get("engine"), kind_of(run.sequence).rendered
    parts = [
        f"study {run.study.get('name', run.folder.name)}",
        f"scene {', '.join(run.scenes)}" if run.scenes and rendered else "",
        f"rendered by {engine}" if engine and rendered else "",
        str(run.provenance.get("started") or run.provenance.get("created") or "")[:10],
    ]
    return " · ".join(p for p in parts if p)


def _text(value: object) -> str:
    """A value as text; a mapping as "key value, key value"."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Mapping):
        return ", ".join(f"{LABELS.get(str(k), _words(str(k)))} {_text(v)}" for k, v in value.items())
    return str(value)


def _words(key: str) -> str:
    return key.replace("_", " ")


def _seconds(stages: Mapping[str, Any]) -> str:
    return ", ".join(
        f"{_words(str(stage))} {number(float(value), 1)} s"
        if isinstance(value, int | float)
        else f"{stage} {value}"
        for stage, value in stages.items()
    )
