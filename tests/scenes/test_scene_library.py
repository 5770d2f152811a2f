"""Scenes by name."""

from __future__ import annotations

import pytest

from scenes import library
from scenes.errors import SceneError


def test_corridor_is_there_and_described():
    assert "corridor" in library.names()
    assert library.names() == sorted(library.names())
    (info,) = (i for i in library.describe() if i.name == "corridor")
    assert info.summary.startswith("A ring of glossy corridors")
    assert info.parameters["speed_mps"] == 0.93  # Table 4-1
    assert info.parameters["laps"] == 1.25


def test_places_of_the_library():
    places = {"atrium", "corridor", "office", "regular", "tabletop", "warehouse"}
    assert places <= set(library.names())
    for info in library.describe():
        assert info.summary.endswith(".") and len(info.summary) <= 110


def test_unknown_scene_names_the_known_ones():
    with pytest.raises(library.UnknownSceneError, match="corridor") as caught:
        library.load("coridor")
    assert caught.value.name == "coridor"
    assert "corridor" in caught.value.known


def test_unknown_parameter_names_the_known_ones():
    with pytest.raises(SceneError, match=r"no parameter 'sed'; it has seed, speed_mps"):
        library.load("corridor", sed=3)


@pytest.mark.parametrize(
    "bad",
    [{"speed_mps": 0.0}, {"frame_interval_s": -1.0}, {"seed": -1}, {"laps": "two"}, {"laps": -1.0}],
    ids=str,
)
def test_parameter_that_does_not_fit(bad):
    with pytest.raises(SceneError) as caught:
        library.load("corridor", **bad)
    assert "\n" not in str(caught.value)


def test_marking_a_builder_is_enough(monkeypatch):
    """A module of the room with a marked function is a scene: no list to edit."""
    import scenes.corridor

    @library.scene("yard")
    def build(size: float = 3.0):
        """An open yard.

        More about it.
        """
        return size

    before = library.names()
    monkeypatch.setattr(scenes.corridor, "yard", build, raising=False)
    assert library.names() == sorted([*before, "yard"])
    assert library.load("yard", size=5.0) == 5.0
    assert library.SceneInfo("yard", "An open yard.", {"size": 3.0}) in library.describe()
