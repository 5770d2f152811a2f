"""Every layer of a scene's light over one view: direct and bounced light, mirror images, lamps.

What all layers share is found once: triangles, mirrored rays, the neighbours that they are averaged with.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from renderers.appearance import materials_at
from renderers.gather import diffuse_albedo
from renderers.gbuffer import F32, I32, I64, GBuffer, interpolate
from renderers.irradiance import Irradiance
from renderers.lights import (
    HORIZON_Z,
    BulbLight,
    DirectLight,
    SkyLight,
    SunLight,
    UnitLight,
    bounding_balls,
)
from renderers.lobe_albedo import albedo_table
from renderers.mesh import NOTHING, RayCaster, SceneMesh
from renderers.reflection import Reflection
from renderers.shade import shade_ambient, shade_light
from renderers.shadow_cache import ShadowCache, lit_shares, visible_points
from renderers.shadows import POINTS, lit_share, visible_shares
from renderers.surface_cells import CellGrid
from renderers.surfaces import Surfaces
from renderers.threads import BLOCK, Threads

MIRRORED_FOOTPRINT_M = 0.02
"""What a mirrored ray sees of a texture: about a pixel of 8 mrad after 2.5 m."""


class LayerShader:
    """Shades all layers of one scene's light.

    Parameters
    ----------
    layers : list of lists of lights
        The lights that share an intensity, by layer.
    irradiance : Irradiance
        Baked for the same layers.
    bounces : bool
        Whether mirrored surfaces are seen; without, their images are black.
    cached_shadows : bool
        Whether what lights reach is told once (`renderers.shadow_cache`).
    """

    def __init__(
        self,
        mesh: SceneMesh,
        caster: RayCaster,
        layers: list[list[UnitLight]],
        irradiance: Irradiance,
        bounces: bool,
        threads: Threads,
        supersampling: int,
        cached_shadows: bool = False,
    ) -> None:
        self._supersampling = supersampling
        self._mesh, self._caster, self._layers, self._threads = mesh, caster, layers, threads
        self._suns = [
            (k, light) for k, lights in enumerate(layers) for light in lights if isinstance(light, SunLight)
        ]
        self._direct_lights = [
            [light for light in group if isinstance(light, DirectLight)] for group in layers
        ]
        self._cells = CellGrid.of(mesh) if cached_shadows else None
        self._shadows: dict[str, ShadowCache] = {}
        if self._cells is not None:
            direct = [light for lights in self._direct_lights for light in lights]
            self._shadows = {light.name: ShadowCache(self._cells, light, caster, threads) for light in direct}
        sunny = {k for k, _ in self._suns}  # the sun's patches have sharp edges, which vertices would blur
        parts = zip(irradiance.indirect, irradiance.total, strict=True)
        self._indirect = _by_vertex(irradiance.indirect)
        self._mirrored = _by_vertex([own if k in sunny else all_ for k, (own, all_) in enumerate(parts)])
        self._albedo, self._bounces = diffuse_albedo(mesh.materials) * np.float32(bounces), bounces
        self._sky = np.array([_sky(lights) for lights in layers], dtype=np.float32)

    def shade(self, gbuffer: GBuffer, surfaces: Surfaces) -> tuple[F32, F32]:
        """Diffuse and specular luminance of each layer at unit intensity, (L, H, W, 3) float32 cd/m²."""
        size = (len(self._layers), len(surfaces.surface), 3)
        diffuse, specular = np.empty(size, dtype=np.float32), np.empty(size, dtype=np.float32)
        self._ambient(surfaces, gbuffer.view.origin, diffuse, specular)
        cells = None
        if self._cells is not None:
            seen = gbuffer.triangle, gbuffer.barycentric, surfaces.untilted
            cells = self._told(self._cells, list(self._shadows), *seen)
        balls = bounding_balls(surfaces.points, BLOCK)
        for k, lights in enumerate(self._direct_lights):
            missed = [light.misses(*balls) for light in lights]
            self._direct(lights, surfaces, missed, cells, diffuse[k], specular[k])
        self._emission(gbuffer, diffuse)
        shape = (len(self._layers), *surfaces.shape, 3)
        return diffuse.reshape(shape), specular.reshape(shape)

    def _ambient(self, surfaces: Surfaces, eye: F32, diffuse: F32, specular: F32) -> None:
        """Bounced light, the sky's, and mirror images; bulbs' images are the highlights of direct light."""
        reflection = Reflection(
            self._mesh, self._caster, surfaces, eye, HORIZON_Z, self._threads, self._supersampling
        )
        light = reflection.bring(
            self._mirrored, *self._mirrored_albedo(reflection), self._sky, *self._sunlit(reflection)
        )

        def work(part: slice) -> None:
            shade_ambient(
                surfaces.normal[part],
                surfaces.to_eye[part],
                interpolate(self._indirect, surfaces.corners[part], surfaces.weights[part]),
                light[part],
                reflection.mirrors[part],
                albedo_table(),
                *surfaces.material(part),
                diffuse[:, part],
                specular[:, part],
            )

        self._threads.over(len(surfaces.surface), work)

    def _mirrored_albedo(self, reflection: Reflection) -> tuple[F32, I32]:
        """Albedos (a, 3), and which of them each mirrored ray meets, (rays,)."""
        mesh, triangle = self._mesh, reflection.triangle
        if mesh.textures.empty:
            return self._albedo, mesh.surface.take(triangle, mode="clip")
        weights = np.column_stack([1 - reflection.barycentric.sum(axis=1), reflection.barycentric])
        met = materials_at(mesh, np.maximum(triangle, 0), weights, MIRRORED_FOOTPRINT_M)
        return diffuse_albedo(met) * np.float32(self._bounces), np.arange(len(triangle), dtype=np.int32)

    def _sunlit(self, reflection: Reflection) -> tuple[F32, I32]:
        """(s, rays) lux of each sun where the mirrored rays end, and (s,) the layer it belongs to."""
        total = np.zeros((len(self._suns), len(reflection.points)), dtype=np.float32)
        for row, (_, light) in zip(total, self._suns, strict=True):
            to_light, lux, _ = light.arriving(reflection.points, reflection.normals)
            lit = np.flatnonzero(lux)
            cosine = np.einsum("nk,nk->n", reflection.normals[lit], to_light[lit])
            row[lit] = lux[lit] * cosine * self._sunny(light, reflection, lit)
        return total, np.array([k for k, _ in self._suns], dtype=np.int32)

    def _sunny(self, light: SunLight, reflection: Reflection, lit: I64) -> F32:
        """The share of a sun that the ends of some mirrored rays see."""
        rays = reflection.points, reflection.normals, lit, self._caster
        if self._cells is None:
            return lit_share(light, *rays, threads=self._threads)
        ends = reflection.triangle[lit], reflection.barycentric[lit], reflection.normals[lit]
        cells = self._told(self._cells, [light.name], *ends)
        return lit_shares(light, self._shadows[light.name], cells, *rays, self._threads)

    def _told(self, grid: CellGrid, lights: list[str], triangle: I32, barycentric: F32, normals: F32) -> I32:
        """The cells of points on triangles, about which some lights' caches know all there is."""
        triangle = triangle.reshape(-1)
        seen = np.zeros(len(grid.side) + 1, dtype=bool)
        seen[triangle] = True  # the last is the sky's
        for name in lights:
            self._shadows[name].tell(seen[:-1])
        return grid.cells(triangle, barycentric.reshape(-1, 2), normals)

    def _direct(
        self,
        lights: list[DirectLight],
        surfaces: Surfaces,
        missed: list[NDArray[np.bool_]],
        cells: I32 | None,
        diffuse: F32,
        specular: F32,
    ) -> None:
        """Add a layer's suns and bulbs, shadows included; ``missed`` blocks of pixels get no light."""
        seen = (
            self._cast(lights, surfaces, missed) if cells is None else self._look_up(lights, surfaces, cells)
        )

        def shade(part: slice) -> None:
            for light, points, dark in zip(lights, seen, missed, strict=True):
                if dark[part.start // BLOCK] or not points[part].any():
                    continue
                to_light, lux, spread = light.arriving(surfaces.points[part], surfaces.normal[part])
                lux *= points[part] * np.float32(1 / POINTS)
                shade_light(
                    surfaces.normal[part],
                    surfaces.to_eye[part],
                    to_light,
                    lux,
                    spread,
                    *surfaces.material(part),
                    diffuse[part],
                    specular[part],
                )

        self._threads.over(len(surfaces.surface), shade)

    def _cast(
        self, lights: list[DirectLight], surfaces: Surfaces, missed: list[NDArray[np.bool_]]
    ) -> list[NDArray[np.uint8]]:
        """How many points of each light's disc each pixel sees, by rays of its own."""
        lux = [np.zeros(len(surfaces.surface), dtype=np.float32) for _ in lights]

        def arrive(part: slice) -> None:
            for light, column, dark in zip(lights, lux, missed, strict=True):
                if not dark[part.start // BLOCK]:
                    column[part] = light.arriving(surfaces.points[part], surfaces.normal[part])[1]

        self._threads.over(len(surfaces.surface), arrive)
        view = surfaces.points, surfaces.untilted, self._caster, surfaces.shape, self._threads
        return [(POINTS * share).astype(np.uint8) for share in visible_shares(lights, lux, *view)]

    def _look_up(self, lights: list[DirectLight], surfaces: Surfaces, cells: I32) -> list[NDArray[np.uint8]]:
        """The same by what is known of the cells."""
        caches = [self._shadows[light.name] for light in lights]
        return visible_points(lights, caches, cells, surfaces, self._caster, self._threads)

    def _emission(self, gbuffer: GBuffer, diffuse: F32) -> None:
        """Add what shines into the camera by itself: luminous spheres and the sky."""
        triangle, eye = gbuffer.triangle.reshape(-1), gbuffer.view.origin
        upwards = gbuffer.view.directions.reshape(-1, 3)[:, 2] > HORIZON_Z
        sky = np.flatnonzero((triangle == NOTHING) & upwards)
        bulb = np.where(triangle == NOTHING, NOTHING, self._mesh.bulb.take(triangle, mode="clip"))
        lamps = np.flatnonzero(bulb != NOTHING)
        for lights, picture in zip(self._layers, diffuse, strict=True):
            picture[sky] += _sky(lights)
            for light in lights:
                if isinstance(light, BulbLight):
                    picture[lamps[bulb[lamps] == light.index]] += light.luminance(eye)


def _sky(lights: list[UnitLight]) -> float:
    return sum(light.luminance for light in lights if isinstance(light, SkyLight))


def _by_vertex(layers: F32 | list[F32]) -> F32:
    """(v, 3 L) float32 from (L, v, 3): all that one vertex has lies together."""
    stacked = np.stack(list(layers), axis=1)
    return np.ascontiguousarray(stacked.reshape(len(stacked), -1), dtype=np.float32)
