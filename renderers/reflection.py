"""What glossy surfaces mirror: one ray for each pixel, blurred as wide as the surface is rough.

Each pixel samples its lobe of visible normals (Heitz 2018) at one of 16 fixed points, neighbours at different
ones (interleaved sampling, Keller & Heidrich 2001), and shows the mean over neighbours on its plane
(`renderers.lobe_average`). Light is weighted as the lobe reflects it and normalised, so that uniform
surroundings are mirrored exactly; how much is reflected says `renderers.lobe_albedo`. On a curved surface no
neighbour shares the plane: its pixels cast all 16 rays themselves.
"""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np
from numba import njit

from renderers.gbuffer import F32, I32, I64
from renderers.lights import OFFSET_M, tangents
from renderers.lobe_albedo import smith_lambda, visible_normal
from renderers.lobe_average import lobe_average
from renderers.mesh import NOTHING, RayCaster, SceneMesh
from renderers.shadows import interleaved
from renderers.surfaces import Surfaces
from renderers.threads import Threads

MIRROR_ROUGHNESS = 0.4
"""Rougher surfaces show no image of their surroundings; their lobe is wider than 10°."""

SHARP_ROUGHNESS = 0.1
"""Smoother surfaces mirror sharply: their lobe is about a pixel wide."""

R2 = np.array([0.7548776662466927, 0.5698402909980532])
"""1/φ and 1/φ² of the plastic number φ."""

LOBE_POINTS = 16


class Reflection:
    """The mirrored rays of a picture and where they end.

    Attributes
    ----------
    glossy : (g,) int64
        The pixels that mirror anything, by flat index.
    points, normals : (rays, 3) float32
        Where their rays end, one for each of them and then 15 more for each on a curved surface; the normal
        is 0 where that is the sky.
    triangle : (rays,) int32
        What they meet, `NOTHING` for the sky.
    barycentric : (rays, 2) float32
        Where in it: weights of its second and third vertex.
    mirrors : (H·W,) bool
        Whether a pixel is one of ``glossy``.
    """

    def __init__(
        self,
        mesh: SceneMesh,
        caster: RayCaster,
        surfaces: Surfaces,
        eye: F32,
        horizon_z: float,
        threads: Threads,
        factor: int,
    ) -> None:
        self._mesh, self._surfaces, self._horizon_z, self._threads = mesh, surfaces, horizon_z, threads
        self._eye, self._factor = eye, factor
        self.mirrors = (surfaces.roughness <= MIRROR_ROUGHNESS) & (surfaces.surface != NOTHING)
        self.glossy = np.flatnonzero(self.mirrors)
        blurry, curved = surfaces.roughness[self.glossy] > SHARP_ROUGHNESS, surfaces.curved[self.glossy]
        self._curved, self._flat = self.glossy[blurry & curved], self.glossy[blurry & ~curved]
        first = interleaved(surfaces.shape)
        others = (first[self._curved, None] + np.arange(1, LOBE_POINTS)) % LOBE_POINTS
        self._pixel = np.concatenate([self.glossy, np.repeat(self._curved, LOBE_POINTS - 1)])
        self._number = np.concatenate([first[self.glossy], others.reshape(-1)])
        self._rays = np.empty((len(self._pixel), 6), dtype=np.float32)
        self._weight = np.zeros(len(self._pixel), dtype=np.float32)
        threads.over(len(self._pixel), self._aim)
        self.triangle, self._distance, self.barycentric = caster.first_hit(self._rays)
        self.points, self.normals = np.empty_like(self._rays[:, :3]), np.empty_like(self._rays[:, :3])
        threads.over(len(self._pixel), self._arrive)
        self._first_weight = np.zeros(len(surfaces.surface), dtype=np.float32)
        self._first_weight[self.glossy] = self._weight[: len(self.glossy)]

    def _aim(self, part: slice) -> None:
        at = self._surfaces
        _lobe_rays(
            self._pixel[part],
            at.points,
            at.normal,
            at.to_eye,
            at.roughness,
            _lobe_points(),
            _lobe_shifts(at.shape, self._factor),
            self._number[part],
            self._rays[part],
            self._weight[part],
        )

    def _arrive(self, part: slice) -> None:
        ends = self._rays[part], self.triangle[part], self._distance[part]
        _arrive(*ends, self._mesh.normals, self.points[part], self.normals[part])

    def bring(self, baked: F32, albedo: F32, which: I32, sky: F32, sunlit: F32, sunny: I32) -> F32:
        """Mean luminance in the lobe of each glossy pixel, (H·W, 3 L) float32 cd/m²; no other rows are set.

        On a curved surface the mean over the pixel's 16 rays, on a flat one over its neighbours' rays.

        Parameters
        ----------
        baked : (v, 3 L) float32
            Illuminance at the mesh's vertices, lux, channels within layers.
        albedo : (a, 3) float32
            Diffuse albedos.
        which : (rays,) int32
            Which of them each ray meets; of the sky's, any.
        sky : (L,) float32
            The sky's luminance in each layer.
        sunlit : (s, rays) float32
            Lux of each sun where the rays end, not in ``baked``.
        sunny : (s,) int32
            The layers they belong to.
        """
        count, layers = len(self.glossy), baked.shape[1]
        light = np.empty((len(self._first_weight), layers), dtype=np.float32)
        more = np.empty((len(self._pixel) - count, layers), dtype=np.float32)

        def bring(part: slice, rows: I64, into: F32) -> None:
            ends = rows, self._rays[part], self.triangle[part], self.barycentric[part]
            met = baked, albedo, which[part]
            _bring(part.start, *ends, self._horizon_z, self._mesh.triangles, *met, sky, sunlit, sunny, into)

        def first(part: slice) -> None:
            bring(part, self.glossy[part], light)

        def others(part: slice) -> None:
            bring(slice(count + part.start, count + part.stop), np.arange(part.start, part.stop), more)

        self._threads.over(count, first)
        if len(more):
            self._threads.over(len(more), others)
            _fold(light, more, self._curved, self._first_weight, self._weight[count:])
        self._average(light)
        return light

    def _average(self, light: F32) -> None:
        """Turn single rays into the mean over the lobe, where one is neither sharp nor curved."""
        behind = np.zeros((len(light), 2), dtype=np.float32)

        def locate(part: slice) -> None:
            at, way = self._surfaces.points, self._distance[part]
            _behind(self.glossy[part], at, self._eye, way, self._first_weight, behind)

        self._threads.over(len(self.glossy), locate)
        lobe_average(light, self._first_weight, behind, self._flat, self._surfaces, self._threads)


