"""A short real run that several tests look at: seven frames of the corridor, two suns, two bulbs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.kinds.rendered import RenderedStudy


@pytest.fixture(scope="session")
def cache_home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A user cache of the test session's own, so that baked light is made once and thrown away."""
    home = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(home))
        yield home


@pytest.fixture(scope="session")
def short_study() -> RenderedStudy:
    """A rendered study of seconds: its exposure is fixed, so that more light is a brighter picture."""
    return RenderedStudy.model_validate(
        {
            "sequence": "rendered",
            "name": "short",
            "seed": 3,
            "engine": "raycast",
            "scene": {"parameters": {"laps": 0.05}},
            "illuminations": {"sun_lux": [0, 20_000], "bulb_lm": [200, 800]},
            "tour": {"frame_interval_s": 0.5},
            "sensor": {"exposure": 0.002},
            "filters": ["none", "seed"],
            "seeds": 2,
            "navigation": {"pairs": 4},
        }
    )
