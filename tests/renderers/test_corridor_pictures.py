"""The corridor end to end with few rays: what a picture of it must show."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.basis import relight
from renderers.camera import Fisheye, Mount
from renderers.irradiance import BakeQuality
from renderers.sensor import Sensor
from renderers.truth import record
from scenes import library

CHEAP = BakeQuality(sky_rays=64, bounce_rays=16, bounces=3)
WHITE = np.ones(3)


@pytest.fixture(scope="module")
def corridor():
    return library.load("corridor")


@pytest.fixture(scope="module")
def bases(corridor, renderer_of):
    renderer = renderer_of(corridor, Fisheye(160, 120, 150.0), Mount(), quality=CHEAP)
    return [renderer.render(pose) for pose in corridor.tour.poses[[0, 12, 50]]]


def lit(basis, sun, sky, bulbs):
    intensity = {"sun": sun, "sky": sky, "bulbs": bulbs}
    return relight(basis, intensity, dict.fromkeys(basis.layers, WHITE))


def test_corridor_is_closed_but_for_its_windows(corridor, bases):
    for basis in bases:
        assert np.isfinite(basis.diffuse).all() and np.isfinite(basis.specular).all()
        assert (basis.diffuse >= 0).all() and (basis.specular >= 0).all()
        assert (basis.surface == -1).mean() < 0.1
        near = basis.depth[basis.depth > 0]
        assert np.percentile(near, 95) < 20.0
        assert set(np.unique(basis.landmark)) - {-1} <= {m.id for m in corridor.landmarks}
        assert (basis.visible_share > 0.5).sum() >= 3


def test_office_light_from_the_bulbs(bases):
    """14 bulbs of 800 lm in 145 m² of corridor with bright walls: tens to hundreds of lux."""
    for basis in bases:
        diffuse, _ = lit(basis, 0.0, 0.0, 800.0)
        floor = (basis.surface == 0) & (basis.landmark == -1)
        lux = np.pi * diffuse[floor][:, 1] / 0.20  # the floor's green reflectance
        assert 20 < np.median(lux) < 400


@pytest.mark.parametrize("layer", ["sun", "bulbs"])
def test_more_light_more_highlight(bases, layer):
    """At a fixed exposure the true mask grows with the light."""
    sensor = Sensor(exposure_s=0.004)
    shares = []
    for strength in (0.1, 1.0, 10.0):
        sun, bulbs = (20_000.0 * strength, 800.0) if layer == "sun" else (0.0, 800.0 * strength)
        masks = [
            record(sensor, *lit(basis, sun, sun / 8, bulbs), WHITE, np.random.default_rng(0)).light
            for basis in bases
        ]
        shares.append(np.mean(masks))
    assert shares[0] < shares[1] < shares[2]


def test_recorded_discs_are_black_and_white(corridor, bases):
    """In a picture by bulb light, white discs are brighter than the floor about them, black ones darker."""
    white = {m.id: m.white for m in corridor.landmarks}
    compared = 0
    for basis in bases:
        shot = record(Sensor(), *lit(basis, 0.0, 0.0, 800.0), WHITE, np.random.default_rng(0))
        for mark in set(np.unique(basis.landmark)) - {-1}:
            on = basis.landmark == mark
            if on.sum() < 30:
                continue
            v, u = np.argwhere(on).mean(axis=0).astype(int)
            about = np.zeros_like(on)
            about[max(v - 10, 0) : v + 10, max(u - 10, 0) : u + 10] = True
            about &= (basis.surface == 0) & (basis.landmark == -1)
            difference = shot.diffuse[on].mean() - shot.diffuse[about].mean()
            assert difference > 30 if white[mark] else difference < -15
            compared += 1
    assert compared >= 6
