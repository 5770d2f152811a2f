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
        rays = pixel_rays(self.camera) @ self.T_world_camera[:3, :3].T
        return np.ascontiguousarray(rays, dtype=np.float32)


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
        Of the point seen; the normal faces the camera, and on curved surfaces lies between the vertices'.
        Undefined for the sky.
    barycentric : (H, W, 2) float32
        Weights of the triangle's second and third vertex.
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


def fill(mesh: SceneMesh, view: View, engine: Engine) -> GBuffer:
    """Let an engine find the triangles and derive the rest from the mesh.

    Barycentric weights come from the exact point on each pixel's ray, so both engines are held to the
    same geometry. On an edge a rasterised neighbour's weights may leave 0…1 by part of a pixel.
    """
    triangle, distance = engine.visible(view)
    seen = triangle != NOTHING
    index = np.where(seen, triangle, 0)
    normal = mesh.normals[index]
    towards = np.einsum("hwc,hwc->hw", normal, view.directions, optimize=False)
    normal = np.where((towards > 0)[..., None], -normal, normal)
    position = view.origin + np.where(seen, distance, 0.0)[..., None].astype(np.float32) * view.directions
    barycentric = _barycentric(mesh.vertices, mesh.triangles, triangle, position)
    curved = seen & mesh.curved[index]
    if curved.any():
        normal[curved] = _between_vertices(
            mesh, triangle[curved], barycentric[curved], normal[curved], view.directions[curved]
        )
    return GBuffer(
        view=view,
        triangle=triangle,
        distance=distance,
        position=position,
        normal=normal,
        barycentric=barycentric,
        surface=np.where(seen, mesh.surface[index], NOTHING).astype(np.int32),
    )


def _between_vertices(mesh: SceneMesh, triangle: I32, barycentric: F32, flat: F32, rays: F32) -> F32:
    """(n, 3) normals between the vertices', on the side of the flat ones; none faces away from its ray.

    Parameters
    ----------
    triangle : (n,) int32
    barycentric : (n, 2) float32
    flat, rays : (n, 3) float32
        Geometric normal towards the camera, and the camera's ray.
    """
    weights = np.column_stack([1 - barycentric.sum(axis=1), barycentric]).clip(min=0.0).astype(np.float32)
    normal = interpolate(mesh.vertex_normals, mesh.triangles[triangle], weights)
    normal *= np.sign(np.einsum("nk,nk->n", normal, flat))[:, None]
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-6)
    away = np.maximum(np.einsum("nk,nk->n", normal, rays), 0.0)[:, None]
    normal -= away * rays  # at a silhouette: turned until it is seen edge-on
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-6))


@njit(cache=True)
def _barycentric(vertices: F32, triangles: I32, triangle: I32, position: F32) -> F32:
    """Weights of the second and third vertex (Ericson 2005, Real-Time Collision Detection, 3.4)."""
    height, width = triangle.shape
    weights = np.zeros((height, width, 2), dtype=np.float32)
    for r in range(height):
        for c in range(width):
            if triangle[r, c] < 0:
                continue
            corner = triangles[triangle[r, c]]
            bb = bc = cc = pb = pc = 0.0
            for k in range(3):
                at = float(vertices[corner[0], k])
                b, e, p = vertices[corner[1], k] - at, vertices[corner[2], k] - at, position[r, c, k] - at
                bb += b * b
                bc += b * e
                cc += e * e
                pb += p * b
                pc += p * e
            scale = 1.0 / max(bb * cc - bc * bc, 1e-30)
            weights[r, c, 0] = (cc * pb - bc * pc) * scale
            weights[r, c, 1] = (bb * pc - bc * pb) * scale
    return weights


@njit(cache=True)
def interpolate(at_vertices: F32, corners: I32, weights: F32) -> F32:
    """Values inside triangles from values at the mesh's vertices.

    Parameters
    ----------
    at_vertices : (v, 3) float32
    corners : (n, 3) int32
    weights : (n, 3) float32
        Barycentric, of the corners.

    Returns
    -------
    (n, 3) float32
    """
    values = np.empty((len(corners), 3), dtype=np.float32)
    for i in range(len(corners)):
        for c in range(3):
            values[i, c] = (
                weights[i, 0] * at_vertices[corners[i, 0], c]
                + weights[i, 1] * at_vertices[corners[i, 1], c]
                + weights[i, 2] * at_vertices[corners[i, 2], c]
            )
    return values
