"""The BRDF against an independent float64 implementation, and against the laws any BRDF obeys."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from renderers.lobe_albedo import albedo_table, directional_albedo
from renderers.shade import shade_ambient, shade_light

UNIT = st.floats(0.0, 1.0)
ANGLE = st.floats(0.0, 2 * np.pi)
ABOVE = st.floats(0.02, 1.0)


def direction(cosine, angle):
    sine = np.sqrt(1.0 - np.square(cosine))
    return np.stack([sine * np.cos(angle), sine * np.sin(angle), np.broadcast_to(cosine, np.shape(sine))], -1)


def reflected(to_light, to_eye, base_color, roughness, metallic, specular, lux=1.0):
    """What shade_light gives on a surface that faces up, (n, 3) diffuse and specular."""
    n = len(to_light)

    def column(value):
        return np.full(n, value, dtype=np.float32)

    diffuse, shine = np.zeros((n, 3), np.float32), np.zeros((n, 3), np.float32)
    shade_light(
        np.tile(np.float32([0, 0, 1]), (n, 1)),
        np.asarray(to_eye, dtype=np.float32),
        np.asarray(to_light, dtype=np.float32),
        column(lux),
        column(0.0),
        np.tile(np.float32(base_color), (n, 1)),
        column(roughness),
        column(metallic),
        column(specular),
        diffuse,
        shine,
    )
    return diffuse, shine


def appendix_b(to_light, to_eye, base_color, roughness, metallic, specular):
    """glTF 2.0 appendix B with KHR_materials_specular, one direction pair at a time, in float64.

    Shadowing in Heitz's form 1 / (1 + Λ(v) + Λ(l)) with Λ from the tangent of the angle.
    """
    normal = np.array([0.0, 0.0, 1.0])
    half = (to_light + to_eye) / np.linalg.norm(to_light + to_eye)
    alpha = roughness**2

    def smith_lambda(w):
        tan2 = 1 / (w @ normal) ** 2 - 1
        return (-1 + np.sqrt(1 + alpha**2 * tan2)) / 2

    tan2_h = 1 / (half @ normal) ** 2 - 1
    distribution = 1 / (np.pi * alpha**2 * (half @ normal) ** 4 * (1 + tan2_h / alpha**2) ** 2)
    masking = 1 / (1 + smith_lambda(to_light) + smith_lambda(to_eye))
    lobe = distribution * masking / (4 * (to_light @ normal) * (to_eye @ normal))

    def schlick(f0, f90):
        return f0 + (f90 - f0) * (1 - to_eye @ half) ** 5

    base_color = np.asarray(base_color, dtype=float)
    dielectric = schlick(0.04 * specular, specular)
    diffuse = (1 - metallic) * (1 - dielectric) * base_color / np.pi
    shine = ((1 - metallic) * dielectric + metallic * schlick(base_color, 1.0)) * lobe
    cosine = to_light @ normal
    return diffuse * cosine, shine * cosine


@settings(max_examples=200, deadline=None)
@given(ABOVE, ANGLE, ABOVE, ANGLE, st.floats(0.1, 1.0), UNIT, UNIT)
def test_brdf_is_that_of_gltf(light, light_angle, eye, eye_angle, roughness, metallic, specular):
    to_light, to_eye = direction(light, light_angle), direction(eye, eye_angle)
    base_color = (0.9, 0.5, 0.1)
    diffuse, shine = reflected([to_light], [to_eye], base_color, roughness, metallic, specular)
    expected_diffuse, expected_shine = appendix_b(to_light, to_eye, base_color, roughness, metallic, specular)
    np.testing.assert_allclose(diffuse[0], expected_diffuse, rtol=1e-4, atol=1e-7)
    np.testing.assert_allclose(shine[0], expected_shine, rtol=2e-3, atol=1e-6)  # D amplifies float32's N·H


@settings(max_examples=100, deadline=None)
@given(ABOVE, ANGLE, ABOVE, ANGLE, st.floats(0.15, 1.0), UNIT)
def test_brdf_is_reciprocal(one, one_angle, other, other_angle, roughness, metallic):
    a, b = direction(one, one_angle), direction(other, other_angle)
    there = reflected([a], [b], (0.8, 0.5, 0.2), roughness, metallic, 1.0)
    back = reflected([b], [a], (0.8, 0.5, 0.2), roughness, metallic, 1.0)
    for part_there, part_back in zip(there, back, strict=True):
        np.testing.assert_allclose(part_there[0] / one, part_back[0] / other, rtol=2e-3, atol=1e-5)


def hemisphere(count=400):
    """Directions and their solid angles, on a grid even in polar angle and azimuth."""
    polar = (np.arange(count) + 0.5) / count * np.pi / 2
    azimuth = (np.arange(count) + 0.5) / count * 2 * np.pi
    theta, phi = (grid.ravel() for grid in np.meshgrid(polar, azimuth))
    return direction(np.cos(theta), phi), np.sin(theta) * (np.pi / count) ** 2


@pytest.mark.parametrize("roughness", [0.25, 0.4, 0.6, 0.8, 1.0])
@pytest.mark.parametrize("cosine", [0.15, 0.4, 0.7, 1.0])
def test_specular_lobe_in_a_white_furnace(roughness, cosine):
    """It may lose light (it scatters once), never gain it; the table for uniform light agrees."""
    to_light, weight = hemisphere()
    to_eye = np.tile(direction(cosine, 0.0), (len(to_light), 1))
    # a metal's F is base + (1 − base)(1 − V·H)⁵: white gives a + b, black gives b
    _, white = reflected(to_light, to_eye, (1.0, 1.0, 1.0), roughness, 1.0, 1.0)
    _, black = reflected(to_light, to_eye, (0.0, 0.0, 0.0), roughness, 1.0, 1.0)
    bias = black[:, 0] @ weight
    scale = white[:, 0] @ weight - bias
    assert 0.3 < scale + bias <= 1.0
    assert directional_albedo(albedo_table(), cosine, roughness) == pytest.approx((scale, bias), abs=0.01)


def test_white_lambert_in_a_white_furnace_gives_back_all_of_it():
    to_light, weight = hemisphere()
    to_eye = np.tile(direction(0.3, 0.0), (len(to_light), 1))
    diffuse, shine = reflected(to_light, to_eye, (1.0, 1.0, 1.0), 0.5, 0.0, 0.0)
    assert diffuse[:, 0] @ weight == pytest.approx(1.0, abs=1e-4)
    assert not shine.any()


@pytest.mark.parametrize(("cosine", "gain"), [(1.0, 1.0), (0.5, 1.05), (0.2, 1.25)])
@pytest.mark.parametrize("roughness", [0.25, 0.5, 1.0])
def test_white_dielectric_in_a_white_furnace(cosine, gain, roughness):
    """It gains light towards grazing, up to 24 % here, as glTF dims the diffuse part by 1 − F(V·H).

    That is the standard's mix: of each light, what its own half vector reflects, not all that the lobe does.
    """
    to_light, weight = hemisphere()
    to_eye = np.tile(direction(cosine, 0.0), (len(to_light), 1))
    diffuse, shine = reflected(to_light, to_eye, (1.0, 1.0, 1.0), roughness, 0.0, 1.0)
    total = (diffuse + shine)[:, 0] @ weight
    assert 0.9 < total < gain


def test_rough_metal_at_normal_incidence_reflects_one_minus_log_two():
    """At α = 1 the lobe is 1/π · 1/2 / (N·L + 1); its integral with N·L is 1 − ln 2."""
    assert sum(directional_albedo(albedo_table(), 1.0, 1.0)) == pytest.approx(1 - np.log(2), abs=0.002)


def test_light_from_behind_or_below_gives_nothing():
    below, up = direction(-0.5, 0.0), direction(1.0, 0.0)
    for to_light, to_eye in ((below, up), (up, below)):
        diffuse, shine = reflected([to_light], [to_eye], (1, 1, 1), 0.5, 0.5, 1.0)
        assert not diffuse.any() and not shine.any()


def test_no_specular_layer_leaves_lambert():
    to_light = direction(np.array([0.2, 0.6, 1.0]), np.zeros(3))
    to_eye = np.tile(direction(0.7, 1.0), (3, 1))
    diffuse, shine = reflected(to_light, to_eye, (0.6, 0.3, 0.1), 0.3, 0.0, 0.0, lux=1000.0)
    np.testing.assert_allclose(diffuse, np.outer([200.0, 600.0, 1000.0], [0.6, 0.3, 0.1]) / np.pi, rtol=1e-6)
    assert not shine.any()


def test_ambient_light_is_split_by_the_lobes_albedo():
    one = np.ones(1, dtype=np.float32)
    up, colour = np.float32([[0, 0, 1]]), np.float32([[0.5, 0.5, 0.5]])
    lux = np.float32([[np.pi, np.pi, np.pi, 1, 2, 3]])  # of two layers
    mirrored = np.float32([[2, 2, 2, 6, 5, 4]])
    diffuse, shine = np.full((2, 2, 1, 3), 9, np.float32)
    material = colour, 0.3 * one, 0 * one, one
    shade_ambient(up, up, lux, mirrored, one > 0, albedo_table(), *material, diffuse, shine)
    scale, bias = directional_albedo(albedo_table(), 1.0, 0.3)
    layer = 0.04 * scale + bias
    expected = 0.5 * (1 - layer) * np.array([[1, 1, 1], [1 / np.pi, 2 / np.pi, 3 / np.pi]])
    np.testing.assert_allclose(diffuse[:, 0], expected, rtol=1e-5)
    np.testing.assert_allclose(shine[:, 0], layer * np.array([[2, 2, 2], [6, 5, 4]]), rtol=1e-5)
