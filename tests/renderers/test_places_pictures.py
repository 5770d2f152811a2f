"""Every scene of the library with few rays: what a picture of it must show."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.basis import relight
from renderers.camera import Fisheye, Mount
from renderers.irradiance import BakeQuality
from scenes import library

CHEAP = BakeQuality(sky_rays=64, bounce_rays=16, bounces=3)
WHITE = np.ones(3)


@pytest.fixture(scope="module", params=["atrium", "office", "regular", "tabletop", "warehouse"])
def place(request, renderer_of):
    scene = library.load(request.param)
    renderer = renderer_of(scene, Fisheye(160, 120, 150.0), Mount(), quality=CHEAP)
    poses = scene.tour.poses[:: max(1, len(scene.tour.poses) // 4)]
    return scene, [renderer.render(pose) for pose in poses]


def lit(basis, **intensity):
    return relight(basis, dict.fromkeys(basis.layers, 0.0) | intensity, dict.fromkeys(basis.layers, WHITE))


def test_pictures_are_finite_and_show_landmarks(place):
    _, bases = place
    for basis in bases:
        assert np.isfinite(basis.diffuse).all() and np.isfinite(basis.specular).all()
        assert (basis.diffuse >= 0).all() and (basis.specular >= 0).all()
        assert (basis.surface == -1).mean() < 0.2
        assert (basis.visible_share > 0.5).sum() >= 3


def test_lamps_give_the_light_of_the_lumen_method(place):
    """E = n Φ u / A, with the utilisation u between 0.25 and 1.4 in rooms of these colours (CIE 40)."""
    scene, bases = place
    x0, y0, x1, y1 = scene.bounds
    lumen = scene.bulbs[0].lumen
    floors = [k for k, s in enumerate(scene.surfaces) if s.name in (scene.floor, *scene.inlays)]
    lux = []
    for basis in bases:
        diffuse, _ = lit(basis, **{scene.bulbs[0].group: lumen})
        for k in floors:
            on = (basis.surface == k) & (basis.landmark == -1)
            lux.append(np.pi * diffuse[on][:, 1] / scene.surfaces[k].material.base_color[1])
    even = len(scene.bulbs) * lumen / ((x1 - x0) * (y1 - y0))
    assert 0.25 * even < np.median(np.concatenate(lux)) < 1.4 * even


def test_sun_puts_highlights_into_some_picture(place):
    """Glossy floors and objects mirror sun and windows: part of a picture is specular, most of it is not."""
    scene, bases = place
    shares = []
    for basis in bases:
        diffuse, specular = lit(basis, sun=scene.suns[0].lux, sky=scene.sky.lux)
        shares.append((specular[..., 1] > diffuse[..., 1]).mean())
    assert max(shares) > 0.002
    assert np.mean(shares) < 0.5
