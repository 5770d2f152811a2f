"""What is chosen on one split is judged on scenes it has never seen."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenes import library
from scenes.errors import SceneError
from scenes.splits import SPLITS, seed_of, split_of, stream

SHARED = {"ground", "house opposite"}
"""The land outside is the same everywhere."""


@given(st.sampled_from(SPLITS), st.integers(0, 10**6))
def test_splits_share_out_the_seeds(split, number):
    assert split_of(seed_of(split, number)) == split


def test_every_seed_belongs_to_one_split():
    seeds = [seed_of(split, k) for split in SPLITS for k in range(20)]
    assert sorted(seeds) == list(range(60))


def test_the_corridor_looked_at_is_for_training_and_the_reported_one_for_tests():
    assert (split_of(0), split_of(7)) == ("train", "test")


@pytest.mark.parametrize(("split", "number"), [("tests", 0), ("", 0), ("test", -1)])
def test_no_such_scene(split, number):
    with pytest.raises(SceneError, match=r"unknown split|numbered from 0"):
        seed_of(split, number)


@given(st.integers(0, 2**40), st.integers(0, 2**40), st.sampled_from(["a", "b"]), st.sampled_from(["c", "d"]))
def test_streams_differ_by_seed_scene_and_component(seed, other, name, component):
    mine = stream(seed, name, component).random(4)
    np.testing.assert_array_equal(mine, stream(seed, name, component).random(4))
    if seed != other:
        assert (mine != stream(other, name, component).random(4)).all()
    assert (mine != stream(seed, name + "x", component).random(4)).all()
    assert (mine != stream(seed, name, component + "x").random(4)).all()


def digests(name, split, number):
    """Of each surface's mesh, and of the landmarks' layout; position and shape alike."""
    scene = library.load(name, seed=seed_of(split, number))
    # the corridors are one building with other doors and cabinets
    shared = SHARED | ({"floor", "ceiling", "wall", "blue wall", "roof"} if name == "corridor" else set())
    found = {
        hashlib.sha256(np.round(s.vertices, 6).tobytes()).hexdigest()
        for s in scene.surfaces
        if s.name not in shared
    }
    marks = np.array([[*m.position, m.radius] for m in scene.landmarks])
    return found | {hashlib.sha256(np.round(marks, 6).tobytes()).hexdigest()}


def test_no_two_splits_share_a_mesh_or_a_layout(place_name):
    seen = {split: set().union(*(digests(place_name, split, k) for k in range(3))) for split in SPLITS}
    for one in SPLITS:
        for other in SPLITS:
            assert one == other or seen[one].isdisjoint(seen[other])
