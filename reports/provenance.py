"""Where the numbers come from, as lines for a person."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from reports.run import Run
from reports.wording import number


def lines(run: Run) -> tuple[tuple[str, str], ...]:
    """Key and value of everything that ``provenance.json`` says."""
    known = run.provenance
    shown: list[tuple[str, str]] = [("run", run.folder.resolve().name)]
    for key, value in known.items():
        if key == "seconds" and isinstance(value, Mapping):
            shown.append(("time", _seconds(value)))
        elif isinstance(value, Mapping):
            shown.append((_words(key), ", ".join(f"{k} {v}" for k, v in value.items())))
        elif isinstance(value, bool):
            name = "uncommitted changes" if key == "dirty" else _words(key)
            shown.append((name, "yes" if value else "no"))
        elif value not in (None, ""):
            shown.append((_words(key), str(value)))
    return tuple(shown)


def subtitle(run: Run) -> str:
    """One line under the title: study, scenes, when, which engine."""
    engine = run.provenance.get("engine")
    parts = [
        f"study {run.study.get('name', run.folder.name)}",
        f"scene {', '.join(run.scenes)}" if run.scenes and not run.is_dlr else "",
        f"rendered by {engine}" if engine and not run.is_dlr else "",
        str(run.provenance.get("started", ""))[:10],
    ]
    return " · ".join(p for p in parts if p)


def _words(key: str) -> str:
    return key.replace("_", " ")


def _seconds(stages: Mapping[str, Any]) -> str:
    return ", ".join(
        f"{_words(str(stage))} {number(float(value), 1)} s"
        if isinstance(value, int | float)
        else f"{stage} {value}"
        for stage, value in stages.items()
    )
