"""What the levels of light of a study of several scenes are."""

from __future__ import annotations

from reports.run import Run


def levels_told(run: Run) -> tuple[str, ...]:
    """In one paragraph, from the study; none without levels."""
    levels = [
        f"“{level['name']}”: {level.get('sun', 0):g} × sun and sky, {level.get('lamps', 0):g} × lamps"
        for level in run.study.get("levels") or ()
    ]
    text = "Light is in proportion to what each scene is built with. "
    return (text + "; ".join(levels) + ".",) if levels else ()
