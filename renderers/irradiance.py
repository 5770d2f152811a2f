"""Light that bounces: indirect and sky illuminance, baked once per scene at (some of) the mesh's vertices.

The gather is linear in each light's intensity, so it is baked per layer of the light basis at unit
intensity. From each vertex, cosine-distributed rays (so that their mean is the integral E = ∫ L cos θ dω)
find the sky or a surface point. There the direct light is evaluated exactly, with shadow rays; the light of
later bounces is interpolated from the vertices, and the fixed point is iterated.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from renderers.bake_points import MOST_POINTS, BakePoints, bake_points
from renderers.gather import Gather, direct_lux
from renderers.gbuffer import F32
from renderers.lights import OFFSET_M, UnitLight
from renderers.mesh import RayCaster, SceneMesh
from renderers.shadows import POINTS


@dataclass(frozen=True)
class BakeQuality:
    """How much work goes into baked light.

    Attributes
    ----------
    sky_rays, bounce_rays : int
        From each vertex. The sky is seen through windows, so it needs more.
    bounces : int
        Beyond the first; what is left out is reflectance to the power of ``bounces + 1``. −1 leaves out all
        bounced light, mirror images too.
    """

    sky_rays: int = 4096
    bounce_rays: int = 512
    bounces: int = 8


WARM_UP, SAMPLE = 4, 256
"""Points that are timed to tell how long all will take."""

FULL_QUALITY = BakeQuality()
DIRECT_ONLY = BakeQuality(bounces=-1)


@dataclass(frozen=True, eq=False)
class Irradiance:
    """Illuminance at the mesh's vertices at unit intensity of each layer.

    Attributes
    ----------
    indirect : (layers, n, 3) float32
        Bounced light, and the sky's own light, lux per channel; what the direct shading leaves out.
    total : (layers, n, 3) float32
        ``indirect`` plus the direct light of sun and bulbs at the vertices.
    """

    indirect: F32
    total: F32


def bake(
    mesh: SceneMesh,
    caster: RayCaster,
    layers: list[list[UnitLight]],
    quality: BakeQuality = FULL_QUALITY,
) -> Irradiance:
    """Bake the illuminance of each layer, a layer being the lights that share an intensity."""
    points, normals = _vertex_frames(mesh)
    at = bake_points(points, normals)
    direct = np.stack([direct_lux(points, normals, layer, caster, POINTS) for layer in layers])
    lifted = points[at.chosen] + np.float32(OFFSET_M) * normals[at.chosen]
    gather = Gather(
        mesh, caster, lifted, normals[at.chosen], at.spread, quality.sky_rays, quality.bounce_rays
    )
    once = np.stack([gather.sky(layer) for layer in layers])
    if quality.bounces < 0:
        indirect = _spread(at, once)
        return Irradiance(indirect, np.zeros_like(indirect))
    once += np.stack([gather.first_bounce(layer) for layer in layers])
    indirect = once.copy()
    for _ in range(quality.bounces):
        indirect = once + np.stack([gather.bounce(layer) for layer in indirect])
    indirect = _spread(at, indirect)
    return Irradiance(indirect, (indirect + direct[..., None]).astype(np.float32))


def expected_seconds(
    mesh: SceneMesh, caster: RayCaster, layers: list[list[UnitLight]], quality: BakeQuality = FULL_QUALITY
) -> float:
    """How long `bake` will take here: a few of its points, timed."""
    points, normals = _vertex_frames(mesh)
    spread = sparse.identity(len(points), dtype=np.float32, format="csr")
    seconds = 0.0
    for count in (WARM_UP, SAMPLE):  # at first kernels are compiled and Embree sorts the triangles
        some = np.linspace(0, len(points) - 1, count).astype(np.int64)
        lifted = points[some] + np.float32(OFFSET_M) * normals[some]
        start = time.perf_counter()
        gather = Gather(mesh, caster, lifted, normals[some], spread, quality.sky_rays, quality.bounce_rays)
        for layer in layers:
            gather.sky(layer)
            gather.first_bounce(layer)
        seconds = time.perf_counter() - start
    return seconds * min(len(points), MOST_POINTS) / SAMPLE


def _spread(at: BakePoints, layers: F32) -> F32:
    """(layers, n, 3) float32 at all vertices from values at the chosen ones."""
    return np.stack([at.spread @ layer for layer in layers]).astype(np.float32)


def _vertex_frames(mesh: SceneMesh) -> tuple[F32, F32]:
    """Points beside each vertex, inside its triangles, and the mean normal there."""
    corners = mesh.triangles.ravel()
    count = np.maximum(np.bincount(corners, minlength=len(mesh.vertices)), 1)[:, None]

    def mean(per_triangle: F32) -> NDArray[np.float64]:
        total = np.zeros((len(mesh.vertices), 3))
        np.add.at(total, corners, np.repeat(per_triangle, 3, axis=0))
        return total / count

    normal = mean(mesh.normals)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    centroid = mean(mesh.vertices[mesh.triangles].mean(axis=1))
    points = mesh.vertices + 0.05 * (centroid - mesh.vertices)
    return points.astype(np.float32), normal.astype(np.float32)
