"""Direct light where it must and must not arrive, from geometry done by hand."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.camera import Mount, Pinhole, T_world_robot
from renderers.irradiance import DIRECT_ONLY
from scenes.geometry import box, rectangle, surface
from scenes.model import Bulb, Material, Sun

CAMERA = Pinhole(81, 81, 60.0)
ALBEDO = np.array([0.6, 0.4, 0.2])
BLACK = Material((0.0, 0.0, 0.0), roughness=1.0, specular=0.0)


def direct(renderer_of, scene, mount, layer):
    """A layer's light; with matt, single surfaces and no sky there is no other than direct light."""
    basis = renderer_of(scene, CAMERA, mount).render(np.zeros(3))
    assert not basis.specular.any()
    return basis.diffuse[basis.layers.index(layer)]


def test_bulb_of_800_lumen_gives_15_9_lux_at_two_metres(renderer_of, scene_of, downwards, floor):
    bulb = Bulb((0.3, 0.0, 2.0), lumen=800.0, radius=0.001)
    picture = 800.0 * direct(renderer_of, scene_of(floor(4.0), bulbs=[bulb]), downwards, "bulbs")
    T = T_world_robot(np.zeros(3)) @ downwards.T_robot_camera
    pixel, _ = CAMERA.project((np.array([0.3, 0.0, 0.0]) - T[:3, 3]) @ T[:3, :3])
    foot = picture[round(pixel[1]), round(pixel[0])]
    assert 800 / (4 * np.pi * 2.0**2) == pytest.approx(15.9, abs=0.05)
    np.testing.assert_allclose(foot, ALBEDO * 15.915 / np.pi, rtol=3e-3)  # light is taken 2 mm off the floor


def test_bulb_obeys_lambert_and_the_inverse_square_everywhere(
    renderer_of, scene_of, downwards, floor, on_floor
):
    place = np.array([0.5, -0.4, 1.7])
    scene = scene_of(floor(4.0), bulbs=[Bulb(tuple(place), lumen=1.0, radius=0.001)])
    picture = direct(renderer_of, scene, downwards, "bulbs")
    offset = place - on_floor(CAMERA, downwards.T_robot_camera)
    squared = (offset**2).sum(axis=-1)
    lux = 1 / (4 * np.pi) / squared * (place[2] / np.sqrt(squared))
    np.testing.assert_allclose(picture, lux[..., None] * ALBEDO / np.pi, rtol=5e-3)  # rays start 2 mm up


@pytest.mark.parametrize("elevation", [12.0, 45.0, 90.0])
def test_sun_obeys_lambert(renderer_of, scene_of, downwards, floor, elevation):
    scene = scene_of(floor(4.0), sun=Sun(30.0, elevation, lux=1.0))
    picture = direct(renderer_of, scene, downwards, "sun")
    expected = np.sin(np.radians(elevation)) * ALBEDO / np.pi
    np.testing.assert_allclose(picture, np.broadcast_to(expected, picture.shape), rtol=1e-5)


@pytest.mark.parametrize(("elevation", "lit"), [(0.1, True), (-0.1, False), (-40.0, False)])
def test_sun_below_the_horizon_is_dark(renderer_of, scene_of, floor, elevation, lit):
    """A wall that faces the low sun over a small floor, which would not shade it from below."""
    grey = Material((0.5, 0.5, 0.5), roughness=1.0, specular=0.0)
    wall = surface("wall", grey, rectangle((2, -2, 0), (0, 0, 2), (0, 4, 0)))
    scene = scene_of(floor(0.1), wall, sun=Sun(270.0, elevation, lux=1.0))
    picture = direct(renderer_of, scene, Mount(height_m=1.0, pitch_deg=0.0), "sun")
    assert picture.any() == lit


@pytest.mark.parametrize(("azimuth", "axis", "sign"), [(90.0, 0, -1), (180.0, 1, 1), (0.0, 1, -1)])
def test_compass_bearing_of_the_sun(renderer_of, scene_of, floor, downwards, on_floor, azimuth, axis, sign):
    """A post's shadow points away from the sun: west of it when the sun stands in the east."""
    post = surface("post", BLACK, box((-0.05, -0.05, 0), (0.05, 0.05, 0.5)))
    scene = scene_of(floor(4.0), post, sun=Sun(azimuth, 45.0, lux=1.0))
    dark = direct(renderer_of, scene, downwards, "sun")[..., 2] == 0
    points = on_floor(CAMERA, downwards.T_robot_camera)[dark]
    assert np.mean(points[:, axis]) * sign > 0.1
    assert abs(np.mean(points[:, 1 - axis])) < 0.05


