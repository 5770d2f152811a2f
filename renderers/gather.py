"""Where the rays from baked points end, and what light they bring: one step of `renderers.irradiance`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from renderers.appearance import materials_at
from renderers.gbuffer import F32
from renderers.lights import HORIZON_Z, DirectLight, SkyLight, UnitLight, bounding_balls
from renderers.lobe_albedo import mean_albedo
from renderers.mesh import NOTHING, MaterialTable, RayCaster, SceneMesh
from renderers.shade import DIELECTRIC_F0
from renderers.shadows import lit_share
from renderers.threads import BLOCK

BOUNCE_FOOTPRINT_M = 0.1
"""What a bounced ray sees of a texture: 512 rays over a hemisphere are 0.1 m apart at a metre's distance."""

CAST_AT_ONCE = 4096
"""Points whose bounce rays are cast together; bounds the memory."""


def direct_lux(points: F32, normals: F32, layer: list[UnitLight], caster: RayCaster, rays: int) -> F32:
    """(n,) lux of the layer's sun and bulbs on surface points, by some shadow rays to each light."""
    total, balls = np.zeros(len(points), dtype=np.float32), bounding_balls(points, BLOCK)
    for light in layer:
        if isinstance(light, DirectLight):
            reached = np.flatnonzero(np.repeat(~light.misses(*balls), BLOCK)[: len(points)])
            everywhere = len(reached) == len(points)
            to_light, lux, _ = light.arriving(*(a if everywhere else a[reached] for a in (points, normals)))
            some = np.flatnonzero(lux)
            lit = reached[some]
            cosine = np.einsum("nk,nk->n", normals[lit], to_light[some]).clip(min=0.0)
            total[lit] += lux[some] * cosine * lit_share(light, points, normals, lit, caster, rays)
    return total


def diffuse_albedo(materials: MaterialTable) -> F32:
    """(n, 3) float32: what each material reflects of uniform light, gloss and all.

    Bounced light takes it as scattered evenly; only the path's last bounce, towards the camera, has a lobe.
    """
    scale, bias = (factor[:, None] for factor in mean_albedo(materials.roughness))
    metallic, base = materials.metallic[:, None], materials.base_color
    layer = materials.specular[:, None] * (DIELECTRIC_F0 * scale + bias)
    dielectric = base * (1 - layer) + layer
    return np.asarray(dielectric + metallic * (base * scale + bias - dielectric), dtype=np.float32)


@dataclass(frozen=True, eq=False)
class Hits:
    """Where the bounce rays of all vertices end.

    Attributes
    ----------
    points, normals, albedo : (m, 3) float32
        Of the surfaces hit.
    interpolation : (m, n) sparse
        Values at the hits from values at the points that are baked.
    mean : (n, m) sparse
        Mean over each point's rays from values at the hits; a ray without a hit counts as dark.
    """

    points: F32
    normals: F32
    albedo: F32
    interpolation: sparse.csr_matrix
    mean: sparse.csr_matrix


