"""Curved surfaces: normals between the vertices', and mirror images of one pixel's own rays."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.camera import Mount, Pinhole
from renderers.irradiance import BakeQuality
from scenes.geometry import surface
from scenes.model import Material
from scenes.shapes import curved_surface, cylinder, place, sphere

RADIUS_M = 0.5
CENTRE = np.array([0.0, 0.0, 1.0 + RADIUS_M])
BALL = place(sphere(RADIUS_M), (0.0, 0.0, 1.0))
SIDEWAYS = np.array([[0, 0, 1, -3.0], [-1, 0, 0, 0], [0, -1, 0, CENTRE[2]], [0, 0, 0, 1.0]])
"""A camera 3 m west of the ball's centre that looks at it."""

MATT = Material((0.5, 0.5, 0.5), roughness=1.0, specular=0.0)
GLOSSY_METAL = Material((0.9, 0.9, 0.9), roughness=0.3, metallic=1.0)


def degrees_off(gbuffer, on):
    radial = gbuffer.position[on] - CENTRE
    radial /= np.linalg.norm(radial, axis=1, keepdims=True)
    return np.degrees(np.arccos(np.clip((gbuffer.normal[on] * radial).sum(axis=1), -1, 1)))


def test_normals_of_a_ball_are_radial(scene_of, floor, gbuffer_of):
    """Facets of 28 sectors are up to 6° and more off; between the vertices the error is second order."""
    off = {}
    for make in (surface, curved_surface):
        scene = scene_of(floor(), make("ball", MATT, BALL))
        gbuffer = gbuffer_of(scene, Pinhole(160, 120, 40.0), SIDEWAYS)
        on = gbuffer.surface == 1
        assert on.sum() > 1500
        off[make] = degrees_off(gbuffer, on)
        facing = np.einsum("nk,nk->n", gbuffer.normal[on], gbuffer.view.directions[on])
        assert facing.max() < 1e-5
        np.testing.assert_allclose(np.linalg.norm(gbuffer.normal[on], axis=1), 1.0, atol=1e-5)
    assert np.percentile(off[surface], 90) > 4.0
    assert np.percentile(off[curved_surface], 90) < 0.5


def test_flat_surfaces_keep_their_normals(scene_of, floor, gbuffer_of):
    can = place(cylinder(0.4, 1.0), (0.0, 0.0, 1.0))
    scene = scene_of(floor(), curved_surface("can", MATT, can))
    gbuffer = gbuffer_of(scene, Pinhole(160, 120, 80.0), SIDEWAYS)
    np.testing.assert_array_equal(gbuffer.normal[gbuffer.surface == 0][:, :2], 0.0)
    side = gbuffer.normal[gbuffer.surface == 1]
    np.testing.assert_allclose(side[:, 2], 0.0, atol=1e-5)


def seen_from_above(renderer_of, scene):
    renderer = renderer_of(
        scene, Pinhole(121, 121, 25.0), Mount(height_m=4.0, pitch_deg=90.0), quality=BakeQuality(16, 4, 0)
    )
    return renderer.render(np.zeros(3))


def test_rough_ball_mirrors_its_surroundings_evenly(renderer_of, scene_of, floor):
    """Under an even sky what a metal ball mirrors depends on the angle to its top alone.

    A pixel that cast one ray of 16 would show their scatter about the horizon, where the sky ends.
    """
    ball = curved_surface("ball", GLOSSY_METAL, BALL)
    basis = seen_from_above(renderer_of, scene_of(floor(0.1), ball))
    sky = basis.specular[basis.layers.index("sky"), ..., 1]
    v, u = np.indices(sky.shape) - 60
    distance, turn = np.hypot(u, v), np.arctan2(v, u)
    inside = basis.surface == 1
    rim = distance[inside].max()
    for share in (0.2, 0.5, 0.6, 0.72):
        ring = inside & (np.abs(distance - share * rim) < 0.7)
        fit = np.polynomial.Polynomial.fit(distance[ring], sky[ring], 1)
        scatter = np.std(sky[ring] - fit(distance[ring])) / sky[ring].mean()
        assert len(np.unique(np.round(turn[ring], 2))) > 20
        assert scatter < 0.04, share


def test_top_of_the_ball_mirrors_the_whole_sky(renderer_of, scene_of, floor):
    """Looking straight down on it, all of its lobe goes up: the sky's luminance times the metal's albedo."""
    from renderers.lobe_albedo import albedo_table, directional_albedo

    ball = curved_surface("ball", GLOSSY_METAL, BALL)
    basis = seen_from_above(renderer_of, scene_of(floor(0.1), ball))
    sky = basis.specular[basis.layers.index("sky"), 58:63, 58:63, 1].mean()
    scale, bias = directional_albedo(albedo_table(), 1.0, 0.3)
    assert sky == pytest.approx((0.9 * scale + bias) / np.pi, rel=0.01)
