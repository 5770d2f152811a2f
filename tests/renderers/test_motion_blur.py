"""Motion blur against the mean of many pictures taken along the exposure, and against formulas."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.camera import Fisheye, Mount, Pinhole
from renderers.irradiance import BakeQuality
from renderers.motion_blur import image_velocity, motion_blurred
from renderers.optics import Optics, through_lens
from scenes.model import Bulb, Landmark, Material
from scenes.tour import body_twist, drive

CAMERA = Pinhole(80, 60, 70.0)
DOWN = Mount(height_m=1.0, pitch_deg=90.0)


def test_a_floor_seen_from_above_moves_by_f_v_over_h():
    """The camera looks down, its top forward: driving moves the floor down, turning left turns it."""
    depth = np.ones((60, 80), np.float32)
    ahead = image_velocity(CAMERA, DOWN, np.array([0.5, 0.0, 0.0]), depth)
    np.testing.assert_allclose(ahead[..., 1], 0.5 * CAMERA.focal, rtol=1e-4)
    np.testing.assert_allclose(ahead[..., 0], 0.0, atol=1e-3)
    turn = image_velocity(CAMERA, DOWN, np.array([0.0, 0.0, 0.3]), depth)
    v, u = np.mgrid[:60, :80] - np.array([29.5, 39.5])[:, None, None]
    np.testing.assert_allclose(turn, 0.3 * np.stack([-v, u], axis=-1), atol=2e-3)


def test_image_velocity_is_longuet_higgins_and_prazdny_s():
    """Their equations 2.10 for a level camera, in its axes: u = (x W − U) / Z + A x y − B (1 + x²) + C y."""
    level, rng = Mount(1.0, 0.0, 0.0), np.random.default_rng(2)
    depth = rng.uniform(1.0, 5.0, (60, 80)).astype(np.float32)
    vx, vy, turning = 0.7, 0.1, 0.4
    found = image_velocity(CAMERA, level, np.array([vx, vy, turning]), depth) / CAMERA.focal
    v, u = (np.mgrid[:60, :80] - np.array([29.5, 39.5])[:, None, None]) / CAMERA.focal
    U, W, B = -vy, vx, -turning  # robot's left is the camera's −x, its forward z, its up −y
    np.testing.assert_allclose(found[..., 0], (u * W - U) / depth - B * (1 + u * u), atol=1e-5)
    np.testing.assert_allclose(found[..., 1], v * W / depth - B * u * v, atol=1e-5)


def test_the_sky_moves_by_the_turn_alone():
    camera = Fisheye(64, 48, 150.0)
    sky = np.zeros((48, 64), np.float32)
    assert not image_velocity(camera, Mount(), np.array([2.0, 0.0, 0.0]), sky).any()
    turned = image_velocity(camera, Mount(1.0, 0.0, 0.0), np.array([2.0, 0.0, 0.5]), sky)
    np.testing.assert_allclose(turned[24, 20:40, 0], 0.5 * camera.focal, rtol=0.01)  # equidistant: even


@pytest.mark.parametrize("length", [0.5, 1.0, 2.3, 7.0])
@pytest.mark.parametrize("angle", [0.0, np.pi / 2, np.pi / 4])
def test_a_point_becomes_a_line_of_the_way_s_length(length, angle):
    """Energy 1 and variance L² / 12 along the way, none across it."""
    light = np.zeros((41, 41, 3), np.float32)
    light[20, 20] = 1.0
    way = length * np.array([np.cos(angle), np.sin(angle)])
    velocity = np.broadcast_to(way, (41, 41, 2)).astype(np.float32)
    line = motion_blurred(light, velocity, 1.0)[..., 1].astype(float)
    v, u = np.mgrid[-20:21, -20:21]
    along, across = u * np.cos(angle) + v * np.sin(angle), v * np.cos(angle) - u * np.sin(angle)
    assert line.sum() == pytest.approx(1.0, rel=1e-5)
    assert (line * along**2).sum() == pytest.approx(length**2 / 12, rel=1e-3)
    assert (line * across**2).sum() == pytest.approx(0.0, abs=1e-6)


def test_an_even_picture_stays_even_and_a_short_way_changes_nothing():
    rng = np.random.default_rng(1)
    velocity = rng.normal(0, 5, (30, 40, 2)).astype(np.float32)
    even = np.full((30, 40, 3), 7.0, np.float32)
    np.testing.assert_allclose(motion_blurred(even, velocity, 1.0), even, rtol=1e-6)
    noise = rng.random((30, 40, 3)).astype(np.float32)
    assert motion_blurred(noise, velocity, 0.0) is noise
    np.testing.assert_array_equal(motion_blurred(noise, 0 * velocity + 0.2, 1.0), noise)


def test_it_is_linear_so_that_diffuse_and_specular_add_up():
    rng = np.random.default_rng(4)
    one, other = rng.lognormal(0, 2, (2, 30, 40, 3)).astype(np.float32)
    velocity = rng.normal(0, 3, (30, 40, 2)).astype(np.float32)
    apart = motion_blurred(one, velocity, 1.0) + motion_blurred(other, velocity, 1.0)
    np.testing.assert_allclose(motion_blurred(one + other, velocity, 1.0), apart, rtol=1e-5)


@pytest.fixture(scope="module")
def polished(floor, scene_of, renderer_of):
    """A glossy floor with discs and two lamps, driven over along an arc: renderer and light of the middle."""
    material = Material((0.4, 0.35, 0.3), roughness=0.25)
    discs = [Landmark(k, (0.7 + 0.5 * k, 0.3 * (-1) ** k), 0.12, white=k % 2 == 0) for k in range(4)]
    lamps = [Bulb((1.6, 0.4, 2.0), 1.0), Bulb((2.4, -0.8, 2.0), 1.0)]
    scene = scene_of(floor(6.0, material), bulbs=lamps, landmarks=discs)
    return renderer_of(scene, CAMERA, Mount(), supersampling=3, quality=BakeQuality(16, 16, 0), mirrored=True)


@pytest.mark.parametrize(
    ("twist", "left"),
    [((0.93, 0.0, 0.0), (0.65, 1.1)), ((0.93, 0.0, 1.2), (0.3, 0.3)), ((0.0, 0.0, 1.5), (0.25, 0.2))],
)
def test_against_pictures_along_the_exposure(polished, twist, left):
    """Share of the sharp picture's error that is left, for 1/20 s: of diffuse and of specular light.

    Driving straight on, a lamp's image hardly moves; blurred as the floor it would be eight times as wrong as
    not blurred at all.
    """
    seconds, (v, _, w) = 0.05, twist
    times = (np.arange(11) + 0.5) / 11 * seconds - seconds / 2
    poses = [
        (t * v * np.sinc(w * t / 2 / np.pi) * np.cos(w * t / 2), v * t * np.sin(w * t / 2), w * t)
        for t in times
    ]
    pictures = [polished.render(np.array(pose)) for pose in poses]
    k = pictures[0].layers.index("bulbs")
    middle = pictures[5]
    for part, depth, share in zip(
        ("diffuse", "specular"), (middle.depth, middle.mirror_depth), left, strict=True
    ):
        velocity = image_velocity(CAMERA, Mount(), np.array(twist), depth)
        sharp = getattr(middle, part)[k]
        true = np.mean([getattr(picture, part)[k] for picture in pictures], axis=0)
        found = motion_blurred(sharp, velocity, seconds)
        assert rms(found - true) < share * rms(sharp - true)
        assert found.mean() == pytest.approx(true.mean(), rel=0.01)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def test_order_of_lens_and_motion_hardly_matters(polished):
    """The point spread on the basis, then motion, against motion first, as light has it."""
    basis, lens = polished.render(np.zeros(3)), Optics("natural", 0.7, 0.03)
    velocity = image_velocity(CAMERA, Mount(), np.array([0.93, 0.0, 1.2]), basis.depth)
    light = basis.diffuse[basis.layers.index("bulbs")]
    ours = motion_blurred(through_lens(lens, CAMERA, light), velocity, 0.033)
    exact = through_lens(lens, CAMERA, motion_blurred(light, velocity, 0.033))
    assert rms(ours - exact) < 0.02 * rms(exact)


def test_twists_of_a_drive():
    circle = 2.0 * np.stack([np.cos(a := np.linspace(0, 2 * np.pi, 2001)[:-1]), np.sin(a)], axis=1)
    tour = drive(circle, 0.0, 6.0, 0.8, 0.5)
    for frame in (0, 3, len(tour.stamps) - 1):
        np.testing.assert_allclose(body_twist(tour, frame), [0.8, 0.0, 0.4], atol=5e-3)
    assert not body_twist(drive(circle, 0.0, 0.0, 0.8, 0.5), 0).any()
