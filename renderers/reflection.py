"""What glossy surfaces mirror: one ray for each pixel, blurred as wide as the surface is rough.

Each pixel samples its lobe of visible normals (Heitz 2018) at one of 16 fixed points, neighbours at different
ones, and the mean over 4 × 4 pixels of one plane holds all 16 (interleaved sampling with a discontinuity
buffer, Keller & Heidrich 2001). Light is weighted as the lobe reflects it and normalised, so that uniform
surroundings are mirrored exactly; how much is reflected says `renderers.lobe_albedo`. On a curved surface no
neighbour shares the plane: its pixels cast all 16 rays themselves.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.gbuffer import F32, I32, I64
from renderers.lights import OFFSET_M, tangents
from renderers.lobe_albedo import smith_lambda, visible_normal
from renderers.mesh import NOTHING, RayCaster, SceneMesh
from renderers.shadows import interleaved

MIRROR_ROUGHNESS = 0.4
"""Rougher surfaces show no image of their surroundings; their lobe is wider than 10°."""

SHARP_ROUGHNESS = 0.1
"""Smoother surfaces mirror sharply: their lobe is about a pixel wide."""

LOBE_POINTS = 16

SAME_PLANE = 0.999
"""Least cosine between the normals of pixels whose rays are averaged."""


class Reflection:
    """The mirrored rays of a picture.

    Attributes
    ----------
    glossy : (g,) int64
        Which of the shaded pixels mirror anything.
    rays : int
        How many they cast: one each, in their order, and more from those on curved surfaces.
    hit, sky : (h,), (s,) int64
        Which of the rays hit a surface, and which leave the scene.
    triangle : (h,) int32
    weights : (h, 3) float32
        Barycentric, of the triangle's corners.
    points, normals : (h, 3) float32
    """

    def __init__(
        self,
        mesh: SceneMesh,
        caster: RayCaster,
        points: F32,
        normals: F32,
        to_eye: F32,
        roughness: F32,
        surface: I32,
        curved: NDArray[np.bool_],
        pixels: I64,
        shape: tuple[int, int],
        horizon_z: float,
    ) -> None:
        self.glossy = np.flatnonzero(roughness <= MIRROR_ROUGHNESS)
        self._normal, self._surface = normals[self.glossy], surface[self.glossy]
        self._pixels, self._shape = pixels[self.glossy], shape
        self._rough = roughness[self.glossy]
        blurry = self._rough > SHARP_ROUGHNESS
        self._alone = curved[self.glossy] | ~blurry
        first = interleaved(shape)[self._pixels]
        more = np.flatnonzero(curved[self.glossy] & blurry)
        others = (first[more, None] + np.arange(1, LOBE_POINTS)) % LOBE_POINTS
        self._from = np.concatenate([np.arange(len(self.glossy)), np.repeat(more, LOBE_POINTS - 1)])
        self.rays, of = len(self._from), self.glossy[self._from]
        u, w = _lobe_points()[np.concatenate([first, others.reshape(-1)])].T.copy()
        rays, self._weight = _lobe_rays(normals[of], to_eye[of], roughness[of], u, w)
        origins = points[of] + np.float32(OFFSET_M) * normals[of]
        triangle, distance, bary = caster.nearest(origins, rays)
        self.hit = np.flatnonzero(triangle != NOTHING)
        self.sky = np.flatnonzero((triangle == NOTHING) & (rays[:, 2] > horizon_z))
        self.triangle = triangle[self.hit]
        bary = bary[self.hit]
        self.weights = np.column_stack([1 - bary.sum(axis=1), bary]).astype(np.float32)
        self.points = origins[self.hit] + distance[self.hit, None] * rays[self.hit]
        facing = mesh.normals[self.triangle]
        away = np.einsum("nk,nk->n", facing, rays[self.hit]) > 0
        self.normals = np.where(away[:, None], -facing, facing).astype(np.float32)

    def blurred(self, luminance: F32) -> F32:
        """What each pixel mirrors, (g, 3), of what the rays bring, (rays, 3).

        The mean over its own rays, or over those of its 4 × 4 neighbours on its plane.
        """
        count = len(self.glossy)
        weight = np.bincount(self._from, self._weight, count).astype(np.float32)
        if self.rays > count:
            mine = [np.bincount(self._from, self._weight * luminance[:, c], count) for c in range(3)]
            luminance = (np.stack(mine, axis=-1) / np.maximum(weight, 1e-12)[:, None]).astype(np.float32)
        slot = np.full(self._shape[0] * self._shape[1], NOTHING, dtype=np.int32)
        slot[self._pixels] = np.arange(len(self._pixels))
        return _blur(
            luminance,
            weight,
            slot.reshape(self._shape),
            self._pixels,
            self._normal,
            self._surface,
            self._alone,
        )


def _lobe_points() -> F32:
    """(16, 2) float32: Hammersley's points in the unit square."""
    k = np.arange(LOBE_POINTS)
    reversed_bits = sum(((k >> b) & 1) << (3 - b) for b in range(4))
    return np.stack([(k + 0.5) / LOBE_POINTS, (reversed_bits + 0.5) / LOBE_POINTS], axis=-1).astype(
        np.float32
    )


