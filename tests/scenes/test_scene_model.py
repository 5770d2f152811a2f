"""The nouns of a scene, and the meshes they are made of."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenes.errors import SceneError
from scenes.geometry import box, join, rectangle, surface
from scenes.model import Material, Sun

EDGE = st.floats(0.05, 3.0)


@pytest.mark.parametrize(
    "bad",
    [
        {"base_color": (0.5, 0.5, 1.01)},
        {"base_color": (-0.1, 0.5, 0.5)},
        {"base_color": (0.5, 0.5)},
        {"roughness": 1.5},
        {"metallic": -0.5},
        {"specular": 2.0},
        {"roughness": float("nan")},
    ],
    ids=str,
)
def test_impossible_materials(bad):
    with pytest.raises(SceneError, match="must lie in 0…1"):
        Material(**{"base_color": (0.5, 0.5, 0.5), "roughness": 0.5, **bad})


def test_extreme_materials_are_materials():
    Material((0.0, 0.0, 0.0), 0.0, 0.0, 0.0)
    Material((1.0, 1.0, 1.0), 1.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("azimuth", "elevation", "direction"),
    [(0, 0, (0, 1, 0)), (90, 0, (1, 0, 0)), (180, 0, (0, -1, 0)), (270, 0, (-1, 0, 0)), (33, 90, (0, 0, 1))],
)
def test_sun_stands_by_compass_bearing(azimuth, elevation, direction):
    np.testing.assert_allclose(Sun(azimuth, elevation, 1.0).direction, direction, atol=1e-12)


@given(st.floats(-360, 720), st.floats(-90, 90))
def test_suns_direction_is_a_unit_vector_of_its_elevation(azimuth, elevation):
    direction = Sun(azimuth, elevation, 1.0).direction
    assert np.linalg.norm(direction) == pytest.approx(1.0)
    assert np.degrees(np.arcsin(np.clip(direction[2], -1, 1))) == pytest.approx(elevation, abs=1e-5)


def area_vectors(vertices, triangles):
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a) / 2


@given(EDGE, EDGE, st.floats(0.1, 1.0))
def test_rectangle_is_tiled_without_gap_or_overlap(width, height, cell):
    vertices, triangles = rectangle((1, 2, 3), (width, 0, 0), (0, 0.6 * height, 0.8 * height), cell)
    areas = area_vectors(vertices, triangles)
    expected = np.cross([width, 0, 0], [0, 0.6 * height, 0.8 * height])
    np.testing.assert_allclose(areas.sum(axis=0), expected, rtol=1e-9, atol=1e-12)
    assert (areas @ expected > 0).all()  # all face the same way, so equal areas mean no overlap
    assert np.unique(triangles).size == len(vertices)
    edges = vertices[triangles] - vertices[np.roll(triangles, 1, axis=1)]
    assert np.sort(np.linalg.norm(edges, axis=-1), axis=1)[:, :2].max() <= cell + 1e-9


@given(EDGE, EDGE, EDGE)
def test_closed_box_has_its_volume(width, depth, height):
    """Divergence theorem: the flux of x / 3 through the outward surface is the volume."""
    vertices, triangles = box((1, 2, 3), (1 + width, 2 + depth, 3 + height), bottom=True)
    areas, centres = area_vectors(vertices, triangles), vertices[triangles].mean(axis=1)
    assert np.einsum("nk,nk->", areas, centres) / 3 == pytest.approx(width * depth * height)
    np.testing.assert_allclose(areas.sum(axis=0), 0.0, atol=1e-9)


def test_box_stands_open_on_the_floor():
    vertices, triangles = box((0, 0, 0), (1, 1, 1))
    np.testing.assert_allclose(area_vectors(vertices, triangles).sum(axis=0), [0, 0, 1], atol=1e-12)


def test_joined_pieces_keep_their_triangles():
    one, other = (
        rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0), 1.0),
        rectangle((5, 0, 0), (1, 0, 0), (0, 2, 0), 1.0),
    )
    vertices, triangles = join([one, other])
    assert len(vertices) == len(one[0]) + len(other[0])
    np.testing.assert_array_equal(vertices[triangles[len(one[1]) :]], other[0][other[1]])
    named = surface("pair", Material((0.5, 0.5, 0.5), 1.0), one, other)
    assert named.name == "pair"
    np.testing.assert_array_equal(named.triangles, triangles)
