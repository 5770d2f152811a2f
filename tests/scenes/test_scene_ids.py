"""Landmark ids are rows of the scene's list: everything downstream counts on it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from scenes.errors import SceneError
from scenes.library import load


def test_ids_that_are_not_rows_are_refused() -> None:
    scene = load("corridor")
    shifted = tuple(replace(m, id=m.id + 1) for m in scene.landmarks)
    with pytest.raises(SceneError, match="ids must be 0, 1, 2"):
        replace(scene, landmarks=shifted)


def test_components_draw_from_streams_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """One more draw for the doors must leave every disc where it was."""
    from scenes import corridor

    before = load("corridor", seed=5)
    doors = corridor._doors
    monkeypatch.setattr(corridor, "_doors", lambda rng: (rng.random(3), doors(rng))[1])
    after = load("corridor", seed=5)
    assert after.landmarks == before.landmarks
    assert any((a.vertices != b.vertices).any() for a, b in zip(after.surfaces, before.surfaces, strict=True))


def test_floor_must_be_a_surface() -> None:
    scene = load("corridor")
    with pytest.raises(SceneError, match="its floor 'lawn' is none of its surfaces"):
        replace(scene, floor="lawn")
    with pytest.raises(SceneError, match="its floor 'carpet' is none of its surfaces"):
        replace(scene, inlays=("carpet",))
