"""The README's examples run as they stand."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scenes
from bench.camera_choice import CameraChoice
from bench.generate import generate
from bench.kinds.rendered import RenderedStudy
from bench.options import GenerateOptions
from bench.progress import Silent
from renderers.basis import SceneRenderer, relight
from renderers.camera import Fisheye, Mount
from scenes.occupancy import true_occupancy
from vslam.filters import registry

README = Path(__file__).parent.parent / "README.md"


def _block(word: str) -> str:
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)
    (code,) = [block for block in blocks if word in block]
    return code


def _example(word: str) -> dict[str, Any]:
    namespace: dict[str, Any] = {}
    exec(compile(_block(word), "README.md", "exec"), namespace)
    return namespace


def test_the_filter_example_is_a_filter(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_entries", dict(registry._found()))  # forget it afterwards
    _example("@register")
    picture = np.full((20, 20, 3), 40, dtype=np.uint8)
    picture[5:7, 5:7] = 250
    filtered = registry.create("channel-min")(picture)
    assert filtered.mask.sum() == 4 and filtered.mask[5, 5]
    np.testing.assert_array_equal(filtered.image, picture)
    assert filtered.score.max() == pytest.approx(250 / 255)


@pytest.fixture
def hall(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The scene example as a module of its room."""
    (tmp_path / "room").mkdir()
    (tmp_path / "room" / "hall.py").write_text(_block("@scene"), encoding="utf-8")
    monkeypatch.setattr(scenes, "__path__", [*scenes.__path__, str(tmp_path / "room")])


@pytest.mark.usefixtures("hall")
def test_the_data_set_example_reads_a_data_set(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    study = RenderedStudy(
        sequence="rendered", name="hall", engine="raycast", camera=CameraChoice(width=32, height=24)
    )
    lights = (study.illuminations.grid()[0].name,)
    generate(study, GenerateOptions(Path("pictures"), lights, 2, scenes=("hall",)), Silent())
    names = _example("PictureSet")
    assert names["lit"].shape == (names["first"]["mask"].sum(), 3)
    assert names["linear"].shape == (24, 32, 3) and 0 < names["linear"].max() <= 2
    assert len(names["metres"]) == 2 and max(names["metres"]) < 13.2


def test_the_scene_example_can_be_rendered_and_driven() -> None:
    scene = _example("@scene")["build"]()
    assert not true_occupancy(scene, 0.1).blocked[40, 40]
    renderer = SceneRenderer(scene, Fisheye(64, 48, 150), Mount())
    basis = renderer.render(scene.tour.poses[0])
    white = np.ones(3)
    colours = {layer: white for layer in basis.layers}
    diffuse, specular = relight(basis, {"sun": 20_000, "sky": 2_500, "bulbs": 800}, colours)
    assert (diffuse[-1] > 0).all() and (specular >= 0).all()
    assert set(np.unique(basis.landmark)) & {0, 1, 2, 3}
