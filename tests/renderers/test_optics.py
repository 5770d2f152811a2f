"""The lens against formulas, a direct convolution, and its own linearity."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import fftconvolve

from renderers.basis import LightBasis, relight
from renderers.camera import Fisheye, Pinhole, pixel_rays
from renderers.errors import RendererError
from renderers.optics import Optics, basis_through_lens, falloff, scatter, through_lens

CAMERA = Fisheye(320, 240, 150.0)
LENS = Optics("natural", 0.7, 0.05, 4.0)


@pytest.fixture(scope="module")
def room():
    return Fisheye(64, 48, 150.0)


@pytest.fixture(scope="module")
def basis_of(room):
    shape = (2, room.height, room.width, 3)
    nowhere, number = np.zeros(shape[1:3], np.float32), np.full(shape[1:3], -1, np.int32)
    layers = noise(5, shape), noise(6, shape)
    return LightBasis(("sun", "bulb"), *layers, nowhere, number, number, np.zeros(0, np.float32), nowhere)


def noise(seed, shape=(240, 320, 3)):
    return np.random.default_rng(seed).lognormal(2.0, 1.5, shape).astype(np.float32)


def lamp(height=240, width=320, v=120, u=160):
    picture = np.zeros((height, width, 3), np.float32)
    picture[v, u] = 1e6
    return picture


def test_pinhole_falls_off_with_the_fourth_power_of_the_cosine():
    camera = Pinhole(320, 240, 90.0)
    np.testing.assert_allclose(falloff(camera)[..., 0], pixel_rays(camera)[..., 2] ** 4, rtol=1e-3)


def test_fisheye_falls_off_with_its_solid_angle():
    theta = np.arccos(np.clip(pixel_rays(CAMERA)[..., 2], -1, 1))
    np.testing.assert_allclose(falloff(CAMERA)[..., 1], np.sinc(theta / np.pi), rtol=1e-3)


def test_barrel_distortion_gives_the_edges_more_light():
    """dΩ = cos³ θ dx dy on the plane z = 1, of which a pixel covers 1 / (f² r'(r) r' / r); times cos θ."""
    camera = Pinhole(320, 240, 60.0, (-0.2, 0.05, 0.0, 0.0))
    z = pixel_rays(camera)[..., 2]
    s = 1 / z**2 - 1  # r²
    expected = z**4 / ((1 - 0.2 * s + 0.05 * s**2) * (1 - 0.6 * s + 0.25 * s**2))
    np.testing.assert_allclose(falloff(camera)[..., 0], expected, rtol=1e-3)
    assert (falloff(camera)[0, 0] > 1.1 * falloff(Pinhole(320, 240, 60.0))[0, 0]).all()


def test_lens_is_linear():
    """full = diffuse + specular holds behind the lens, for any weights."""
    one, other = noise(1), noise(2)
    apart = 0.3 * through_lens(LENS, CAMERA, one) + 5.0 * through_lens(LENS, CAMERA, other)
    together = through_lens(LENS, CAMERA, np.float32(0.3) * one + np.float32(5.0) * other)
    np.testing.assert_allclose(together, apart, rtol=2e-5)


@pytest.mark.parametrize("shape", [(240, 320), (37, 91), (16, 16)])
@pytest.mark.parametrize("radius", [0.5, 4.0, 60.0])
def test_even_picture_stays_even(shape, radius):
    light = np.full((*shape, 3), 70.0, np.float32)
    np.testing.assert_allclose(scatter(light, radius), light, rtol=1e-5)


@pytest.mark.parametrize("place", [(120, 160), (0, 0), (239, 17), (60, 319)])
def test_no_light_is_lost(place):
    assert scatter(lamp(v=place[0], u=place[1]), 4.0).sum(dtype=float) == pytest.approx(3e6, rel=5e-3)


@pytest.mark.parametrize("radius", [2.0, 5.0])
def test_scattered_light_follows_the_profile(radius):
    """Ring by ring against a convolution with (1 + r²/r₀²)^−3/2 itself, in the mirrored surroundings."""
    v, u = np.mgrid[-360:360, -480:480] + 0.0
    profile = (1 + (u**2 + v**2) / radius**2) ** -1.5 / (2 * np.pi * radius**2)
    picture = np.pad(lamp()[..., 0].astype(float), ((240, 240), (320, 320)), mode="symmetric")
    exact = fftconvolve(picture, profile[1:, 1:], mode="same")[240:480, 320:640]
    mine = scatter(lamp(), radius)[..., 0]
    v, u = np.mgrid[0:240, 0:320]
    r = np.hypot(v - 120, u - 160)
    for inner, outer in [(3, 5), (6, 9), (10, 15), (16, 24), (25, 38), (40, 60), (60, 90), (90, 120)]:
        ring = (r >= inner) & (r < outer)
        assert mine[ring].mean() == pytest.approx(exact[ring].mean(), rel=0.2), inner


def test_lamp_washes_out_its_surroundings_and_nothing_goes_dark():
    dark_room = np.full((240, 320, 3), 1.0, np.float32)
    seen = through_lens(Optics(glare=0.03), CAMERA, dark_room + lamp())
    assert seen[120, 175].min() > 5.0 > seen[5, 5].min() > 1.0
    assert seen.min() >= 1.0 - 1e-4


def test_basis_behind_the_lens_gives_the_pictures_behind_the_lens(basis_of, room):
    """Relighting commutes with the lens, so one pass per pose serves every illumination."""
    intensity = {"sun": 3e4, "bulb": 700.0}
    colour = {"sun": np.array([1.1, 1, 0.9]), "bulb": np.array([1.6, 1, 0.4])}
    before = relight(basis_of, intensity, colour)
    after = relight(basis_through_lens(LENS, room, basis_of), intensity, colour)
    for light, seen in zip(before, after, strict=True):
        np.testing.assert_allclose(seen, through_lens(LENS, room, light), rtol=1e-4, atol=1e-3)


def test_ideal_lens_changes_nothing():
    assert through_lens(Optics(), CAMERA, noise(3)).tobytes() == noise(3).tobytes()


@pytest.mark.parametrize(
    "bad",
    [
        {"vignetting": "cos4"},
        {"blur_px": -1.0},
        {"blur_px": float("nan")},
        {"glare": 1.0},
        {"glare": -0.1},
        {"glare": float("nan")},
        {"glare_radius_px": 0.0},
    ],
    ids=str,
)
def test_impossible_lenses(bad):
    with pytest.raises(RendererError, match="optics: "):
        Optics(**bad)
