"""Splitting keeps the shape, and leaves no gaps."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
from hypothesis import given, settings

from scenes.model import Material, Surface
from scenes.solid import encloses
from scenes.tessellate import tessellate

GREY = Material((0.5, 0.5, 0.5), 1.0)
CORNERS = np.array([[0, 0, 0], [3, 0, 0], [0, 2, 0], [0, 0, 1]], dtype=float)
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def volume(surface):
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    return np.einsum("mk,mk->", a, np.cross(b, c)) / 6


@settings(max_examples=20)
@given(st.floats(0.15, 2.0), st.floats(0.0, 0.5), st.integers(0, 10_000))
def test_a_solid_stays_closed_and_as_large_and_no_edge_is_too_long(edge, growth, seed):
    """Also where the length allowed differs from place to place."""
    moved = CORNERS + np.random.default_rng(seed).uniform(-0.3, 0.3, (4, 3))
    solid = Surface("solid", moved, FACES, GREY)

    def limit(middle):
        return edge + growth * np.abs(middle[:, 0])

    fine = tessellate(solid, limit, 200_000)
    assert encloses(fine.vertices, fine.triangles)
    np.testing.assert_allclose(volume(fine), volume(solid), rtol=1e-9)
    ends = fine.vertices[np.stack([fine.triangles, np.roll(fine.triangles, -1, axis=1)], axis=-1)]
    length = np.linalg.norm(ends[..., 0, :] - ends[..., 1, :], axis=-1)
    assert (length <= limit(ends.mean(axis=-2).reshape(-1, 3)).reshape(length.shape) + 1e-12).all()


def test_texture_coordinates_and_normals_lie_between_those_of_the_corners():
    up, uv = np.tile([0.0, 0.0, 1.0], (3, 1)), np.array([[0, 0], [1, 0], [0, 1]], dtype=float)
    flat = Surface("flat", CORNERS[:3], np.array([[0, 1, 2]]), GREY, up, uv)
    fine = tessellate(flat, lambda middle: np.full(len(middle), 0.4), 10_000)
    np.testing.assert_allclose(fine.uv, fine.vertices[:, :2] / (3, 2), atol=1e-12)
    np.testing.assert_allclose(fine.normals, np.tile([0, 0, 1], (len(fine.vertices), 1)), atol=1e-12)


def test_it_gives_up_where_too_many_vertices_would_be_needed():
    solid = Surface("solid", CORNERS, FACES, GREY)
    assert tessellate(solid, lambda middle: np.full(len(middle), 0.05), 500) is None