@cache
def _lobe_points() -> F32:
    """(16, 2) float32: Hammersley's points in the unit square."""
    k = np.arange(LOBE_POINTS)
    reversed_bits = sum(((k >> b) & 1) << (3 - b) for b in range(4))
    return np.stack([(k + 0.5) / LOBE_POINTS, (reversed_bits + 0.5) / LOBE_POINTS], axis=-1).astype(
        np.float32
    )


@lru_cache(maxsize=4)
def _lobe_shifts(shape: tuple[int, int], factor: int) -> F32:
    """(H·W, 2) float32: how each sample shifts its lobe's points on the torus (Cranley & Patterson 1976).

    The blocks of 4 × 4 of a pixel of ``factor`` squared samples go along the sequence R2 (Roberts 2018), so
    that more samples converge; every pixel alike, and one sample a pixel not at all, so that no noise shows.
    """
    row, column = np.divmod(np.arange(shape[0] * shape[1]), shape[1])
    block = row // 4 % factor * factor + column // 4 % factor
    shifts = ((block[:, None] * R2) % 1.0).astype(np.float32)
    shifts.setflags(write=False)
    return shifts


@njit(cache=True, nogil=True)
def _lobe_rays(
    pixel: I64,
    points: F32,
    normal: F32,
    to_eye: F32,
    roughness: F32,
    lobe: F32,
    shift: F32,
    number: I64,
    rays: F32,
    weight: F32,
) -> None:
    """Reflected rays (r, 6), and what the lobe gives each: G2 / G1, 0 below the surface."""
    for k in range(len(pixel)):
        i = pixel[k]
        x, y, z = normal[i, 0], normal[i, 1], normal[i, 2]
        ex, ey, ez = to_eye[i, 0], to_eye[i, 1], to_eye[i, 2]
        nv = max(x * ex + y * ey + z * ez, 1e-3)
        hx, hy, hz = x, y, z
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
            u, w = (lobe[number[k], 0] + shift[i, 0]) % 1.0, (lobe[number[k], 1] + shift[i, 1]) % 1.0
            p, q, r = visible_normal(np.sqrt(max(1.0 - nv * nv, 0.0)), nv, alpha, u, w)
            hx, hy, hz = p * ax + q * bx + r * x, p * ay + q * by + r * y, p * az + q * bz + r * z
        vh = ex * hx + ey * hy + ez * hz
        for c in range(3):
            rays[k, c] = points[i, c] + np.float32(OFFSET_M) * normal[i, c]
        rays[k, 3], rays[k, 4], rays[k, 5] = 2 * vh * hx - ex, 2 * vh * hy - ey, 2 * vh * hz - ez
        nl = x * rays[k, 3] + y * rays[k, 4] + z * rays[k, 5]
        if nl > 0.0:
            at_eye, at_light = smith_lambda(nv, alpha), smith_lambda(nl, alpha)
            weight[k] = (1.0 + at_eye) / (1.0 + at_eye + at_light)


