"""What every scene of the library promises, whatever its seed."""

from __future__ import annotations

import numpy as np
import pytest

from scenes import library

ROBOT_RADIUS_M = 0.25
SEEDS = (0, 1, 5)
OPEN_SIDES = {
    "atrium": {"south", "ceiling"},
    "corridor": {"south"},
    "office": {"south"},
    "regular": {"south"},
    "tabletop": {"south"},
    "warehouse": {"south", "ceiling"},
}
"""Where a scene has windows or roof lights."""


def around(count):
    angle = np.arange(count) * 2 * np.pi / count
    return np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)


def everything(scene):
    """All that a seed could place, as one array."""
    marks = [[*m.position, m.radius, m.white] for m in scene.landmarks]
    return np.concatenate(
        [np.ravel(marks), *(s.vertices.ravel() for s in scene.surfaces), scene.tour.poses.ravel()]
    )


def test_same_seed_same_scene_other_seed_other_scene(built, place_name):
    one, again, other = built(place_name), library.load(place_name, seed=0), built(place_name, 1)
    np.testing.assert_array_equal(everything(one), everything(again))
    assert [s.material for s in one.surfaces] == [s.material for s in again.surfaces]
    assert {m.position for m in one.landmarks}.isdisjoint(m.position for m in other.landmarks)


@pytest.mark.parametrize("seed", SEEDS)
def test_meshes_are_sound(built, place_name, seed):
    """No degenerate triangle, no vertex out of use, names that differ, and not too many."""
    scene = built(place_name, seed)
    names = [s.name for s in scene.surfaces]
    assert len(set(names)) == len(names)
    assert sum(len(s.triangles) for s in scene.surfaces) < 50_000
    for surface in scene.surfaces:
        assert set(np.unique(surface.triangles)) == set(range(len(surface.vertices)))
        corner = surface.vertices[surface.triangles]
        area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1) / 2
        longest = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=-1).max(axis=1)
        assert (area > 1e-3 * longest**2).all(), surface.name  # no needle, and none without area
        if surface.normals is not None:
            face = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) / (2 * area[:, None])
            at_corners = surface.normals[surface.triangles]
            assert np.einsum("nk,nck->nc", face, at_corners).min() > 0.3, surface.name


