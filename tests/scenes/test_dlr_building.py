"""The rebuilt building from an invented drive: an L of corridors with a room, out of a gate and back."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

from renderers.irradiance import BakeQuality, bake
from renderers.lights import SkyLight
from renderers.mesh import NOTHING, RayCaster, build_mesh
from scenes import library
from scenes.drive_log import DriveLog
from scenes.driven_space import driven_space
from scenes.driven_walls import HEIGHT_M
from scenes.errors import SceneError
from scenes.occupancy import check_tour, true_occupancy

OUTDOORS = (150, 230)


def invented_drive() -> DriveLog:
    """East along a corridor, into a room to the north and out again, then south and out of a gate."""
    legs = [
        ((0, 0), (10, 0)),
        ((10, 0), (10, 5)),
        ((10, 5), (10, 0)),
        ((10, 0), (24, 0)),
        ((24, 0), (24, -24)),
    ]
    poses = []
    for (x0, y0), (x1, y1) in legs:
        n = int(np.hypot(x1 - x0, y1 - y0) / 0.25)
        share = np.arange(n)[:, None] / n
        way = np.array([x0, y0]) + share * (np.array([x1, y1]) - (x0, y0))
        poses.append(np.column_stack([way, np.full(n, np.arctan2(y1 - y0, x1 - x0))]))
    track = np.concatenate(poses)
    discs = [(x, side * 0.7) for x in range(1, 23, 2) for side in (-1, 1) if not (8 < x < 12 and side > 0)]
    discs += [(9.2, 2.0), (11.0, 3.5), (9.0, 4.8), (24.6, -4.0), (23.3, -8.0), (24.7, -12.0), (23.2, -20.0)]
    discs = np.array(discs, dtype=np.float64)
    apart = np.hypot(*(track[:, None, :2] - discs[None]).transpose(2, 0, 1))
    pose, disc = np.nonzero(apart < 2.5)
    white = np.arange(len(discs)) % 5 > 0
    light = (discs[:, 1] > 1.5) | ~white
    return DriveLog(track, discs, white, light, np.stack([pose, disc], axis=1), OUTDOORS)


@pytest.fixture(scope="module")
def log():
    return invented_drive()


@pytest.fixture(scope="module")
def building(log):
    return library.load("dlr_building", log=log, seed=4)


def digest(scene):
    arrays = [a for s in scene.surfaces for a in (s.vertices, s.triangles)] + [scene.tour.poses]
    return hashlib.sha256(b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)).hexdigest()


@pytest.fixture(scope="module")
def caster(building):
    mesh = build_mesh(building)
    return mesh, RayCaster(mesh.vertices, mesh.triangles)


def test_same_seed_same_building_and_another_has_other_doors(log, building):
    assert digest(building) == digest(library.load("dlr_building", log=log, seed=4))
    other = library.load("dlr_building", log=log, seed=5)
    assert digest(building) != digest(other)
    assert np.array_equal(building.landmark_positions, other.landmark_positions)


def test_discs_and_tour_are_the_logs_own(log, building):
    assert np.array_equal(building.landmark_positions, log.discs)
    assert [m.white for m in building.landmarks] == log.white.tolist()
    assert np.array_equal(building.tour.poses, log.poses)
    part = library.load("dlr_building", log=log, first=10, stride=7, frames=5, frame_interval_s=0.5)
    assert np.array_equal(part.tour.poses, log.poses[[10, 17, 24, 31, 38]])
    assert part.tour.stamps == pytest.approx(0.5 * np.array([0, 7, 14, 21, 28]))


def test_each_disc_lies_open_on_a_floor_that_carries_it(building, caster):
    """A ray straight down from 1.5 m above any part of a disc meets a floor, and no wall or leaf before."""
    mesh, rays = caster
    carrying = {building.floor, *building.inlays}
    angle = 2 * np.pi * np.arange(8) / 8
    rim = 0.095 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    for mark in building.landmarks:
        places = np.vstack([[0.0, 0.0], rim]) + mark.position
        origins = np.column_stack([places, np.full(9, 1.5)]).astype(np.float32)
        triangle, distance, _ = rays.nearest(origins, np.tile(np.float32([0, 0, -1]), (9, 1)))
        assert {mesh.surface_names[s] for s in mesh.surface[triangle]} <= carrying
        assert distance == pytest.approx(1.5, abs=2e-3)


def test_the_robot_drives_through_no_wall(building, caster):
    """Rays all round from half a metre above each pose go at least the robot's radius."""
    _, rays = caster
    angle = 2 * np.pi * np.arange(24) / 24
    around = np.stack([np.cos(angle), np.sin(angle), np.zeros(24)], axis=-1).astype(np.float32)
    for x, y, _ in building.tour.poses[::3]:
        origins = np.tile(np.float32([x, y, 0.5]), (24, 1))
        assert not rays.occluded(origins, around, far=0.25).any()


