"""Textured surfaces against what their texels, worked out apart, must show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from renderers.appearance import _roughened
from renderers.basis import SceneRenderer
from renderers.camera import Mount, Pinhole
from renderers.irradiance import DIRECT_ONLY, BakeQuality
from renderers.texture_store import NO_TEXTURE, TextureStore
from scenes.geometry import rectangle, surface
from scenes.model import Material, Sun
from scenes.textures import Texture, Textures

WHITE = Material((1.0, 1.0, 1.0), roughness=1.0, specular=0.0)
STRAIGHT_DOWN = Mount(height_m=3.0, pitch_deg=90.0)
ORIGIN = np.zeros(3)
OVERHEAD = Sun(azimuth_deg=180.0, elevation_deg=90.0, lux=1.0)


def textured(half, textures, material=WHITE, tiles=1.0, cell=10.0):
    """A square floor about the origin whose picture has its top in the north."""
    vertices, triangles = rectangle((-half, -half, 0), (2 * half, 0, 0), (0, 2 * half, 0), cell)
    u, v = (vertices[:, 0] / half + 1) / 2, (1 - vertices[:, 1] / half) / 2
    flat = surface("floor", material, (vertices, triangles))
    return replace(flat, uv=tiles * np.stack([u, v], axis=-1), textures=textures)


def seen(scene_of, floor, sun=OVERHEAD, pixels=64, fov=60.0):
    """Diffuse luminance under one lux of sun from 3 m above, row 0 in the east: the robot faces east."""
    renderer = SceneRenderer(
        scene_of(floor, sun=sun), Pinhole(pixels, pixels, fov), STRAIGHT_DOWN, threads=1, quality=DIRECT_ONLY
    )
    return renderer.render(ORIGIN).diffuse[0]


def decoded(srgb):
    """IEC 61966-2-1, apart from the renderer's table."""
    value = np.asarray(srgb) / 255
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def test_a_textured_quad_shows_its_texels(scene_of):
    """Four texels seen from above: in each one's middle, Lambert's albedo / π of the decoded colour."""
    texels = np.array([[[255, 0, 0], [10, 200, 30]], [[188, 188, 188], [3, 5, 250]]], dtype=np.uint8)
    floor = textured(2.0, Textures(base_color=Texture(texels, srgb=True, wrap=("clamp", "clamp"))))
    camera = Pinhole(64, 64, 60.0)
    picture = seen(scene_of, floor)
    for row in range(2):
        for column in range(2):
            x, y = -1.0 + 2 * column, 1.0 - 2 * row  # the texel's middle on the floor
            v, u = 31.5 - camera.focal * x / 3, 31.5 - camera.focal * y / 3
            got = picture[int(np.clip(round(v), 0, 63)), int(np.clip(round(u), 0, 63))]
            np.testing.assert_allclose(got, decoded(texels[row, column]) / np.pi, rtol=0.02, atol=2e-3)


def test_a_fine_pattern_far_away_is_its_mean_in_linear_light(scene_of):
    """A checker much finer than a pixel: no moiré, and half of black and white is 0.5, not sRGB's middle."""
    checker = np.indices((64, 64)).sum(axis=0) % 2 * 255
    texels = np.repeat(checker[..., None], 3, axis=2).astype(np.uint8)
    floor = textured(3.0, Textures(base_color=Texture(texels, srgb=True)), tiles=20.0)
    picture = seen(scene_of, floor)
    np.testing.assert_allclose(picture[4:-4, 4:-4], 0.5 / np.pi, rtol=5e-3)


@pytest.mark.parametrize(
    "wrap, expected", [("repeat", [0, 1, 0, 1]), ("clamp", [0, 0, 1, 1]), ("mirror", [1, 0, 1, 0])]
)
def test_wrapping_beyond_the_picture(wrap, expected):
    """A black and a white texel, read at the middles of the texels −2, 0 and 1, 3 … of a row."""
    texels = np.array([[[0, 0, 0], [255, 255, 255]]], dtype=np.uint8)
    texture = Textures(base_color=Texture(texels, wrap=(wrap, "clamp")))
    store = TextureStore.of([textured(1.0, texture)], more=1)
    assert store.base_color.tolist() == [0, NO_TEXTURE]
    at = {"repeat": [-1.0, -0.5, 0, 0.5], "clamp": [-0.5, 0, 0.5, 1.0], "mirror": [0.5, 1.5, -1.0, -0.5]}[
        wrap
    ]
    uv = np.stack([np.array(at) + 0.25, np.full(4, 0.5)], axis=-1).astype(np.float32)
    if wrap == "mirror":  # texels of …, −2, −1, 0, 1, 2, 3: white black | black white | white black
        uv[:, 0] = [-0.75, -0.25, 1.25, 1.75]
    still = np.zeros((4, 2), dtype=np.float32)
    values = store.sample(np.zeros(4, dtype=np.int32), uv, still, still)[:, 0]
    np.testing.assert_allclose(values, expected, atol=1e-4)