def test_what_the_robot_sees_faces_it(built, first_hit, place_name):
    """Triangles are one-sided; from anywhere on the tour the reflecting side must be the one in view."""
    cast = first_hit(place_name)
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(3000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    for x, y, _ in built(place_name).tour.poses[::7]:
        _, name, facing = cast(np.array([x, y, 1.2]), directions)
        wrong = name[~facing & (name != "sky")]
        assert len(wrong) <= 3, set(wrong)  # a ray may slip along an edge


@pytest.mark.parametrize("seed", SEEDS)
def test_robot_fits_along_the_whole_tour(built, first_hit, place_name, seed):
    """Rays at five heights find nothing within the robot's radius, and none falls through the floor."""
    scene, cast = built(place_name, seed), first_hit(place_name, seed)
    for height in (0.06, 0.3, 0.6, 0.9, 1.15):
        at = np.column_stack([scene.tour.poses[:, :2], np.full(len(scene.tour.poses), height)])
        distance, _, _ = cast(at[:, None], around(90))
        assert distance.min() > ROBOT_RADIUS_M
    _, below, _ = cast(at, np.array([0.0, 0.0, -1.0]))
    assert set(below) <= {scene.floor, *scene.inlays}
    step = np.linalg.norm(np.diff(scene.tour.poses[:, :2], axis=0), axis=1)
    assert step.max() <= 0.93 * 0.5 + 1e-9  # Table 4-1's speed
    assert np.ptp(np.unwrap(scene.tour.poses[:, 2])) > 2 * np.pi  # closed, and driven on


@pytest.mark.parametrize("seed", SEEDS)
def test_discs_lie_open_on_the_floor(built, first_hit, place_name, seed):
    """Nothing stands on a disc or hangs low above it; all of it is on the floor, apart from the others."""
    scene, cast = built(place_name, seed), first_hit(place_name, seed)
    centre = scene.landmark_positions
    radius = np.array([m.radius for m in scene.landmarks])
    assert len(centre) >= 8
    assert ((radius >= 0.10) & (radius <= 0.20)).all()
    assert 0.2 < np.mean([m.white for m in scene.landmarks]) < 0.95
    apart = np.linalg.norm(centre[:, None] - centre, axis=-1) - radius[:, None] - radius
    np.fill_diagonal(apart, np.inf)
    assert apart.min() > 0.05
    rim = centre[:, None] + radius[:, None, None] * around(24)[:, :2]
    points = np.concatenate([rim, centre[:, None], (rim + centre[:, None]) / 2], axis=1).reshape(-1, 2)
    points = np.column_stack([points, np.full(len(points), 5e-4)])
    above, _, _ = cast(points, np.array([0.0, 0.0, 1.0]))
    assert above.min() > 2.0
    _, below, _ = cast(points, np.array([0.0, 0.0, -1.0]))
    assert set(below) <= {scene.floor, *scene.inlays}


@pytest.mark.parametrize("seed", SEEDS)
def test_light_enters_through_the_openings_alone(built, first_hit, place_name, seed):
    """Rays that leave the room cross the planes of the walls that have windows, and no other wall."""
    scene, cast = built(place_name, seed), first_hit(place_name, seed)
    x0, y0, x1, y1 = scene.bounds
    height = max(s.vertices[:, 2].max() for s in scene.surfaces if s.name == "ceiling")
    rng = np.random.default_rng(seed)
    poses = scene.tour.poses[rng.integers(len(scene.tour.poses), size=60_000)]
    at = np.column_stack([poses[:, :2], rng.uniform(0.05, 2.0, len(poses))])
    direction = rng.normal(size=at.shape)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    distance, _, _ = cast(at, direction)
    low, high = np.array([x0, y0, 0.0]), np.array([x1, y1, height])
    to_wall = np.where(direction > 0, (high - at) / direction, (low - at) / direction)
    out = distance > to_wall.min(axis=1) + 0.01
    side = np.argmin(to_wall, axis=1) + 3 * (direction[np.arange(len(at)), np.argmin(to_wall, axis=1)] > 0)
    names = np.array(["west", "south", "floor", "east", "north", "ceiling"])
    assert set(names[side[out]]) == OPEN_SIDES[place_name]
    assert 0.0005 < out.mean() < 0.25


def test_sun_falls_in_and_leaves_shade(built, first_hit, place_name):
    """From the floor, rays to the sun escape in some places and not in others, nowhere in the far corners."""
    scene, cast = built(place_name), first_hit(place_name)
    x0, y0, x1, y1 = scene.bounds
    x, y = np.meshgrid(np.linspace(x0 + 0.05, x1 - 0.05, 120), np.linspace(y0 + 0.05, y1 - 0.05, 90))
    at = np.stack([x, y, np.full(x.shape, 0.002)], axis=-1)
    _, name, _ = cast(at, scene.suns[0].direction)
    lit = name == "sky"
    assert 0.02 < lit.mean() < 0.6
    if OPEN_SIDES[place_name] == {"south"}:
        assert not lit[y > y0 + 0.95 * (y1 - y0)].any()


def test_lamps_hang_free_below_the_ceiling(built, first_hit, place_name):
    scene, cast = built(place_name), first_hit(place_name)
    at = np.array([bulb.position for bulb in scene.bulbs])
    radius = np.array([bulb.radius for bulb in scene.bulbs])
    directions = np.concatenate([around(16), [[0, 0, 1.0], [0, 0, -1.0]]])
    distance, name, _ = cast(at[:, None], directions)
    assert (distance > radius[:, None]).all()
    assert (distance[:, -1] > 1.5).all()  # the robot passes beneath
    assert set(name[:, -2]) <= {"ceiling", "sky"}