def test_light_enters_through_openings_alone(building, caster):
    """From well inside, rays that leave the building pass a window or a gate: they cross the wall's plane in
    their height; and nowhere does the ceiling let the sky in."""
    mesh, rays = caster
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(20_000, 3))
    directions = (directions / np.linalg.norm(directions, axis=1, keepdims=True)).astype(np.float32)
    origins = np.tile(np.float32([4.0, 0.0, 1.3]), (len(directions), 1))
    triangle, _, _ = rays.nearest(origins, directions)
    seen = np.where(triangle == NOTHING, "sky", np.array(mesh.surface_names)[mesh.surface[triangle]])
    assert {"floor", "wall", "ceiling"} <= set(seen)
    upwards = directions[:, 2] > 0.6  # meets the ceiling within 2 m
    assert not (seen[upwards] == "sky").any()
    out = (seen == "sky") | (seen == "ground")
    assert out.mean() < 0.1


def test_outdoors_is_under_the_sky_and_indoors_is_not(building, caster):
    _, rays = caster
    up = np.tile(np.float32([0, 0, 1]), (len(building.tour.poses), 1))
    eyes = np.column_stack([building.tour.poses[:, :2] + 0.017, np.full(len(up), 0.5)]).astype(np.float32)
    covered = rays.occluded(eyes, up)
    rows = np.arange(len(up))
    outside = (rows >= OUTDOORS[0]) & (rows < OUTDOORS[1])
    deep = np.abs(rows[:, None] - OUTDOORS).min(axis=1) > 4  # not within a metre of the gate
    assert covered[~outside & deep].all()
    assert not covered[outside & deep].any()


def test_under_the_ceiling_walls_get_no_light_from_the_sky_above(building, caster):
    """Walls end above the ceiling; light baked on the strip up there must not reach what is seen below."""
    mesh, rays = caster
    upwards = [[SkyLight(1.0)]]
    sky = bake(mesh, rays, upwards, BakeQuality(sky_rays=128, bounces=-1)).indirect[0, :, 0]
    open_sky = sky[mesh.triangles[mesh.surface == mesh.surface_names.index("ground")]].max()
    wall = mesh.triangles[mesh.surface == mesh.surface_names.index("wall")]
    below = np.unique(wall[(mesh.vertices[wall][..., 2] < HEIGHT_M - 0.01).any(axis=1)])
    at_the_top = below[mesh.vertices[below, 2] > HEIGHT_M - 0.1]  # windows end half a metre lower
    assert len(at_the_top) > 100
    assert sky[at_the_top].max() < 0.1 * open_sky


def test_doors_along_the_corridor_and_a_gate_to_the_outdoors(building):
    names = {s.name for s in building.surfaces}
    assert {"floor", "tiles", "paving", "wall", "facade", "door", "ceiling", "post"} <= names
    assert all(b.position[2] < 2.7 or b.position[2] == 3.5 for b in building.bulbs)


def test_occupancy_blocks_walls_and_leaves_the_track_free(building):
    grid = true_occupancy(building, 0.1)
    cell = np.floor((building.tour.poses[:, :2] - grid.origin) / grid.resolution).astype(int)
    assert not grid.blocked[cell[:, 1], cell[:, 0]].any()
    column, row = np.floor((np.array([4.0, 0.0]) - grid.origin) / grid.resolution).astype(int)
    for side in (grid.blocked[row:, column], grid.blocked[row::-1, column]):
        assert 5 <= np.argmax(side) <= 14  # the corridor's walls are half a metre to 1.4 m from its middle


@pytest.mark.parametrize("stride", [1, 12])
def test_the_drive_is_no_tour_through_walls(log, stride):
    check_tour(library.load("dlr_building", log=log, stride=stride))


def test_free_space_holds_what_was_driven_and_seen(log):
    space = driven_space(log)
    everywhere = space.indoor | space.outdoor
    assert space.holds(everywhere, log.poses[:, :2]).all()
    assert space.holds(everywhere, log.discs).all()
    assert not (space.indoor & space.outdoor).any()
    for ring in space.rings(everywhere):
        assert len(ring) >= 3


@pytest.mark.parametrize("wrong", [{"first": 10_000}, {"stride": 0}, {"frames": 0}])
def test_steps_that_the_log_lacks_are_refused(log, wrong):
    with pytest.raises(SceneError, match="the log has"):
        library.load("dlr_building", log=log, **wrong)


def test_without_a_log_it_says_where_to_get_one():
    with pytest.raises(SceneError, match="python -m bench fetch dlr"):
        library.load("dlr_building")


def test_a_log_whose_parts_do_not_fit_is_refused(log):
    with pytest.raises(SceneError, match="do not belong together"):
        DriveLog(log.poses, log.discs, log.white[1:], log.light_floor, log.sightings)
