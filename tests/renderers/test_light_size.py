"""Lamps and the sun have a size: penumbras and highlights against geometry done by hand."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.camera import Mount, Pinhole, T_world_robot
from renderers.irradiance import DIRECT_ONLY
from renderers.lights import SUN_RADIUS, BulbLight, SunLight
from renderers.lobe_albedo import albedo_table, directional_albedo
from renderers.mesh import RayCaster
from renderers.shade import shade_light
from renderers.shadows import PATTERN, POINTS, disc_points, interleaved, lit_share
from scenes.geometry import rectangle, surface
from scenes.model import Bulb, Material
from scenes.photometry import Photometry

BLACK = Material((0.0, 0.0, 0.0), roughness=1.0, specular=0.0)


def half_plane(height):
    """A sheet over all x > 0."""
    return rectangle((0, -50, height), (50, 0, 0), (0, 100, 0), 100.0)


def uncovered(distance):
    """Share of a unit disc on the free side of a straight edge this far from its centre."""
    d = np.clip(distance, -1, 1)
    return 1 - (np.arccos(d) - d * np.sqrt(1 - d**2)) / np.pi


def share_on_floor(light, height, x):
    vertices, triangles = half_plane(height)
    points = np.stack([x, np.zeros_like(x), np.zeros_like(x)], axis=-1).astype(np.float32)
    normals = np.tile(np.float32([0, 0, 1]), (len(x), 1))
    caster = RayCaster(vertices.astype(np.float32), triangles, threads=1)
    return lit_share(light, points, normals, np.arange(len(points)), caster, POINTS)


def test_bulbs_penumbra_is_as_wide_as_similar_triangles_say():
    """Sphere of radius r at height h over an edge at t: r t / (h − t) to each side of the edge's shadow."""
    r, h, t = 0.1, 2.0, 0.5
    x = np.linspace(-0.06, 0.06, 121)
    share = share_on_floor(BulbLight("lamp", 0, (0.0, 0.0, h), r), t, x)
    expected = uncovered(-x / (r * t / (h - t)))
    np.testing.assert_allclose(share, expected, atol=2 / POINTS)
    assert np.mean(share - expected) == pytest.approx(0, abs=0.01)


def test_suns_penumbra_is_half_a_degree_wide():
    t = 4.0
    x = np.linspace(-0.03, 0.03, 121)
    share = share_on_floor(SunLight("sun", (0.0, 0.0, 1.0)), t, x)
    expected = uncovered(-x / (t * SUN_RADIUS))
    np.testing.assert_allclose(share, expected, atol=2 / POINTS)
    assert 2 * np.degrees(SUN_RADIUS) == pytest.approx(0.533, abs=0.001)


def test_picture_has_soft_shadows_with_all_steps(renderer_of, scene_of, floor, on_floor):
    """The refined pixels of a picture agree with the analytic penumbra, the others are lit or dark."""
    r, h, t = 0.15, 2.0, 0.6
    sheet = surface("sheet", BLACK, half_plane(t))
    camera, eye = Pinhole(64, 48, 40.0), Mount(height_m=0.5, pitch_deg=90.0)
    scene = scene_of(floor(4.0), sheet, bulbs=[Bulb((0.0, 0.0, h), 1.0, radius=r)])
    picture = renderer_of(scene, camera, eye).render(np.zeros(3))
    points = on_floor(camera, T_world_robot(np.zeros(3)) @ eye.T_robot_camera)
    squared = (points[..., 0] ** 2 + points[..., 1] ** 2 + h**2)[..., None]
    unshadowed = np.array([0.6, 0.4, 0.2]) / np.pi * h / squared**1.5 / (4 * np.pi)
    share = picture.diffuse[2] / unshadowed
    wide = r * t / (h - t)
    expected = uncovered(-points[..., 0] / wide)
    bounced = np.abs(points[..., 0]) > 1.2 * wide
    np.testing.assert_allclose(share[..., 1][~bounced], expected[~bounced], atol=0.12)
    assert len(np.unique(np.round(share[..., 1][~bounced] * POINTS))) > 10


