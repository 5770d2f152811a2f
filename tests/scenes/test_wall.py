"""A wall's faces, holes and reveals against their areas, their sides and rays through them."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.mesh import RayCaster
from scenes.geometry import join
from scenes.wall import Opening, Wall

WALL = Wall(np.array([1.0, 2.0]), np.array([4.0, 6.0]), 2.7)  # 5 m long
WINDOWS = [Opening(0.5, 1.5, 0.9, 2.2), Opening(3.0, 4.5, 0.9, 2.2)]


def normals_and_areas(pieces):
    vertices, triangles = join(pieces)
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    cross = np.cross(b - a, c - a)
    twice = np.linalg.norm(cross, axis=1)
    return cross / twice[:, None], 0.5 * twice


def test_inner_and_outer_face_turn_their_backs_on_each_other():
    for behind, sign in ((0.0, 1.0), (0.3, -1.0)):
        pieces = WALL.face(WINDOWS, behind)
        normals, areas = normals_and_areas(pieces)
        assert np.allclose(normals, [*(sign * WALL.inward), 0.0])
        assert areas.sum() == pytest.approx(5 * 2.7 - (1.0 + 1.5) * 1.3)
        offset = (join(pieces)[0][:, :2] - WALL.start) @ WALL.inward
        assert offset == pytest.approx(-behind)


def test_a_crown_goes_on_where_the_face_ends_and_turns_its_back_on_it():
    vertices, triangles = WALL.crown(0.05)
    normals, areas = normals_and_areas([(vertices, triangles)])
    assert np.allclose(normals, [*-WALL.inward, 0.0]) and areas.sum() == pytest.approx(5 * 0.05)
    assert set(np.round(vertices[:, 2], 9)) == {2.7, 2.75}


def test_free_space_is_left_of_the_way():
    assert WALL.length == pytest.approx(5.0)
    assert WALL.inward == pytest.approx([-0.8, 0.6])


@pytest.mark.parametrize("low", [0.9, 0.0])
def test_reveals_face_into_their_hole(low):
    hole = Opening(1.0, 2.0, low, 2.2)
    pieces = WALL.reveals(hole, 0.3)
    assert len(pieces) == (4 if low else 3)  # a gate has no sill
    middle = np.append(WALL.start + 1.5 * WALL.along - 0.15 * WALL.inward, 0.5 * (low + 2.2))
    for piece in pieces:
        normals, areas = normals_and_areas([piece])
        towards = middle - piece[0].mean(axis=0)
        assert (normals @ towards > 0).all()
        assert areas.sum() == pytest.approx(0.3 * (2.2 - low)) or areas.sum() == pytest.approx(0.3 * 1.0)


def test_rays_pass_through_the_windows_alone():
    pieces = [
        *WALL.face(WINDOWS),
        *WALL.face(WINDOWS, 0.3),
        *(p for w in WINDOWS for p in WALL.reveals(w, 0.3)),
    ]
    caster = RayCaster(*join(pieces))
    rng = np.random.default_rng(5)
    along, height = rng.uniform(0.01, 4.99, 4000), rng.uniform(0.01, 2.69, 4000)
    start = WALL.start + along[:, None] * WALL.along + 1.0 * WALL.inward
    origins = np.column_stack([start, height]).astype(np.float32)
    ahead = np.broadcast_to(np.append(-WALL.inward, 0.0), origins.shape).astype(np.float32)
    free = ~caster.occluded(origins, np.ascontiguousarray(ahead), far=3.0)
    expected = [
        any(w.near < a < w.far and w.low < h < w.high for w in WINDOWS)
        for a, h in zip(along, height, strict=True)
    ]
    assert (free == expected).all()


def test_a_leaf_stands_proud_of_its_wall():
    pieces = WALL.leaf(Opening(1.0, 1.86, 0.0, 1.985), 0.03)
    middle = np.append(WALL.start + 1.43 * WALL.along + 0.015 * WALL.inward, 0.9925)
    for piece in pieces:  # each side faces outwards
        assert (normals_and_areas([piece])[0] @ (piece[0].mean(axis=0) - middle) > 0).all()
    vertices, _ = join(pieces)
    offset = (vertices[:, :2] - WALL.start) @ WALL.inward
    along = (vertices[:, :2] - WALL.start) @ WALL.along
    assert offset.min() == pytest.approx(0.0) and offset.max() == pytest.approx(0.03)
    assert (along.min(), along.max(), vertices[:, 2].max()) == pytest.approx((1.0, 1.86, 1.985))
