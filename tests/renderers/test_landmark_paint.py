"""Painted discs against the exact outline that OpenCV projects."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from renderers.camera import Fisheye, Mount, Pinhole, T_world_robot
from renderers.mesh import RayCaster, build_mesh
from renderers.paint import Discs, disc_samples, paint, visible_share
from scenes import library
from scenes.geometry import box, checker, surface
from scenes.model import Landmark, Material

BLACK = Material((0.0, 0.0, 0.0), roughness=1.0, specular=0.0)
MOUNT = Mount(height_m=1.2, pitch_deg=25.0)
POSE = np.array([-1.5, 0.2, 0.1])
CAMERAS = [Fisheye(320, 240, 150.0), Pinhole(320, 240, 90.0)]


def view_from(pose=POSE):
    return T_world_robot(pose) @ MOUNT.T_robot_camera


def projected(camera, T, points):
    """World points to pixels by OpenCV."""
    local = (np.atleast_2d(points) - T[:3, 3]) @ T[:3, :3]
    f = camera.focal
    K = np.array([[f, 0, (camera.width - 1) / 2], [0, f, (camera.height - 1) / 2], [0, 0, 1]])
    if isinstance(camera, Fisheye):
        return cv2.fisheye.projectPoints(local[:, None], np.zeros(3), np.zeros(3), K, np.zeros(4))[0][:, 0]
    return cv2.projectPoints(local[:, None], np.zeros(3), np.zeros(3), K, np.zeros(5))[0][:, 0]


def outline(camera, T, mark, corners=2000):
    angle = np.linspace(0, 2 * np.pi, corners, endpoint=False)
    x, y = mark.position
    rim = np.stack([x + mark.radius * np.cos(angle), y + mark.radius * np.sin(angle), 0 * angle], axis=-1)
    return projected(camera, T, rim)


def area_and_centroid(polygon):
    """Shoelace formula."""
    x, y = (polygon - polygon.mean(axis=0)).T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    area = cross.sum() / 2
    middle = [((c + np.roll(c, -1)) * cross).sum() / (6 * area) for c in (x, y)]
    return abs(area), polygon.mean(axis=0) + middle


@pytest.fixture(scope="module")
def painted(scene_of, floor, gbuffer_of):
    """Share of each pixel that white discs cover (the floor is black), and the id picture."""

    def make(camera, marks, *obstacles, pose=POSE):
        scene = scene_of(floor(4.0, BLACK), *obstacles, landmarks=marks)
        gbuffer = gbuffer_of(scene, camera, view_from(pose))
        share = np.zeros((camera.height, camera.width, 3), np.float32)
        ids = paint(gbuffer, Discs.of(scene), share)
        return share[..., 0], ids, gbuffer, Discs.of(scene)

    return make


@pytest.mark.parametrize("camera", CAMERAS, ids=["fisheye", "pinhole"])
@pytest.mark.parametrize("position", [(0.0, 0.0), (-0.2, -0.7), (0.9, 0.8), (2.5, 0.4)])
@pytest.mark.parametrize("radius", [0.1, 0.2])
def test_area_and_centroid_of_a_disc(painted, camera, position, radius):
    mark = Landmark(0, position, radius, white=True)
    share, ids, _, _ = painted(camera, [mark])
    area, centroid = area_and_centroid(outline(camera, view_from(), mark))
    assert share.sum() == pytest.approx(area, abs=max(0.01 * area, 0.15))  # 16 samples per pixel of the rim
    v, u = np.indices(share.shape)
    middle = np.array([(share * u).sum(), (share * v).sum()]) / share.sum()
    np.testing.assert_allclose(middle, centroid, atol=0.05)
    assert (ids == 0).sum() == pytest.approx(area, abs=3 * np.sqrt(area) ** 0.5 + 2)
    assert set(np.unique(ids)) == {-1, 0}


@pytest.mark.parametrize("camera", CAMERAS, ids=["fisheye", "pinhole"])
def test_disc_lies_where_its_centre_projects(painted, camera):
    marks = [Landmark(k, (0.5 * k - 0.4, 0.3 * (-1) ** k), 0.15, True) for k in range(4)]
    _, ids, _, _ = painted(camera, marks)
    for mark in marks:
        u, v = projected(camera, view_from(), [*mark.position, 0.0])[0]
        assert ids[round(v), round(u)] == mark.id


def test_black_and_white_paint(renderer_of, scene_of, floor):
    grey = Material((0.5, 0.4, 0.3), 1.0, specular=0.0)
    marks = [Landmark(0, (0.0, 0.0), 0.2, True), Landmark(1, (0.0, 0.5), 0.2, False)]
    picture = renderer_of(scene_of(floor(4.0, grey), landmarks=marks), CAMERAS[0], MOUNT).render(POSE)
    sky = picture.diffuse[1]
    for mark, colour in zip(marks, ([1.0] * 3, [0.0] * 3), strict=True):
        u, v = projected(CAMERAS[0], view_from(), [*mark.position, 0.0])[0]
        np.testing.assert_allclose(sky[round(v), round(u)] * np.pi, colour, atol=1e-5)
        assert picture.landmark[round(v), round(u)] == mark.id


def test_paint_lies_on_the_floor_alone(painted):
    """A box that stands on half of the disc hides it."""
    mark = Landmark(0, (0.0, 0.0), 0.2, True)
    bare, *_ = painted(CAMERAS[0], [mark])
    block = surface("block", BLACK, box((-0.3, -0.3, 0), (0.3, 0.0, 0.5)))
    share, ids, gbuffer, _ = painted(CAMERAS[0], [mark], block)
    assert 0 < share.sum() < 0.6 * bare.sum()
    assert not share[gbuffer.surface == 1].any()
    assert (ids[gbuffer.surface == 1] == -1).all()


def brute_force_share(camera, T, mark, low, high, count=200):
    """Share of a dense grid of the disc's points that is in the picture and not behind an upright box."""
    grid = np.linspace(-1, 1, count)
    x, y = (g.ravel() for g in np.meshgrid(grid, grid))
    keep = x**2 + y**2 <= 1
    points = np.stack([x, y, 0 * x], axis=-1)[keep] * mark.radius + [*mark.position, 0.0]
    u, v = projected(camera, T, points).T
    inside = (u >= -0.5) & (u <= camera.width - 0.5) & (v >= -0.5) & (v <= camera.height - 0.5)
    step = T[:3, 3] - points
    with np.errstate(divide="ignore"):
        one, other = (np.array(low) - points) / step, (np.array(high) - points) / step
    enter, leave = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
    hidden = (enter < leave) & (leave > 1e-9) & (enter < 1)
    return np.mean(inside & ~hidden)