@njit(cache=True)
def _lobe_rays(normal: F32, to_eye: F32, roughness: F32, u: F32, w: F32) -> tuple[F32, F32]:
    """Reflected directions (n, 3), and what the lobe gives each: G2 / G1, 0 below the surface."""
    n = len(normal)
    rays, weight = np.empty((n, 3), dtype=np.float32), np.empty(n, dtype=np.float32)
    for i in range(n):
        x, y, z = normal[i, 0], normal[i, 1], normal[i, 2]
        ex, ey, ez = to_eye[i, 0], to_eye[i, 1], to_eye[i, 2]
        nv = max(x * ex + y * ey + z * ez, 1e-3)
        hx, hy, hz = x, y, z
        nl = nv
        alpha = roughness[i] * roughness[i]
        if roughness[i] > SHARP_ROUGHNESS:
            # across the surface: a along the view, b beside it
            ax, ay, az = ex - nv * x, ey - nv * y, ez - nv * z
            length = np.sqrt(ax * ax + ay * ay + az * az)
            if length > 1e-4:
                ax, ay, az = ax / length, ay / length, az / length
            else:
                ax, ay, az, _, _, _ = tangents(x, y, z)
            bx, by, bz = y * az - z * ay, z * ax - x * az, x * ay - y * ax
            p, q, r = visible_normal(np.sqrt(max(1.0 - nv * nv, 0.0)), nv, alpha, u[i], w[i])
            hx, hy, hz = p * ax + q * bx + r * x, p * ay + q * by + r * y, p * az + q * bz + r * z
        vh = ex * hx + ey * hy + ez * hz
        rays[i, 0], rays[i, 1], rays[i, 2] = 2 * vh * hx - ex, 2 * vh * hy - ey, 2 * vh * hz - ez
        nl = x * rays[i, 0] + y * rays[i, 1] + z * rays[i, 2]
        weight[i] = 0.0
        if nl > 0.0:
            at_eye, at_light = smith_lambda(nv, alpha), smith_lambda(nl, alpha)
            weight[i] = (1.0 + at_eye) / (1.0 + at_eye + at_light)
    return rays, weight


@njit(cache=True)
def _blur(
    luminance: F32,
    weight: F32,
    slot: I32,
    pixels: I64,
    normal: F32,
    surface: I32,
    alone: NDArray[np.bool_],
) -> F32:
    """Mean with taps ½ 1 1 1 ½ in rows and columns, which counts each of the 16 numbers once."""
    height, width = slot.shape
    mean = np.zeros_like(luminance)
    for i in range(len(pixels)):
        if alone[i]:
            mean[i] = luminance[i]
            continue
        row, column = pixels[i] // width, pixels[i] % width
        total = 0.0
        r = g = b = 0.0
        for dr in range(-2, 3):
            for dc in range(-2, 3):
                y, x = row + dr, column + dc
                if y < 0 or y >= height or x < 0 or x >= width:
                    continue
                k = slot[y, x]
                if k < 0 or surface[k] != surface[i]:
                    continue
                same = normal[k, 0] * normal[i, 0] + normal[k, 1] * normal[i, 1] + normal[k, 2] * normal[i, 2]
                if same < SAME_PLANE:
                    continue
                tap = weight[k] * (0.5 if abs(dr) == 2 else 1.0) * (0.5 if abs(dc) == 2 else 1.0)
                total += tap
                r += tap * luminance[k, 0]
                g += tap * luminance[k, 1]
                b += tap * luminance[k, 2]
        if total > 0.0:
            mean[i, 0], mean[i, 1], mean[i, 2] = r / total, g / total, b / total
    return mean
