"""``python -m bench.warm_up``: compile every kernel once, so that the first run does not.

Numba compiles a kernel at its first call and keeps it beside its source; the corridor's baked light goes into
the user's cache. Set-up runs this over three frames of the default study.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from bench.kinds.rendered import RenderedStudy
from bench.options import RunOptions
from bench.progress import Silent
from bench.runner import run
from bench.study import load


def warm_up() -> None:
    """Run the default study in little, and throw the result away."""
    study = load("quick")
    assert isinstance(study, RenderedStudy)
    few = {
        "scene": study.scene.model_copy(update={"parameters": {**study.scene.parameters, "laps": 0.02}}),
        "illuminations": study.illuminations.model_copy(update={"bulb_lm": study.illuminations.bulb_lm[:1]}),
        "seeds": 1,
    }
    with tempfile.TemporaryDirectory() as folder:
        run(study.model_copy(update=few), RunOptions(out=Path(folder)), Silent())


if __name__ == "__main__":
    warm_up()