@pytest.mark.parametrize("camera", CAMERAS, ids=["fisheye", "pinhole"])
def test_visible_share_is_that_of_brute_force(renderer_of, scene_of, floor, camera):
    """Behind a box, partly behind it, in the open, on the picture's edge, out of it, behind the camera."""
    low, high = (-0.3, -0.4, 0.0), (-0.1, 0.1, 0.4)
    places = [(0.3, -0.1), (0.25, 0.15), (0.4, 0.22), (0.5, 1.0), (-1.45, 0.9), (-1.1, 0.3), (-3.0, 0.2)]
    marks = [Landmark(k, place, 0.2, True) for k, place in enumerate(places)]
    block = surface("block", BLACK, box(low, high))
    share = (
        renderer_of(scene_of(floor(4.0), block, landmarks=marks), camera, MOUNT).render(POSE).visible_share
    )
    expected = [brute_force_share(camera, view_from(), mark, low, high) for mark in marks]
    np.testing.assert_allclose(share, expected, atol=0.05)
    assert share.min() == 0 and share.max() == 1
    assert ((share > 0.1) & (share < 0.9)).any()


def test_disc_on_inlays_is_the_disc_on_one_floor(gbuffer_of, scene_of, floor):
    """Tiles of two colours carry a disc as one floor does."""
    mark = Landmark(0, (0.1, -0.2), 0.2, white=True)
    light, dark = checker((-4, -4, 0), (8, 0, 0), (0, 8, 0), (32, 32))
    tiles = (surface("light", BLACK, light), surface("dark", BLACK, dark))
    ids = []
    for scene in (
        scene_of(floor(4.0, BLACK), landmarks=[mark]),
        replace(scene_of(*tiles, landmarks=[mark]), inlays=("dark",)),
    ):
        gbuffer = gbuffer_of(scene, CAMERAS[0], view_from())
        share = np.zeros((240, 320, 3), np.float32)
        ids.append(paint(gbuffer, Discs.of(scene), share))
    assert (ids[0] == 0).sum() > 100
    assert (ids[0] != ids[1]).sum() <= 3  # a ray on the edge of two tiles


@pytest.mark.parametrize("name", ["atrium", "corridor", "office", "regular", "tabletop", "warehouse"])
def test_visible_shares_are_those_of_the_pixels(gbuffer_of, name):
    """In every scene, a disc's share of its projected area is the share of pixels that show it."""
    scene, camera = library.load(name), Fisheye(640, 480, 150.0)
    mesh = build_mesh(scene)
    caster = RayCaster(mesh.vertices, mesh.triangles, threads=1)
    discs, shares = Discs.of(scene), []
    samples = disc_samples(discs)
    for pose in scene.tour.poses[:: max(1, len(scene.tour.poses) // 4)]:
        T = T_world_robot(pose) @ MOUNT.T_robot_camera
        gbuffer = gbuffer_of(scene, camera, T)
        ids = paint(gbuffer, discs, np.zeros((480, 640, 3), np.float32))
        occluded = caster.occluded(gbuffer.view.origin, (samples - gbuffer.view.origin) * 0.999, far=1.0)
        for mark, share in zip(
            scene.landmarks, visible_share(gbuffer, discs, occluded, samples), strict=True
        ):
            if (np.array([*mark.position, 0.0]) - T[:3, 3]) @ T[:3, 2] < 0.2:  # beside or behind the camera
                continue
            area, _ = area_and_centroid(outline(camera, T, mark))
            if area < 150:
                continue
            assert (ids == mark.id).sum() / area == pytest.approx(share, abs=0.12)
            shares.append(share)
    assert len(shares) >= 8
    assert max(shares) == 1


def test_disc_samples_are_spread_evenly(scene_of, floor):
    """On a disc of radius r the mean squared distance from the centre is r² / 2, and none lies outside."""
    scene = scene_of(floor(), landmarks=[Landmark(0, (0.3, -0.2), 0.2, True)])
    offset = disc_samples(Discs.of(scene))[0] - [0.3, -0.2, 0.0]
    squared = (offset**2).sum(axis=1)
    assert squared.max() < 0.2**2
    assert squared.mean() == pytest.approx(0.2**2 / 2, rel=0.01)
    np.testing.assert_allclose(offset.mean(axis=0), 0.0, atol=0.005)


def test_scene_without_landmarks(painted, gbuffer_of):
    share, ids, gbuffer, discs = painted(CAMERAS[1], [])
    assert not share.any() and (ids == -1).all()
    occluded = np.zeros((0, 48), dtype=bool)
    assert visible_share(gbuffer, discs, occluded, disc_samples(discs)).shape == (0,)
