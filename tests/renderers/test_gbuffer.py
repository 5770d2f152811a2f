"""What the G-buffer derives from triangle and distance must fit the mesh."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.camera import Fisheye, Mount, T_world_robot
from renderers.gbuffer import interpolate
from renderers.mesh import NOTHING, RayCaster, build_mesh
from scenes import library
from scenes.model import Bulb


@pytest.fixture(scope="module")
def corridor(gbuffer_of):
    scene = library.load("corridor")
    T = T_world_robot(scene.tour.poses[5]) @ Mount().T_robot_camera
    return build_mesh(scene), gbuffer_of(scene, Fisheye(160, 120, 150.0), T)


def test_barycentric_weights_give_the_point_back(corridor):
    mesh, gbuffer = corridor
    seen = gbuffer.triangle != NOTHING
    bary = gbuffer.barycentric[seen]
    weights = np.column_stack([1 - bary.sum(axis=1), bary]).astype(np.float32)
    assert weights.min() > -1e-3
    points = interpolate(mesh.vertices, mesh.triangles[gbuffer.triangle[seen]], weights)
    # the ground outside reaches 250 m: float32 leaves a relative error there
    error = np.linalg.norm(points - gbuffer.position[seen], axis=1)
    assert (error / (1e-4 + 1e-5 * gbuffer.distance[seen])).max() < 1


def test_the_sky_has_no_normal_and_takes_no_value(corridor, gbuffer_of):
    mesh, _ = corridor
    up = np.eye(4)
    up[:3, 3] = 0.0, 0.0, 50.0  # above the roof; the camera's z is the world's
    sky = gbuffer_of(library.load("corridor"), Fisheye(16, 12, 60.0), up)
    assert (sky.triangle == NOTHING).all() and (sky.surface == NOTHING).all()
    assert not sky.normal.any() and not sky.depth.any()
    none, third = np.full((1, 3), NOTHING, dtype=np.int32), np.full((1, 3), 1 / 3, dtype=np.float32)
    assert not interpolate(1 + np.abs(mesh.vertices), none, third).any()


def test_normals_have_unit_length_and_face_the_camera(corridor):
    _, gbuffer = corridor
    seen = gbuffer.triangle != NOTHING
    np.testing.assert_allclose(np.linalg.norm(gbuffer.normal[seen], axis=-1), 1.0, atol=1e-5)
    assert (np.einsum("nk,nk->n", gbuffer.normal[seen], gbuffer.view.directions[seen]) < 1e-6).all()


def test_points_lie_on_their_pixels_rays(corridor):
    _, gbuffer = corridor
    T = gbuffer.view.T_world_camera
    seen = gbuffer.triangle != NOTHING
    pixels, inside = gbuffer.view.camera.project((gbuffer.position[seen] - T[:3, 3]) @ T[:3, :3])
    v, u = np.nonzero(seen)
    np.testing.assert_allclose(pixels, np.stack([u, v], axis=-1), atol=1e-2)
    assert inside.all()


def test_bulbs_are_spheres_after_the_surfaces(scene_of):
    bulbs = [Bulb((0.0, 0.0, 2.0), 1.0, radius=0.2), Bulb((1.0, 0.0, 1.5), 1.0, radius=0.1)]
    mesh = build_mesh(scene_of(bulbs=bulbs))
    for k, bulb in enumerate(bulbs):
        triangles = mesh.triangles[mesh.bulb == k]
        corner = mesh.vertices[triangles].astype(np.float64)
        offset = corner - bulb.position
        np.testing.assert_allclose(np.linalg.norm(offset, axis=-1), bulb.radius, rtol=1e-5)
        area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) / 2
        np.testing.assert_allclose(area.sum(axis=0), 0.0, atol=1e-6)  # closed
        assert (np.einsum("nk,nk->n", area, offset.mean(axis=1)) > 0).all()  # facing outwards
        volume = np.einsum("nk,nk->", area, offset.mean(axis=1)) / 3
        assert volume == pytest.approx(4 / 3 * np.pi * bulb.radius**3, rel=0.12)
    assert (mesh.bulb[mesh.surface == 0] == NOTHING).all()


def test_ray_caster_finds_the_nearest(scene_of, floor):
    """Rays onto a square floor, by hand."""
    mesh = build_mesh(scene_of(floor(2.0)))
    caster = RayCaster(mesh.vertices, mesh.triangles, threads=1)
    origins = np.float32([[0.3, 0.4, 1.5], [0.3, 0.4, 1.5], [0, 0, 1.0], [5.0, 0, 1.0]])
    slant = np.float32([0.6, 0.0, -0.8])
    directions = np.stack([np.float32([0, 0, -1]), np.float32([0, 0, 1]), slant, np.float32([0, 0, -1])])
    triangle, distance, _ = caster.nearest(origins, directions)
    np.testing.assert_allclose(distance, [1.5, np.inf, 1.25, np.inf], rtol=1e-6)
    np.testing.assert_array_equal(triangle == NOTHING, [False, True, False, True])
    np.testing.assert_array_equal(caster.occluded(origins, directions), [True, False, True, False])
    np.testing.assert_array_equal(caster.occluded(origins, directions, far=1.3), [False, False, True, False])
