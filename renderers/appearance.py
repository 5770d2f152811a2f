"""What material a point of the scene shows: its surface's, varied by its textures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.gbuffer import F32, I32, I64, GBuffer, View
from renderers.mesh import MaterialTable, SceneMesh
from renderers.texture_store import NO_TEXTURE

GRAZING = 0.02
"""Least cosine between ray and normal that a footprint is worked out for; it grows without end beyond."""


@dataclass(frozen=True, eq=False)
class Columns:
    """What textures vary of n points: base_color (n, 3), roughness, metallic (n,) float32."""

    base_color: F32
    roughness: F32
    metallic: F32


def vary_pixels(
    mesh: SceneMesh, gbuffer: GBuffer, weights: F32, columns: Columns
) -> tuple[F32, NDArray[np.bool_]]:
    """Vary a picture's materials by their textures, averaged over each pixel.

    Parameters
    ----------
    weights : (H·W, 3) float32
        Barycentric, of the triangles' corners.
    columns : Columns
        Of all pixels; changed in place.

    Returns
    -------
    normal : (H·W, 3) float32
        Unit; the G-buffer's, tilted where a texture says so; 0 for the sky.
    tilted : (H·W,) bool
    """
    store, surfaces = mesh.textures, gbuffer.surface.reshape(-1)
    normal, tilted = gbuffer.normal.reshape(-1, 3).copy(), np.zeros(len(surfaces), dtype=bool)
    pixels = np.flatnonzero(store.textured.take(surfaces, mode="clip") & (surfaces >= 0))
    if not len(pixels):
        return normal, tilted
    triangle, surface = gbuffer.triangle.reshape(-1)[pixels], surfaces[pixels]
    footprint = Footprint(
        _uv(mesh, triangle, weights[pixels]), *_pixel_steps(mesh, gbuffer, pixels, triangle)
    )
    _vary(mesh, surface, columns, pixels, footprint)
    which = np.flatnonzero(store.normal[surface] != NO_TEXTURE)
    if len(which):
        tangent = footprint.sample(mesh, store.normal[surface], which) * 2 - 1
        at = pixels[which]
        columns.roughness[at] = _roughened(columns.roughness[at], np.linalg.norm(tangent, axis=1))
        to_eye = -gbuffer.view.directions.reshape(-1, 3)[at]
        corners, scale = mesh.triangles[triangle[which]], store.normal_scale[surface[which]]
        normal[at] = _tilted(mesh.vertices, mesh.uv, corners, normal[at], to_eye, tangent, scale)
        tilted[at] = True
    return normal, tilted


@dataclass(frozen=True, eq=False)
class Footprint:
    """Where n points lie on their textures, and how far they reach: (n, 2) float32 each."""

    uv: F32
    row_step: F32
    column_step: F32

    def sample(self, mesh: SceneMesh, textures: I32, which: I64) -> F32:
        """(m, 3) values of some points' textures; ``textures`` (n,) names each one's."""
        return mesh.textures.sample(
            textures[which], self.uv[which], self.row_step[which], self.column_step[which]
        )


def materials_at(mesh: SceneMesh, triangle: I32, weights: F32, footprint_m: float) -> MaterialTable:
    """Materials of points on triangles, textures averaged over ``footprint_m``.

    Parameters
    ----------
    triangle : (n,) int32
    weights : (n, 3) float32
        Barycentric, of the triangles' corners.
    """
    surface, table = mesh.surface[triangle], mesh.materials
    columns = Columns(table.base_color[surface], table.roughness[surface], table.metallic[surface])
    if not mesh.textures.empty:
        reach = np.float32(footprint_m) * uv_per_metre(mesh)[triangle]
        still = np.zeros_like(reach)
        steps = np.stack([reach, still], axis=-1), np.stack([still, reach], axis=-1)
        _vary(
            mesh, surface, columns, np.arange(len(surface)), Footprint(_uv(mesh, triangle, weights), *steps)
        )
    return MaterialTable(columns.base_color, columns.roughness, columns.metallic, table.specular[surface])


def uv_per_metre(mesh: SceneMesh) -> F32:
    """(m,) float32: how fast texture coordinates run over each triangle, the root of the areas' ratio."""
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    p, q, r = (mesh.uv[mesh.triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    d, e = q - p, r - p
    covered = np.abs(d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0])
    return np.asarray(np.sqrt(covered / np.maximum(area, 1e-20)), dtype=np.float32)


def _vary(mesh: SceneMesh, surface: I32, columns: Columns, at: I64, footprint: Footprint) -> None:
    """Multiply base colour, roughness and metallic by their textures; the points' rows are ``at``."""
    store = mesh.textures
    which = np.flatnonzero(store.base_color[surface] != NO_TEXTURE)
    if len(which):
        columns.base_color[at[which]] *= footprint.sample(mesh, store.base_color[surface], which)
    which = np.flatnonzero(store.metallic_roughness[surface] != NO_TEXTURE)
    if len(which):
        polish = footprint.sample(mesh, store.metallic_roughness[surface], which)
        columns.roughness[at[which]] *= polish[:, 1]
        columns.metallic[at[which]] *= polish[:, 2]


def _roughened(roughness: F32, length: F32) -> F32:
    """Roughness with what a footprint's normals scatter: α² + 2 (1 − |n|) / |n| (Toksvig 2005, for α)."""
    length = np.clip(length, 0.05, 1.0)
    alpha2 = roughness**4 + 2 * (1 - length) / length
    return np.asarray(np.minimum(alpha2, 1.0) ** 0.25, dtype=np.float32)


def _uv(mesh: SceneMesh, triangle: I32, weights: F32) -> F32:
    return np.asarray(np.einsum("nk,nkc->nc", weights, mesh.uv[mesh.triangles[triangle]]), dtype=np.float32)


def _pixel_steps(mesh: SceneMesh, gbuffer: GBuffer, pixels: I64, triangle: I32) -> tuple[F32, F32]:
    """How the texture coordinates change from each pixel to the next row and the next column, (n, 2) each."""
    rays = gbuffer.view.directions
    rows, columns = _ray_steps(gbuffer.view)
    arguments = (
        mesh.vertices,
        mesh.uv,
        mesh.triangles[triangle],
        mesh.normals[triangle],
        gbuffer.distance.reshape(-1)[pixels],
        rays.reshape(-1, 3)[pixels],
    )
    return _steps(*arguments, rows[pixels]), _steps(*arguments, columns[pixels])


def _ray_steps(view: View) -> tuple[F32, F32]:
    """How the rays turn from each pixel to the next row and the next column, (H·W, 3) each."""
    rays = view.directions
    by_row = np.gradient(rays, axis=0) if rays.shape[0] > 1 else np.zeros_like(rays)
    by_column = np.gradient(rays, axis=1) if rays.shape[1] > 1 else np.zeros_like(rays)
    return by_row.reshape(-1, 3).astype(np.float32), by_column.reshape(-1, 3).astype(np.float32)


@njit(cache=True)
def _steps(vertices: F32, uv: F32, corners: I32, normal: F32, distance: F32, rays: F32, turned: F32) -> F32:
    """Ray differentials (Igehy 1999) at the triangles: how (u, v) changes when the ray turns, (n, 2)."""
    steps = np.zeros((len(corners), 2), dtype=np.float32)
    for i in range(len(corners)):
        a, b, c = corners[i]
        towards = turn = 0.0
        for k in range(3):
            towards += normal[i, k] * rays[i, k]
            turn += normal[i, k] * turned[i, k]
        towards = min(towards, -GRAZING) if towards < 0 else max(towards, GRAZING)
        bb = bc = cc = pb = pc = 0.0
        for k in range(3):
            p = distance[i] * (turned[i, k] - rays[i, k] * turn / towards)
            e, f = vertices[b, k] - vertices[a, k], vertices[c, k] - vertices[a, k]
            bb += e * e
            bc += e * f
            cc += f * f
            pb += p * e
            pc += p * f
        scale = 1.0 / max(bb * cc - bc * bc, 1e-30)
        s, t = (cc * pb - bc * pc) * scale, (bb * pc - bc * pb) * scale
        for k in range(2):
            steps[i, k] = s * (uv[b, k] - uv[a, k]) + t * (uv[c, k] - uv[a, k])
    return steps


@njit(cache=True)
def _tilted(vertices: F32, uv: F32, corners: I32, normal: F32, to_eye: F32, tangent: F32, scale: F32) -> F32:
    """Tangent space's normals in the world: x along ∂P/∂u, y against ∂P/∂v (v runs down), z the normal.

    One that would face away from the eye is turned until it is seen edge-on.
    """
    tilted = normal.copy()
    for i in range(len(corners)):
        a, b, c = corners[i]
        d0, d1 = uv[b, 0] - uv[a, 0], uv[b, 1] - uv[a, 1]
        e0, e1 = uv[c, 0] - uv[a, 0], uv[c, 1] - uv[a, 1]
        sign = 1.0 if d0 * e1 - d1 * e0 > 0 else -1.0
        n = normal[i]
        along, up = np.empty(3), np.empty(3)
        for k in range(3):
            p, q = vertices[b, k] - vertices[a, k], vertices[c, k] - vertices[a, k]
            along[k], up[k] = sign * (e1 * p - d1 * q), sign * (e0 * p - d0 * q)
        along_n = up_n = 0.0
        for k in range(3):
            along_n += along[k] * n[k]
            up_n += up[k] * n[k]
        for k in range(3):
            along[k] -= along_n * n[k]
            up[k] -= up_n * n[k]
        long = np.sqrt(along[0] ** 2 + along[1] ** 2 + along[2] ** 2)
        if long < 1e-20:
            continue
        across = 0.0
        for k in range(3):
            along[k] /= long
            across += along[k] * up[k]
        for k in range(3):
            up[k] -= across * along[k]
        high = np.sqrt(up[0] ** 2 + up[1] ** 2 + up[2] ** 2)
        if high < 1e-20:
            continue
        x, y, z = scale[i] * tangent[i, 0], scale[i] * tangent[i, 1] / high, max(tangent[i, 2], 0.0)
        seen = length = 0.0
        m = np.empty(3)
        for k in range(3):
            m[k] = x * along[k] + y * up[k] + z * n[k]
            length += m[k] * m[k]
        length = max(np.sqrt(length), 1e-12)
        for k in range(3):
            m[k] /= length
            seen += m[k] * to_eye[i, k]
        if seen < 0.0:
            length = 0.0
            for k in range(3):
                m[k] -= seen * to_eye[i, k]
                length += m[k] * m[k]
            length = max(np.sqrt(length), 1e-12)
        else:
            length = 1.0
        for k in range(3):
            tilted[i, k] = m[k] / length
    return tilted
