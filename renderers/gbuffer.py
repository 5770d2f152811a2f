"""The G-buffer: what each pixel shows. Engines find the triangle; everything else follows from it here."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.camera import Camera, pixel_rays
from renderers.mesh import NOTHING, SceneMesh
from renderers.threads import ALONE, Threads

F32 = NDArray[np.float32]
I32 = NDArray[np.int32]
I64 = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class View:
    """A camera at a place.

    Attributes
    ----------
    T_world_camera : (4, 4) float64
    """

    camera: Camera
    T_world_camera: NDArray[np.float64]

    @property
    def origin(self) -> F32:
        """(3,) float32: the camera's position in the world."""
        return self.T_world_camera[:3, 3].astype(np.float32)

    @cached_property
    def directions(self) -> F32:
        """(H, W, 3) float32: unit direction of each pixel in the world."""
        return _turned(pixel_rays(self.camera), np.ascontiguousarray(self.T_world_camera[:3, :3]))


@dataclass(frozen=True, eq=False)
class GBuffer:
    """What each pixel of a view shows.

    Attributes
    ----------
    triangle : (H, W) int32
        Index into the mesh, `NOTHING` where the sky is seen.
    distance : (H, W) float32
        Along the pixel's ray, metres; inf for the sky.
    position, normal : (H, W, 3) float32
        Of the point seen; the normal faces the camera, and on curved surfaces lies between the vertices'. For
        the sky the camera's position, and no normal: 0, which no light falls on.
    barycentric : (H, W, 2) float32
        Weights of the triangle's second and third vertex; 0 for the sky.
    surface : (H, W) int32
        Surface index, `NOTHING` for the sky.
    """

    view: View
    triangle: I32
    distance: F32
    position: F32
    normal: F32
    barycentric: F32
    surface: I32

    @property
    def depth(self) -> F32:
        """(H, W) float32: z in the camera frame, metres; 0 for the sky and where z is not positive."""
        z_axis = self.view.T_world_camera[:3, 2].astype(np.float32)
        z = np.where(self.triangle == NOTHING, 0.0, self.distance) * (self.view.directions @ z_axis)
        return np.maximum(z, 0.0).astype(np.float32)


class Engine(Protocol):
    """Finds which triangle each pixel shows."""

    name: str

    def visible(self, view: View) -> tuple[I32, F32]:
        """(H, W) triangle index and distance along the ray (metres) of each pixel."""

    def close(self) -> None:
        """Give back what the engine holds outside of Python."""


def fill(mesh: SceneMesh, view: View, engine: Engine, threads: Threads = ALONE) -> GBuffer:
    """Let an engine find the triangles and derive the rest from the mesh.

    Barycentric weights come from the exact point on each pixel's ray, so both engines are held to the
    same geometry. On an edge a rasterised neighbour's weights may leave 0…1 by part of a pixel.
    """
    triangle, distance = engine.visible(view)
    n, shape = triangle.size, triangle.shape
    position, normal = np.empty((n, 3), dtype=np.float32), np.empty((n, 3), dtype=np.float32)
    barycentric, surface = np.empty((n, 2), dtype=np.float32), np.empty(n, dtype=np.int32)

    def derive(part: slice) -> None:
        _derive(
            view.origin,
            mesh.vertices,
            mesh.triangles,
            mesh.normals,
            mesh.vertex_normals,
            mesh.curved,
            mesh.surface,
            view.directions.reshape(-1, 3)[part],
            triangle.reshape(-1)[part],
            distance.reshape(-1)[part],
            position[part],
            normal[part],
            barycentric[part],
            surface[part],
        )

    threads.over(n, derive)
    return GBuffer(
        view=view,
        triangle=triangle,
        distance=distance,
        position=position.reshape(*shape, 3),
        normal=normal.reshape(*shape, 3),
        barycentric=barycentric.reshape(*shape, 2),
        surface=surface.reshape(shape),
    )


