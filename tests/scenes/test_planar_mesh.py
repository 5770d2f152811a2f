"""Meshes of floor plans against their area, their outline and shapely-free counting of edges."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes.errors import SceneError
from scenes.planar_mesh import distance_to, inside, triangulate

L_SHAPE = np.array([[0.0, 0], [6, 0], [6, 2], [2, 2], [2, 5], [0, 5]])
COURT = np.array([[0.5, 0.5], [0.5, 1.5], [1.5, 1.5], [1.5, 0.5]])  # clockwise


def area(vertices, triangles):
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    u, v = b - a, c - a
    return 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def edge_counts(triangles):
    edges = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1
    )
    return np.unique(edges, axis=0, return_counts=True)


def test_an_l_with_a_court_is_filled_once_and_wholly():
    vertices, triangles = triangulate([L_SHAPE, COURT], 0.4)
    areas = area(vertices, triangles)
    assert (areas > 0).all()  # counter-clockwise, none degenerate
    assert areas.sum() == pytest.approx(12 + 6 - 1, rel=1e-12)
    edges, counts = edge_counts(triangles)
    rim = vertices[edges[counts == 1]]
    assert counts.max() == 2
    length = np.linalg.norm(rim[:, 1] - rim[:, 0], axis=1)
    assert length.sum() == pytest.approx(
        6 + 2 + 4 + 3 + 2 + 5 + 4, rel=1e-12
    )  # both outlines and nothing else
    assert length.max() <= 0.4 + 1e-9


@given(st.lists(st.floats(0.6, 3.0), min_size=5, max_size=14), st.floats(0.2, 0.8))
@settings(max_examples=25, deadline=None)
def test_any_star_is_filled(radii, spacing):
    angle = 2 * np.pi * np.arange(len(radii)) / len(radii)
    ring = np.array(radii)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    x, y = ring.T
    shoelace = 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    vertices, triangles = triangulate([ring], spacing)
    assert area(vertices, triangles).sum() == pytest.approx(shoelace, rel=1e-9)


def test_outlines_that_cross_are_refused():
    with pytest.raises(SceneError, match="cross or touch"):
        triangulate([L_SHAPE, L_SHAPE + np.array([5.5, 1.0])], 0.5)


def test_inside_and_distance_of_a_square():
    square = np.array([[0.0, 0], [2, 0], [2, 2], [0, 2]])
    stops = np.roll(square, -1, axis=0)
    points = np.array([[1.0, 1], [0.1, 1], [3, 1], [1, -0.5], [3, 3]])
    assert inside(square, stops, points).tolist() == [True, True, False, False, False]
    assert distance_to(square, stops, points) == pytest.approx([1, 0.1, 1, 0.5, np.sqrt(2)])