def test_a_long_footprint_is_averaged_along_its_length_alone():
    """Stripes along v, a footprint along v: seen as sharp as without one."""
    stripes = np.zeros((64, 64, 3), dtype=np.uint8)
    stripes[:, ::2] = 255
    store = TextureStore.of([textured(1.0, Textures(base_color=Texture(stripes)))], more=0)
    uv = np.float32([[10.5 / 64, 0.5], [11.5 / 64, 0.5]])
    along, across = np.float32([[0, 6 / 64]] * 2), np.float32([[0.5 / 64, 0]] * 2)
    values = store.sample(np.zeros(2, dtype=np.int32), uv, along, across)[:, 0]
    np.testing.assert_allclose(values, [1, 0], atol=1e-4)


@pytest.mark.parametrize("axis, azimuth", [(0, 90.0), (1, 0.0)], ids=["x east along u", "y north against v"])
@pytest.mark.parametrize("tilt_deg", [-25.0, 10.0, 30.0])
def test_a_tilted_normal_gives_the_cosine_of_its_angle_to_the_light(scene_of, axis, azimuth, tilt_deg):
    vector = np.array([0.0, 0.0, np.cos(np.radians(tilt_deg))])
    vector[axis] = np.sin(np.radians(tilt_deg))
    texel = np.round((vector / 2 + 0.5) * 255).astype(np.uint8)
    normal = Texture(np.tile(texel, (2, 2, 1)))
    sun = Sun(azimuth_deg=azimuth, elevation_deg=50.0, lux=1.0)
    picture = seen(scene_of, textured(3.0, Textures(normal=normal)), sun)
    angle = np.radians(40.0 - tilt_deg)
    np.testing.assert_allclose(picture[16:48, 16:48], np.cos(angle) / np.pi, rtol=0.01)


def test_roughness_and_metallic_come_from_green_and_blue(scene_of):
    """Metal has no diffuse light; a rough highlight is dimmer than a smooth one where the sun is mirrored."""
    texels = np.zeros((1, 2, 3), dtype=np.uint8)
    texels[0, 0], texels[0, 1] = [0, 128, 0], [0, 255, 255]
    material = Material((0.5, 0.5, 0.5), roughness=0.8, metallic=1.0)
    polish = Textures(metallic_roughness=Texture(texels, wrap=("clamp", "clamp")))
    picture = seen(scene_of, textured(2.0, polish, material))
    west, east = picture[56, 32], picture[7, 32]
    assert west.min() > 0.1 and east.max() < 1e-4


def test_bumps_too_small_to_see_roughen():
    """Toksvig's rule: straight normals change nothing; α² grows by twice the variance of bent ones."""
    np.testing.assert_allclose(_roughened(np.float32([0.3, 0.7]), np.float32([1, 1])), [0.3, 0.7], rtol=1e-6)
    spread = 0.1  # two normals tilted by ±spread have a mean of length cos(spread), a variance of spread²
    alpha2 = _roughened(np.float32([0.2]), np.float32([np.cos(spread)])) ** 4
    np.testing.assert_allclose(alpha2, 0.2**4 + spread**2, rtol=0.01)


def test_bounced_light_takes_the_texture_colour(scene_of):
    """A wall lights the floor in the mean colour of its picture, as a plain wall of that colour does."""
    texels = np.zeros((8, 8, 3), dtype=np.uint8)
    texels[::2, :, 0], texels[1::2, :, 1] = 255, 128
    wall = rectangle((1, -2, 0), (0, 0, 2), (0, 4, 0), 0.5)
    plain = surface("wall", Material((0.5, 128 / 255 / 2, 0.0), 1.0, specular=0.0), wall)
    painted = surface("wall", WHITE, wall)
    uv = painted.vertices[:, 1:] / 0.5
    painted = replace(painted, uv=uv, textures=Textures(base_color=Texture(texels)))
    sun = Sun(azimuth_deg=270.0, elevation_deg=20.0, lux=1.0)
    quality = BakeQuality(sky_rays=16, bounce_rays=256, bounces=1)
    grey = Material((0.5, 0.5, 0.5), 1.0, specular=0.0)
    floor = surface("floor", grey, rectangle((-2, -2, 0), (4, 0, 0), (0, 4, 0), 1.0))
    got = []
    for side in (plain, painted):
        scene = scene_of(floor, side, sun=sun)
        renderer = SceneRenderer(scene, Pinhole(16, 16, 60.0), STRAIGHT_DOWN, threads=1, quality=quality)
        direct = SceneRenderer(scene, Pinhole(16, 16, 60.0), STRAIGHT_DOWN, threads=1, quality=DIRECT_ONLY)
        bounced = renderer.render(ORIGIN).diffuse[0] - direct.render(ORIGIN).diffuse[0]
        got.append(bounced[4:12, 4:12].mean(axis=(0, 1)))
    assert got[0][0] > 0.001
    np.testing.assert_allclose(got[1], got[0], rtol=0.03, atol=2e-4)