class Gather:
    """Where the rays from each baked point end, and what light they bring.

    ``spread`` (vertices, points) gives values at the mesh's vertices from values at the points.
    """

    def __init__(
        self,
        mesh: SceneMesh,
        caster: RayCaster,
        points: F32,
        normals: F32,
        spread: sparse.csr_matrix,
        sky_rays: int,
        bounce_rays: int,
    ) -> None:
        self._caster, self._points, self._spread = caster, points, spread
        self._sky_rays = _cosine_directions(sky_rays)
        self._frames = _tangent_frames(normals)
        self._hit = self._cast(mesh, _cosine_directions(bounce_rays))

    def sky(self, layer: list[UnitLight]) -> F32:
        """(n, 3) lux from the sky: the share of rays that leave the scene upwards times π L."""
        unit = sum(light.luminance for light in layer if isinstance(light, SkyLight))
        share = np.zeros(len(self._points), dtype=np.float32)
        if unit == 0:
            return np.repeat(share[:, None], 3, axis=1)
        for part in np.array_split(np.arange(len(self._points)), max(1, len(self._points) // 512)):
            rays = _turned(self._sky_rays, self._frames[part])
            vertex, ray = np.nonzero(rays[..., 2] > HORIZON_Z)
            free = ~self._caster.occluded(self._points[part[vertex]], rays[vertex, ray])
            share[part] = np.bincount(vertex, weights=free, minlength=len(part)) / rays.shape[1]
        return np.repeat((np.pi * unit * share)[:, None], 3, axis=1).astype(np.float32)

    def first_bounce(self, layer: list[UnitLight]) -> F32:
        """(n, 3) lux by way of surfaces that the layer's sun and bulbs light directly."""
        hit = self._hit
        arriving = direct_lux(hit.points, hit.normals, layer, self._caster, 1)
        return np.asarray(hit.mean @ (hit.albedo * arriving[:, None]), dtype=np.float32)

    def bounce(self, indirect: F32) -> F32:
        """(n, 3) lux by way of surfaces that carry the given indirect light."""
        hit = self._hit
        return np.asarray(hit.mean @ (hit.albedo * (hit.interpolation @ indirect)), dtype=np.float32)

    def _cast(self, mesh: SceneMesh, rays: F32) -> Hits:
        parts = np.array_split(np.arange(len(self._points)), max(1, len(self._points) // CAST_AT_ONCE))
        found = [self._cast_part(mesh, rays, part) for part in parts]
        counts = np.concatenate([count for *_, count in found])  # of hits, by point
        columns = list(zip(*found, strict=True))
        triangle, weights, points, normals = (np.concatenate(column) for column in columns[:4])
        total, n = len(triangle), len(self._points)
        at_vertices = sparse.csr_matrix(
            (weights.ravel(), mesh.triangles[triangle].ravel(), np.arange(0, 3 * total + 1, 3)),
            shape=(total, len(mesh.vertices)),
            dtype=np.float32,
        )
        first = np.concatenate([[0], np.cumsum(counts)])
        share = np.full(total, 1 / len(rays), dtype=np.float32)
        return Hits(
            points=points,
            normals=normals,
            albedo=diffuse_albedo(materials_at(mesh, triangle, weights, BOUNCE_FOOTPRINT_M)),
            interpolation=at_vertices if n == len(mesh.vertices) else at_vertices @ self._spread,
            mean=sparse.csr_matrix((share, np.arange(total), first), shape=(n, total)),
        )

    def _cast_part(self, mesh: SceneMesh, rays: F32, part: NDArray[np.int64]) -> tuple[NDArray, ...]:
        """Triangle, weights, point and normal of the rays that hit a front, and how many do of each point."""
        directions = _turned(rays, self._frames[part])
        triangle, distance, bary = self._caster.nearest(self._points[part, None, :], directions)
        facing = np.einsum("nki,nki->nk", mesh.normals[triangle], directions) < 0
        vertex, ray = np.nonzero((triangle != NOTHING) & facing)
        triangle, bary = triangle[vertex, ray], bary[vertex, ray]
        points = self._points[part[vertex]] + distance[vertex, ray, None] * directions[vertex, ray]
        weights = np.column_stack([1 - bary.sum(axis=1), bary]).astype(np.float32)
        return triangle, weights, points, mesh.normals[triangle], np.bincount(vertex, minlength=len(part))


def _turned(rays: F32, frames: F32) -> F32:
    """(n, k, 3): each of k rays in each of n frames."""
    return np.asarray(np.matmul(rays, frames.transpose(0, 2, 1)), dtype=np.float32)


def _cosine_directions(count: int) -> F32:
    """(count, 3) float32: cosine-distributed directions about +z from the R2 sequence (Roberts 2018)."""
    g = 1.32471795724474602596
    u, v = np.mod(0.5 + np.outer([1 / g, 1 / g**2], np.arange(count)), 1.0)
    r, phi = np.sqrt(u), 2 * np.pi * v
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1 - u)], axis=-1).astype(np.float32)


def _tangent_frames(normals: F32) -> F32:
    """(n, 3, 3) float32: rotations whose third column is the normal."""
    helper = np.where(np.abs(normals[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    tangent = np.cross(helper, normals)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
    return np.stack([tangent, np.cross(normals, tangent), normals], axis=-1).astype(np.float32)
