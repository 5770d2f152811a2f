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

from renderers.appearance import materials_at
from renderers.bake_points import MOST_POINTS, BakePoints, bake_points
from renderers.gbuffer import F32
from renderers.lights import HORIZON_Z, OFFSET_M, DirectLight, SkyLight, UnitLight, bounding_balls
from renderers.lobe_albedo import mean_albedo
from renderers.mesh import NOTHING, MaterialTable, RayCaster, SceneMesh
from renderers.shade import DIELECTRIC_F0
from renderers.shadows import POINTS, lit_share
from renderers.threads import BLOCK


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


BOUNCE_FOOTPRINT_M = 0.1
"""What a bounced ray sees of a texture: 512 rays over a hemisphere are 0.1 m apart at a metre's distance."""

WARM_UP, SAMPLE = 4, 256
"""Points that are timed to tell how long all will take."""

CAST_AT_ONCE = 4096
"""Points whose bounce rays are cast together; bounds the memory."""

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
    direct = np.stack([_direct(points, normals, layer, caster, POINTS) for layer in layers])
    lifted = points[at.chosen] + np.float32(OFFSET_M) * normals[at.chosen]
    gather = _Gather(mesh, caster, lifted, normals[at.chosen], at.spread, quality)
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
        gather = _Gather(mesh, caster, lifted, normals[some], spread, quality)
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


def _direct(points: F32, normals: F32, layer: list[UnitLight], caster: RayCaster, rays: int) -> F32:
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
            total[lit] += lux[some] * cosine * lit_share(light, points[lit], normals[lit], caster, rays)
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
class _Hits:
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


class _Gather:
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
        quality: BakeQuality,
    ) -> None:
        self._caster, self._points, self._spread = caster, points, spread
        self._sky_rays = _cosine_directions(quality.sky_rays)
        self._frames = _tangent_frames(normals)
        self._hit = self._cast(mesh, _cosine_directions(quality.bounce_rays))

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
        arriving = _direct(hit.points, hit.normals, layer, self._caster, 1)
        return np.asarray(hit.mean @ (hit.albedo * arriving[:, None]), dtype=np.float32)

    def bounce(self, indirect: F32) -> F32:
        """(n, 3) lux by way of surfaces that carry the given indirect light."""
        hit = self._hit
        return np.asarray(hit.mean @ (hit.albedo * (hit.interpolation @ indirect)), dtype=np.float32)

    def _cast(self, mesh: SceneMesh, rays: F32) -> _Hits:
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
        return _Hits(
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