def test_any_four_by_four_pixels_try_all_points():
    assert sorted(PATTERN.ravel()) == list(range(POINTS))
    numbers = interleaved((11, 9)).reshape(11, 9)
    for row, column in ((0, 0), (3, 2), (7, 5)):
        assert sorted(numbers[row : row + 4, column : column + 4].ravel()) == list(range(POINTS))
    disc = disc_points()
    assert (np.hypot(*disc.T) < 1).all()
    np.testing.assert_allclose(disc.mean(axis=0), 0, atol=0.06)
    assert (disc**2).sum(axis=1).mean() == pytest.approx(0.5, abs=0.01)  # as of an even disc


def shine(spread, roughness, to_light, to_eye):
    """Specular light of white metal that faces up, per lux, (n,)."""
    n = len(to_eye)

    def column(value):
        return np.full(n, value, dtype=np.float32)

    diffuse, specular = np.zeros((n, 3), np.float32), np.zeros((n, 3), np.float32)
    shade_light(
        np.tile(np.float32([0, 0, 1]), (n, 1)),
        np.asarray(to_eye, dtype=np.float32),
        np.tile(np.float32(to_light), (n, 1)),
        column(1.0),
        column(spread),
        np.ones((n, 3), np.float32),
        column(roughness),
        column(1.0),
        column(1.0),
        diffuse,
        specular,
    )
    return specular[:, 0]


def cone(axis, half_angle, count=300):
    """Directions about an axis in the xz plane, and their solid angles."""
    polar, azimuth = (
        grid.ravel()
        for grid in np.meshgrid(
            (np.arange(count) + 0.5) / count * half_angle, (np.arange(count) + 0.5) / count * 2 * np.pi
        )
    )
    side = np.array([axis[2], 0, -axis[0]])
    rays = (
        np.cos(polar)[:, None] * axis
        + (np.sin(polar) * np.cos(azimuth))[:, None] * side
        + (np.sin(polar) * np.sin(azimuth))[:, None] * np.array([0, 1.0, 0])
    )
    return rays, np.sin(polar) * half_angle / count * 2 * np.pi / count


@pytest.mark.parametrize("roughness", [0.05, 0.1, 0.2, 0.3])
@pytest.mark.parametrize("spread", [SUN_RADIUS, 0.03, 0.1])
def test_highlight_of_a_disc_has_the_energy_of_a_points(roughness, spread):
    to_light = np.array([0.6, 0, 0.8])
    rays, solid = cone(np.array([-0.6, 0, 0.8]), 0.6)
    small, large = (shine(s, roughness, to_light, rays) @ (solid * rays[:, 2]) for s in (1e-6, spread))
    assert large == pytest.approx(small, rel=0.04)


def test_smooth_surface_shows_the_lamp_as_bright_and_as_large_as_it_is():
    """A mirror image has the lamp's luminance E / (π s²) inside of its disc and ends with it."""
    spread, to_light = 0.05, np.array([0.0, 0, 1.0])
    polar = np.linspace(0, 2 * spread, 81)
    rays = np.stack([np.sin(polar), 0 * polar, np.cos(polar)], axis=-1)
    image = shine(spread, 0.03, to_light, rays) * np.pi * spread**2
    inside = image[polar < 0.7 * spread]
    assert inside.mean() == pytest.approx(1.0, abs=0.15)
    assert image[polar > 1.5 * spread].max() < 0.1
    half = polar[np.argmin(np.abs(image - 0.5))]
    assert half == pytest.approx(spread, rel=0.15)


def test_large_lamp_far_away_is_a_point(renderer_of, scene_of, floor):
    glossy = floor(4.0, Material((0.5, 0.3, 0.2), roughness=0.3))
    camera, eye = Pinhole(32, 24, 60.0), Mount(height_m=1.5, pitch_deg=60.0)
    one, other = (
        renderer_of(scene_of(glossy, bulbs=[Bulb((1.0, 0.0, 15.0), 1.0, radius=r)]), camera, eye).render(
            np.zeros(3)
        )
        for r in (0.001, 0.2)
    )
    np.testing.assert_allclose(one.diffuse[2], other.diffuse[2], rtol=1e-4)  # the larger globe reflects more
    np.testing.assert_allclose(one.specular[2], other.specular[2], rtol=0.01)