@njit(cache=True)
def _turned(rays: NDArray[np.float64], R: NDArray[np.float64]) -> F32:
    """(H, W, 3) float32: R @ each ray. BLAS is slow at such small products."""
    height, width, _ = rays.shape
    turned = np.empty((height, width, 3), dtype=np.float32)
    for r in range(height):
        for c in range(width):
            x, y, z = rays[r, c]
            for k in range(3):
                turned[r, c, k] = R[k, 0] * x + R[k, 1] * y + R[k, 2] * z
    return turned


@njit(cache=True, nogil=True)
def _derive(
    origin: F32,
    vertices: F32,
    triangles: I32,
    normals: F32,
    vertex_normals: F32,
    curved: NDArray[np.bool_],
    surfaces: I32,
    directions: F32,
    triangle: I32,
    distance: F32,
    position: F32,
    normal: F32,
    barycentric: F32,
    surface: I32,
) -> None:
    """A column's points from their triangles and distances; the weights as in Ericson 2005, 3.4."""
    for i in range(len(triangle)):
        t = triangle[i]
        if t < 0:
            position[i], normal[i], barycentric[i], surface[i] = origin, 0.0, 0.0, NOTHING
            continue
        towards = np.float32(0.0)
        bb = bc = cc = pb = pc = 0.0
        for k in range(3):
            position[i, k] = origin[k] + distance[i] * directions[i, k]
            towards += normals[t, k] * directions[i, k]
            at = float(vertices[triangles[t, 0], k])
            b, e = vertices[triangles[t, 1], k] - at, vertices[triangles[t, 2], k] - at
            p = position[i, k] - at
            bb += b * b
            bc += b * e
            cc += e * e
            pb += p * b
            pc += p * e
        for k in range(3):
            normal[i, k] = -normals[t, k] if towards > 0.0 else normals[t, k]
        scale = 1.0 / max(bb * cc - bc * bc, 1e-30)
        barycentric[i, 0] = (cc * pb - bc * pc) * scale
        barycentric[i, 1] = (bb * pc - bc * pb) * scale
        surface[i] = surfaces[t]
        if curved[t]:
            _bend(normal[i], vertex_normals, triangles[t], barycentric[i], directions[i])


@njit(cache=True, nogil=True)
def _bend(normal: F32, vertex_normals: F32, corners: I32, weights: F32, ray: F32) -> None:
    """Turn a flat normal (3,) to that between its corners', on the same side and not away from its ray."""
    v, w = max(weights[0], np.float32(0)), max(weights[1], np.float32(0))
    u = max(np.float32(1) - (weights[0] + weights[1]), np.float32(0))
    a, b, c = vertex_normals[corners[0]], vertex_normals[corners[1]], vertex_normals[corners[2]]
    bent = u * a + v * b + w * c
    if bent[0] * normal[0] + bent[1] * normal[1] + bent[2] * normal[2] < 0.0:
        bent = -bent
    bent /= max(np.sqrt(bent[0] ** 2 + bent[1] ** 2 + bent[2] ** 2), np.float32(1e-6))
    away = bent[0] * ray[0] + bent[1] * ray[1] + bent[2] * ray[2]
    if away > 0.0:  # at a silhouette: turned until it is seen edge-on
        bent = bent - away * ray
        bent /= max(np.sqrt(bent[0] ** 2 + bent[1] ** 2 + bent[2] ** 2), np.float32(1e-6))
    normal[:] = bent


@njit(cache=True, nogil=True)
def interpolate(at_vertices: F32, corners: I32, weights: F32) -> F32:
    """Values inside triangles from values at the mesh's vertices.

    Parameters
    ----------
    at_vertices : (v, m) float32
    corners : (n, 3) int32
        Vertices of the triangle; negative for none, which gives 0.
    weights : (n, 3) float32
        Barycentric, of the corners.

    Returns
    -------
    (n, m) float32
    """
    values = np.empty((len(corners), at_vertices.shape[1]), dtype=np.float32)
    for i in range(len(corners)):
        if corners[i, 0] < 0:
            values[i] = 0.0
            continue
        a, b, c = at_vertices[corners[i, 0]], at_vertices[corners[i, 1]], at_vertices[corners[i, 2]]
        row, u, v, w = values[i], weights[i, 0], weights[i, 1], weights[i, 2]
        for j in range(len(row)):
            row[j] = u * a[j] + v * b[j] + w * c[j]
    return values
