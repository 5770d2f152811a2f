"""What the pixels of one view show, as columns for the shading kernels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers import paint
from renderers.appearance import Columns, vary_pixels
from renderers.gbuffer import F32, I32, GBuffer
from renderers.mesh import NOTHING, SceneMesh


@dataclass(frozen=True, eq=False)
class Surfaces:
    """The points that a picture's n = H·W pixels show; no light falls on those that show the sky.

    Attributes
    ----------
    shape : (H, W)
    points, normal, to_eye : (n, 3) float32
        For the sky, normal and direction are 0. Textures may tilt the normal.
    untilted : (n, 3) float32
        The normal without textures: shadows start off the surface along it.
    surface : (n,) int32
        Surface index, `NOTHING` for the sky; the columns of its material are undefined.
    base_color : (n, 3) float32
        As painted.
    roughness, metallic, specular : (n,) float32
    curved : (n,) bool
        Whether neighbours lie on another plane; undefined for the sky.
    corners : (n, 3) int32
        Vertices of the triangle, −1 for the sky.
    weights : (n, 3) float32
        Their barycentric weights, not extrapolated past an edge.
    landmark : (H, W) int32
        Id of the disc that a pixel shows, `NOTHING` elsewhere.
    """

    shape: tuple[int, int]
    points: F32
    normal: F32
    untilted: F32
    to_eye: F32
    surface: I32
    base_color: F32
    roughness: F32
    metallic: F32
    specular: F32
    curved: NDArray[np.bool_]
    corners: I32
    weights: F32
    landmark: I32

    @staticmethod
    def of(mesh: SceneMesh, gbuffer: GBuffer, discs: paint.Discs) -> Surfaces:
        """Look up the materials and paint the discs."""
        table, surface = mesh.materials, gbuffer.surface.reshape(-1)
        base_color = table.base_color.take(gbuffer.surface, axis=0, mode="clip")
        roughness = table.roughness.take(surface, mode="clip")
        metallic = table.metallic.take(surface, mode="clip")
        curved = mesh.curved.take(gbuffer.triangle.reshape(-1), mode="clip")
        untilted = normal = gbuffer.normal.reshape(-1, 3)
        corners, weights, to_eye = _columns(
            mesh.triangles,
            gbuffer.triangle.reshape(-1),
            gbuffer.barycentric.reshape(-1, 2),
            gbuffer.view.directions.reshape(-1, 3),
        )
        if not mesh.textures.empty:
            columns = Columns(base_color.reshape(-1, 3), roughness, metallic)
            normal, tilted = vary_pixels(mesh, gbuffer, weights, columns)
            curved |= tilted
        landmark = paint.paint(gbuffer, discs, base_color)
        height, width = gbuffer.surface.shape
        return Surfaces(
            shape=(height, width),
            points=gbuffer.position.reshape(-1, 3),
            normal=normal,
            untilted=untilted,
            to_eye=to_eye,
            surface=surface,
            base_color=base_color.reshape(-1, 3),
            roughness=roughness,
            metallic=metallic,
            specular=table.specular.take(surface, mode="clip"),
            curved=curved,
            corners=corners,
            weights=weights,
            landmark=landmark,
        )

    def material(self, part: slice) -> tuple[F32, F32, F32, F32]:
        """Base colour, roughness, metallic, specular of some pixels, as the shading kernels want them."""
        return self.base_color[part], self.roughness[part], self.metallic[part], self.specular[part]


@njit(cache=True, nogil=True)
def _columns(triangles: I32, triangle: I32, barycentric: F32, directions: F32) -> tuple[I32, F32, F32]:
    """Corners, their weights, and the directions to the eye."""
    corners = np.empty((len(triangle), 3), dtype=np.int32)
    weights, to_eye = np.zeros((2, len(triangle), 3), dtype=np.float32)
    for i in range(len(triangle)):
        if triangle[i] < 0:
            corners[i] = NOTHING
            continue
        for k in range(3):
            corners[i, k], to_eye[i, k] = triangles[triangle[i], k], -directions[i, k]
        v, w = max(barycentric[i, 0], np.float32(0)), max(barycentric[i, 1], np.float32(0))
        u = max(np.float32(1) - (barycentric[i, 0] + barycentric[i, 1]), np.float32(0))
        per_sum = np.float32(1) / (u + v + w)
        weights[i, 0], weights[i, 1], weights[i, 2] = u * per_sum, v * per_sum, w * per_sum
    return corners, weights, to_eye
