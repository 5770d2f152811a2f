"""A short real run that several tests look at: seven frames of the corridor, two suns, two bulbs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import scenes
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


HALL = """
import numpy as np
from scenes.geometry import box, rectangle, surface
from scenes.library import scene
from scenes.model import Bulb, Landmark, Material, Scene, Sky, Sun
from scenes.tour import drive, rounded_loop

@scene("small-hall")
def build(seed=0, speed_mps=0.93, frame_interval_s=0.5):
    '''A polished floor without walls, four discs, a white box.'''
    floor = rectangle((0, 0, 0), (8, 0, 0), (0, 8, 0))
    white = Material((0.8, 0.8, 0.8), roughness=0.9)
    surfaces = (
        surface("floor", Material((0.3, 0.3, 0.3), roughness=0.2), floor),
        surface("white box", white, box((3.7, 3.7, 0), (4.3, 4.3, 0.6))),
    )
    discs = tuple(Landmark(k, (2.0 + 4 * (k % 2), 2.0 + 4 * (k // 2)), 0.15, white=k < 2) for k in range(4))
    way = rounded_loop(np.array([[2.6, 2.6], [5.4, 2.6], [5.4, 5.4], [2.6, 5.4]]), radius=0.5)
    tour = drive(way, 0.0, 9.0, speed_mps, frame_interval_s)
    bulbs = (Bulb((4, 2, 2.5), 800), Bulb((2, 4, 2.5), 800), Bulb((6, 4, 2.5), 800), Bulb((4, 6, 2.5), 800))
    return Scene("small-hall", surfaces, discs, (Sun(180, 40, 20_000),), Sky(2_500), bulbs, tour, "floor",
                 (0.85,) * 3, (0.03,) * 3, (0, 0, 8, 8))
"""


@pytest.fixture(scope="session")
def small_halls(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Two scenes whose light is baked in a moment, ``small-hall`` and ``far-hall``, which has fewer discs."""
    room = tmp_path_factory.mktemp("room")
    (room / "small_hall.py").write_text(HALL)
    (room / "far_hall.py").write_text(HALL.replace("small-hall", "far-hall").replace("range(4)", "range(3)"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scenes, "__path__", [*scenes.__path__, str(room)])
        yield