def test_spot_lights_its_cone_alone(renderer_of, scene_of, downwards, floor, on_floor):
    web = Photometry.spot(15.0, 25.0)
    lamp = Bulb((0.2, 0.1, 2.0), lumen=1.0, radius=0.01, photometry=web)
    camera = Pinhole(81, 81, 60.0)
    view = renderer_of(scene_of(floor(4.0), bulbs=[lamp]), camera, downwards).render(np.zeros(3))
    picture = view.diffuse[2]
    offset = np.asarray(lamp.position) - on_floor(camera, downwards.T_robot_camera)
    angle = np.degrees(np.arctan2(np.hypot(offset[..., 0], offset[..., 1]), offset[..., 2]))
    assert not picture[angle > 25.01].any()
    inside = (angle < 15) & (view.surface == 0)
    lux = web.candela_per_lumen[0, 0] * offset[..., 2] / (offset**2).sum(axis=-1) ** 1.5
    expected = lux[..., None] * np.array([0.6, 0.4, 0.2]) / np.pi
    np.testing.assert_allclose(picture[inside], expected[inside], rtol=2e-3)


def test_web_is_turned_about_the_lamps_axis(renderer_of, scene_of, downwards, floor, on_floor):
    """Light towards the half-plane at 0° alone falls on the side of +x under a lamp that looks down."""
    web = Photometry.of(
        np.array([0.0, 90.0]),
        np.array([0.0, 89.0, 91.0, 269.0, 271.0, 360.0]),
        np.array([[1, 1], [1, 1], [0, 0], [0, 0], [1, 1], [1, 1.0]]),
    )
    lamp = Bulb((0.0, 0.0, 2.0), lumen=1.0, radius=0.01, photometry=web)
    camera = Pinhole(81, 81, 60.0)
    view = renderer_of(scene_of(floor(4.0), bulbs=[lamp]), camera, downwards, quality=DIRECT_ONLY)
    picture = view.render(np.zeros(3)).diffuse[2]
    x = on_floor(camera, downwards.T_robot_camera)[..., 0]
    assert (picture[x > 0.05] > 0).all() and not picture[x < -0.05].any()


@pytest.mark.parametrize("roughness", [0.05, 0.2, 0.35, 0.6, 1.0])
@pytest.mark.parametrize("metallic", [0.0, 1.0])
def test_white_furnace(renderer_of, scene_of, floor, roughness, metallic):
    """White ground under a uniform sky: a dielectric reflects all, a metal what its single lobe keeps."""
    ground = floor(40.0, Material((1.0, 1.0, 1.0), roughness, metallic), 80.0)
    picture = renderer_of(scene_of(ground), Pinhole(16, 12, 60.0), Mount(1.0, 0.0, 60.0)).render(np.zeros(3))
    radiance = np.pi * (picture.diffuse[1] + picture.specular[1])
    if metallic == 0:
        np.testing.assert_allclose(radiance, 1.0, rtol=1e-3)
    else:
        rays = T_world_robot(np.zeros(3)) @ Mount(1.0, 0.0, 60.0).T_robot_camera
        nv = -(rays[:3, :3] @ Pinhole(16, 12, 60.0).unproject(np.array([8.0, 6.0])))[2]
        assert radiance[6, 8, 1] == pytest.approx(
            sum(directional_albedo(albedo_table(), nv, roughness)), rel=5e-3
        )


def test_number_of_threads_changes_no_byte(renderer_of, scene_of, floor):
    from renderers.basis import SceneRenderer

    sheet = surface("sheet", BLACK, rectangle((0, -1, 0.5), (1, 0, 0), (0, 2, 0), 1.0))
    scene = scene_of(
        floor(2.0, Material((0.5,) * 3, 0.2)), sheet, bulbs=[Bulb((0.2, 0.0, 1.5), 1.0, radius=0.1)]
    )
    camera, eye = Pinhole(64, 48, 70.0), Mount(height_m=1.2, pitch_deg=50.0)
    one, two = (
        SceneRenderer(scene, camera, eye, threads=n).render(np.array([-1.0, 0.0, 0.0])) for n in (1, 2)
    )
    assert one.diffuse.tobytes() == two.diffuse.tobytes()
    assert one.specular.tobytes() == two.specular.tobytes()
