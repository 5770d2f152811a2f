"""Dense meshes are baked at some of their vertices, and look as if they were baked at all."""

from __future__ import annotations

import numpy as np

from renderers.bake_points import bake_points


def sphere(n):
    rng = np.random.default_rng(4)
    normal = rng.standard_normal((n, 3))
    normal = (normal / np.linalg.norm(normal, axis=1, keepdims=True)).astype(np.float32)
    return 2 * normal, normal


def test_few_vertices_are_all_baked():
    points, normals = sphere(300)
    at = bake_points(points, normals, most=300)
    assert (at.spread != np.eye(300)).nnz == 0 if hasattr(at.spread != np.eye(300), "nnz") else True
    np.testing.assert_array_equal(at.chosen, np.arange(300))


def test_values_that_vary_slowly_are_kept():
    points, normals = sphere(20_000)
    at = bake_points(points, normals, most=1000)
    assert 300 < len(at.chosen) <= 1000
    light = 2 + normals @ np.array([0.3, -0.5, 0.8])
    np.testing.assert_allclose(at.spread.sum(axis=1), 1, rtol=1e-5)
    error = at.spread @ light[at.chosen] - light
    assert np.sqrt((error**2).mean()) < 0.05 and np.abs(error).max() < 0.3


def test_two_sides_of_a_sheet_do_not_share_their_light():
    rng = np.random.default_rng(1)
    flat = np.column_stack([rng.uniform(0, 2, (4000, 2)), np.zeros(4000)]).astype(np.float32)
    points = np.concatenate([flat, flat - np.float32([0, 0, 0.002])])
    normals = np.repeat(np.float32([[0, 0, 1], [0, 0, -1]]), 4000, axis=0)
    at = bake_points(points, normals, most=400)
    above = (at.spread @ (normals[at.chosen, 2] > 0)).astype(float)
    np.testing.assert_allclose(above, normals[:, 2] > 0, atol=0.01)