@njit(cache=True, nogil=True)
def _arrive(rays: F32, triangle: I32, distance: F32, facing: F32, points: F32, normals: F32) -> None:
    """The points where rays end, and the normals there that face them; 0 where they meet nothing."""
    for k in range(len(rays)):
        t = triangle[k]
        if t < 0:
            points[k], normals[k] = 0.0, 0.0
            continue
        away = rays[k, 3] * facing[t, 0] + rays[k, 4] * facing[t, 1] + rays[k, 5] * facing[t, 2]
        for c in range(3):
            points[k, c] = rays[k, c] + distance[k] * rays[k, 3 + c]
            normals[k, c] = -facing[t, c] if away > 0.0 else facing[t, c]


@njit(cache=True)
def _fold(light: F32, more: F32, pixel: I64, first_weight: F32, weight: F32) -> None:
    """Turn the rows of some pixels into means over their first ray and the others."""
    for c in range(len(pixel)):
        row, total = light[pixel[c]], first_weight[pixel[c]]
        row *= total
        for k in range(c * (LOBE_POINTS - 1), (c + 1) * (LOBE_POINTS - 1)):
            row += weight[k] * more[k]
            total += weight[k]
        if total > 0.0:
            row /= total


@njit(cache=True, nogil=True)
def _bring(
    start: int,
    rows: I64,
    rays: F32,
    triangle: I32,
    bary: F32,
    horizon_z: float,
    triangles: I32,
    baked: F32,
    albedo: F32,
    which: I32,
    sky: F32,
    sunlit: F32,
    sunny: I32,
    light: F32,
) -> None:
    """What `Reflection.bring` says, for the rays from number ``start`` on."""
    for k in range(len(rows)):
        row, t = light[rows[k]], triangle[k]
        if t < 0:
            for j in range(len(row)):
                row[j] = sky[j // 3] if rays[k, 5] > horizon_z else np.float32(0.0)
            continue
        v, w = bary[k, 0], bary[k, 1]
        u = np.float32(1.0) - (v + w)
        a, b, c = baked[triangles[t, 0]], baked[triangles[t, 1]], baked[triangles[t, 2]]
        for j in range(len(row)):
            row[j] = u * a[j] + v * b[j] + w * c[j]
        for s in range(len(sunny)):
            for j in range(3 * sunny[s], 3 * sunny[s] + 3):
                row[j] += sunlit[s, start + k]
        for channel in range(3):
            per_lux = albedo[which[k], channel] * np.float32(1 / np.pi)
            for j in range(channel, len(row), 3):
                row[j] *= per_lux


@njit(cache=True, nogil=True)
def _behind(pixels: I64, points: F32, eye: F32, distance: F32, weight: F32, behind: F32) -> None:
    """How far behind the surface a mirror image lies, over the way from the eye to it, 1 for the sky's; both
    columns by weight.
    """
    for k in range(len(pixels)):
        i = pixels[k]
        x, y, z = points[i, 0] - eye[0], points[i, 1] - eye[1], points[i, 2] - eye[2]
        way = np.sqrt(x * x + y * y + z * z) + distance[k]
        share = distance[k] / way if distance[k] < np.inf else np.float32(1)
        behind[i, 0], behind[i, 1] = weight[i] * share, weight[i]