def test_wall_in_the_sun_throws_a_shadow_of_height_over_tangent(
    renderer_of, scene_of, floor, downwards, on_floor
):
    """The wall stands at x = 0.5 on the sun's side; its shadow ends at 0.5 − h / tan e."""
    height, elevation = 0.8, 40.0
    wall = surface("wall", BLACK, rectangle((0.5, -4, 0), (0, 0, height), (0, 8, 0)))
    scene = scene_of(floor(4.0), wall, sun=Sun(90.0, elevation, lux=1.0))
    lit = direct(renderer_of, scene, downwards, "sun")[..., 2] > 0
    points = on_floor(CAMERA, downwards.T_robot_camera)
    end = 0.5 - height / np.tan(np.radians(elevation))
    x, pixel = points[..., 0], 3.0 / CAMERA.focal
    # beyond the wall's foot the camera sees the wall itself
    np.testing.assert_array_equal(lit[x < end - pixel], True)
    np.testing.assert_array_equal(lit[(x > end + pixel) & (x < 0.5 - pixel)], False)


def test_plate_under_a_bulb_throws_its_enlarged_outline(renderer_of, scene_of, floor, on_floor):
    """A plate of half-width w at height t under a bulb at height h shades w h / (h − t) of the floor."""
    half, t, h = 0.3, 0.5, 1.5
    plate = surface("plate", BLACK, box((-half, -half, t), (half, half, t + 0.001), bottom=True))
    scene = scene_of(floor(4.0), plate, bulbs=[Bulb((0, 0, h), 1.0, radius=0.01)])
    below = Mount(height_m=0.45, pitch_deg=90.0)  # the camera looks from under the plate
    camera = Pinhole(81, 81, 120.0)
    basis = renderer_of(scene, camera, below).render(np.zeros(3))
    lit = basis.diffuse[basis.layers.index("bulbs"), ..., 2] > 0
    points = np.abs(on_floor(camera, below.T_robot_camera)[..., :2]).max(axis=-1)
    edge, pixel = half * (h - 0.001) / (h - t - 0.001), 0.45 / camera.focal
    np.testing.assert_array_equal(lit[points > edge + pixel], True)
    np.testing.assert_array_equal(lit[points < edge - pixel], False)
    assert lit.any() and not lit.all()


def test_bulbs_sphere_does_not_shade_its_own_light_but_another_bulbs(
    renderer_of, scene_of, floor, downwards, on_floor
):
    low = Bulb((0.0, 0.0, 1.0), 1.0, radius=0.3, group="low")
    high = Bulb((0.0, 0.0, 2.0), 1.0, radius=0.01, group="high")
    both = scene_of(floor(4.0), bulbs=[low, high])
    eye = Mount(height_m=0.6, pitch_deg=90.0)
    basis = renderer_of(both, CAMERA, eye, quality=DIRECT_ONLY).render(np.zeros(3))
    own, other = (basis.diffuse[basis.layers.index(name), ..., 2] for name in ("low", "high"))
    assert (own > 0).all()
    away = np.linalg.norm(on_floor(CAMERA, eye.T_robot_camera)[..., :2], axis=-1)
    # the sphere's shadow cone from height 2 touches it at sin = r / 1 m; 16 sectors are a bit slimmer
    radius = 2.0 * np.tan(np.arcsin(0.3))
    assert (other[away < 0.95 * radius] == 0).all()
    assert (other[away > 1.02 * radius] > 0).all()


def test_face_turned_away_is_dark(renderer_of, scene_of, floor):
    """A wall's back, lit from the front only."""
    wall = surface(
        "wall",
        Material((0.5, 0.5, 0.5), roughness=1.0, specular=0.0),
        box((1.0, -2, 0), (1.1, 2, 2)),
    )
    scene = scene_of(floor(0.5, BLACK), wall, sun=Sun(90.0, 30.0, lux=1.0))
    eye = Mount(height_m=1.0, pitch_deg=0.0)
    picture = direct(renderer_of, scene, eye, "sun")
    assert not picture[30:50, 30:50].any()
