"""Curved shapes against what geometry says of them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenes.errors import SceneError
from scenes.model import Material, Surface
from scenes.shapes import SECTORS, cone, curved_surface, cylinder, lathe, place, sphere

GREY = Material((0.5, 0.5, 0.5), 1.0)


def volume(piece):
    """By the divergence theorem; a shape that is open below counts as closed at z = 0."""
    corner = piece[0][piece[1]]
    return np.einsum("nk,nk->", np.cross(corner[:, 0], corner[:, 1]), corner[:, 2]) / 6


def degrees_between(a, b):
    return np.degrees(np.arccos(np.clip((a * b).sum(axis=-1), -1, 1)))


@given(st.floats(0.05, 2.0), st.floats(0.05, 3.0))
def test_volumes(radius, height):
    """A prism on n corners has sin(2π/n) / (2π/n) of its cylinder; a sphere is cut both ways."""
    share = np.sin(2 * np.pi / SECTORS) / (2 * np.pi / SECTORS)
    assert volume(cylinder(radius, height)) == pytest.approx(share * np.pi * radius**2 * height)
    assert volume(cone(radius, height)) == pytest.approx(share * np.pi * radius**2 * height / 3)
    assert volume(sphere(radius)) == pytest.approx(4 / 3 * np.pi * radius**3, rel=0.025)


def test_sphere_has_radial_normals():
    ball = curved_surface("ball", GREY, sphere(0.3))
    radial = (ball.vertices - [0, 0, 0.3]) / 0.3
    np.testing.assert_allclose(np.linalg.norm(radial, axis=1), 1.0, atol=1e-9)
    assert degrees_between(ball.normals, radial).max() < 0.5


def test_cylinder_has_a_crease():
    """Its side's normals are level, its top's straight up, along the same edge."""
    can = curved_surface("can", GREY, cylinder(0.2, 0.5))
    rim = can.vertices[:, 2] == 0.5
    side = rim & (np.abs(can.normals[:, 2]) < 0.5)
    np.testing.assert_allclose(can.normals[side, :2] * 0.2, can.vertices[side, :2], atol=1e-9)
    assert (rim & ~side).sum() == SECTORS + 1
    np.testing.assert_allclose(can.normals[rim & ~side][:, 2], 1.0)


def test_rings_of_a_tall_cylinder():
    vertices, _ = cylinder(0.2, 3.0, max_edge_m=1.0)
    np.testing.assert_allclose(np.unique(vertices[:, 2]), [0, 1, 2, 3])


def test_lathe_around_a_pole():
    """A hemisphere's outside is on the right of its climbing profile."""
    theta = np.linspace(np.pi / 2, 0, 9)
    vertices, triangles = lathe([(max(float(np.sin(t)), 0.0) if t else 0.0, float(np.cos(t))) for t in theta])
    corner = vertices[triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    assert (np.einsum("nk,nk->n", normal, corner.mean(axis=1)) > 0).all()
    assert (vertices[:, 2] > 1 - 1e-12).sum() == 1


@given(st.floats(-180, 180), st.floats(-90, 90))
def test_placing_keeps_the_shape(yaw, tilt):
    vertices, triangles = cone(0.3, 0.7, sectors=8)
    moved, same = place((vertices, triangles), (1.0, -2.0, 3.0), yaw, tilt)
    np.testing.assert_array_equal(triangles, same)
    before, after = (np.linalg.norm(v[:, None] - v, axis=-1) for v in (vertices, moved))
    np.testing.assert_allclose(after, before, atol=1e-9)
    assert volume((moved - [1.0, -2.0, 3.0], same)) == pytest.approx(volume((vertices, triangles)))


def test_tilt_before_yaw():
    """The y axis tilted upright and turned by a quarter stays upright; x then points along y."""
    points = np.array([[1.0, 0, 0], [0, 1.0, 0]])
    moved, _ = place((points, np.zeros((0, 3), dtype=np.int64)), (0, 0, 0), yaw_deg=90.0, tilt_deg=90.0)
    np.testing.assert_allclose(moved, [[0, 1, 0], [0, 0, 1]], atol=1e-12)


@pytest.mark.parametrize("bad", [np.zeros((3, 3)), np.ones((2, 3)) / np.sqrt(3)], ids=["length", "count"])
def test_impossible_normals(bad):
    triangle = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    with pytest.raises(SceneError, match="normals"):
        Surface("leaf", triangle, np.array([[0, 1, 2]]), GREY, bad)
