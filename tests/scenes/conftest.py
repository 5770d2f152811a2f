"""The library's scenes, built once, and rays through them."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from scenes import library

PLACES = ("atrium", "corridor", "office", "regular", "tabletop", "warehouse")


@pytest.fixture(scope="session")
def built():
    """A scene by name and builder's seed."""
    return cache(lambda name, seed=0: library.load(name, seed=seed))


@pytest.fixture(scope="session")
def first_hit(built):
    """A function of (n, 3) origins and directions: distance, surface name and whether the front was hit."""
    import open3d as o3d

    @cache
    def caster(name, seed=0):
        scene = built(name, seed)
        tree = o3d.t.geometry.RaycastingScene(nthreads=1)
        for surface in scene.surfaces:
            tree.add_triangles(
                o3d.core.Tensor(surface.vertices.astype(np.float32)),
                o3d.core.Tensor(surface.triangles.astype(np.uint32)),
            )
        names = np.array([*(s.name for s in scene.surfaces), "sky"])

        def cast(origins, directions):
            shape = np.broadcast_shapes(np.shape(origins), np.shape(directions))
            rays = np.concatenate(np.broadcast_arrays(origins, directions), axis=-1).reshape(*shape[:-1], 6)
            hit = tree.cast_rays(o3d.core.Tensor(rays.astype(np.float32)))
            surface = hit["geometry_ids"].numpy().astype(np.int64)
            surface[surface == tree.INVALID_ID] = len(names) - 1
            facing = (hit["primitive_normals"].numpy() * rays[..., 3:]).sum(axis=-1) < 0
            return hit["t_hit"].numpy(), names[surface], facing

        return cast

    return caster


@pytest.fixture(params=PLACES)
def place_name(request):
    """Each scene of the library in turn."""
    return request.param
