"""The light basis: each layer of light by itself at unit intensity, split into diffuse and specular.

Light is additive, L = Σ_l w_l (D_l + S_l), so a view is rendered once and every illumination after that is a
weighted sum. The split is exact: the two parts leave the BRDF apart and are never estimated from a picture.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers import paint
from renderers.appearance import at_pixels, materials_at
from renderers.camera import Camera, Mount, T_world_robot
from renderers.engine import make_engine
from renderers.errors import RendererError
from renderers.gbuffer import F32, I32, GBuffer, View, fill, interpolate
from renderers.irradiance import FULL_QUALITY, BakeQuality, diffuse_albedo
from renderers.irradiance_cache import load_or_bake
from renderers.lights import HORIZON_Z, BulbLight, DirectLight, SkyLight, SunLight, UnitLight, unit_lights
from renderers.lobe_albedo import albedo_table
from renderers.mesh import NOTHING, RayCaster, SceneMesh, build_mesh
from renderers.reflection import Reflection
from renderers.shade import shade_ambient, shade_light
from renderers.shadows import lit_share, visible_shares
from scenes.model import Scene

MIRRORED_FOOTPRINT_M = 0.02
"""What a mirrored ray sees of a texture: about a pixel of 8 mrad after 2.5 m."""


@dataclass(frozen=True, eq=False)
class LightBasis:
    """One view under each layer of light at unit intensity.

    Attributes
    ----------
    layers : tuple of str
        "sun" (per lux), "sky" (per lux), each bulb group (per lumen and bulb).
    diffuse, specular : (L, H, W, 3) float32
        Luminance per channel, cd/m² per unit; lamps and sky seen directly count as diffuse.
    depth : (H, W) float32
        z in the camera frame, metres; 0 where the sky is seen.
    surface, landmark : (H, W) int32
        Surface index and landmark id, −1 for none.
    visible_share : (n,) float32
        Of each landmark of the scene, in its order: the share of its area in view and unoccluded.
    """

    layers: tuple[str, ...]
    diffuse: F32
    specular: F32
    depth: F32
    surface: I32
    landmark: I32
    visible_share: F32

    @cached_property
    def mean_diffuse(self) -> NDArray[np.float64]:
        """(L,) float64: mean of each layer's diffuse part, taken once for all illuminations."""
        return np.array([layer.mean() for layer in self.diffuse], dtype=np.float64)


class SceneRenderer:
    """Renders light bases of one scene through one camera.

    Parameters
    ----------
    engine : str
        "rasterise" or "raycast": what finds the visible surfaces.
    supersampling : int
        Rays along each side of a pixel; the layers are averaged in linear light, ids and depth are those of
        the sample in the pixel's centre (of an even number, the one up and left of it).
    threads : int
        For the ray caster, 0 for all cores.
    cache : Path, optional
        Folder where baked light is kept between runs.
    quality : BakeQuality
        How much work goes into baked light; less for previews and tests.
    """

    def __init__(
        self,
        scene: Scene,
        camera: Camera,
        mount: Mount,
        engine: str = "raycast",
        supersampling: int = 1,
        threads: int = 0,
        cache: Path | None = None,
        quality: BakeQuality = FULL_QUALITY,
    ) -> None:
        if supersampling < 1:
            raise RendererError(f"supersampling {supersampling}: must be at least 1")
        self.scene, self._camera, self._mount = scene, camera, mount
        self._factor, self._bounces = supersampling, quality.bounces >= 0
        self._mesh = build_mesh(scene)
        self._caster = RayCaster(self._mesh.vertices, self._mesh.triangles, threads)
        self._lights = unit_lights(scene)
        self._discs = paint.Discs.of(scene)
        self._samples = paint.disc_samples(self._discs)
        self._irradiance = load_or_bake(self._mesh, self._caster, list(self._lights.values()), cache, quality)
        self._engine = make_engine(engine, self._mesh, camera.enlarged(supersampling), self._caster)

    @property
    def layers(self) -> tuple[str, ...]:
        """Names of the light basis' layers, in order."""
        return tuple(self._lights)

    def render(self, pose: NDArray[np.float64]) -> LightBasis:
        """Render what the robot sees at a pose (x, y, θ), metres and rad."""
        T = T_world_robot(pose) @ self._mount.T_robot_camera
        gbuffer = fill(self._mesh, View(self._camera.enlarged(self._factor), T), self._engine)
        shading = _Shading(self._mesh, gbuffer, self._discs)
        diffuse, specular = zip(
            *(self._layer(shading, k, lights) for k, lights in enumerate(self._lights.values())), strict=True
        )
        centre = (self._factor - 1) // 2
        pick = np.s_[centre :: self._factor, centre :: self._factor]
        return LightBasis(
            layers=self.layers,
            diffuse=_average(np.stack(diffuse), self._factor),
            specular=_average(np.stack(specular), self._factor),
            depth=np.ascontiguousarray(gbuffer.depth[pick]),
            surface=np.ascontiguousarray(gbuffer.surface[pick]),
            landmark=np.ascontiguousarray(shading.landmark[pick]),
            visible_share=self._visible_share(gbuffer),
        )

    def close(self) -> None:
        """Give back what the engine holds outside of Python."""
        self._engine.close()

    def _layer(self, shading: _Shading, index: int, lights: list[UnitLight]) -> tuple[F32, F32]:
        diffuse = np.zeros((len(shading.seen), 3), dtype=np.float32)
        specular = np.zeros_like(diffuse)
        direct = [light for light in lights if isinstance(light, DirectLight)]
        arriving = [light.arriving(shading.points, shading.normal) for light in direct]
        shares = shading.visible_shares(direct, [lux for _, lux, _ in arriving], self._caster)
        for (to_light, lux, spread), share in zip(arriving, shares, strict=True):
            shade_light(
                shading.normal,
                shading.to_eye,
                to_light,
                lux * share,
                spread,
                *shading.material,
                diffuse,
                specular,
            )
        ambient = shading.interpolate(self._irradiance.indirect[index])
        mirrored = self._mirrored(shading, index, lights, ambient)
        shade_ambient(
            shading.normal,
            shading.to_eye,
            ambient,
            mirrored,
            albedo_table(),
            *shading.material,
            diffuse,
            specular,
        )
        shape = (*shading.gbuffer.surface.shape, 3)
        pictures = np.zeros((2, *shape), dtype=np.float32).reshape(2, -1, 3)
        pictures[0, shading.seen], pictures[1, shading.seen] = diffuse, specular
        _add_emission(pictures[0], shading.gbuffer, self._mesh, lights)
        return pictures[0].reshape(shape), pictures[1].reshape(shape)

    def _mirrored(self, shading: _Shading, index: int, lights: list[UnitLight], ambient: F32) -> F32:
        """Mean luminance that each pixel's lobe gathers, (n, 3) cd/m² per unit.

        A rough surface gathers the mean of its hemisphere, E / π; a glossy one what mirrored rays find.
        Bulbs are left out of the rays: their image is the highlight of `shade_light`.
        """
        reflection = shading.reflection(self._mesh, self._caster)
        rays = np.zeros((reflection.rays, 3), dtype=np.float32)
        sky = sum(light.luminance for light in lights if isinstance(light, SkyLight))
        rays[reflection.sky] = sky
        sunny = [light for light in lights if isinstance(light, SunLight)]
        baked = self._irradiance.indirect if sunny else self._irradiance.total
        lux = interpolate(baked[index], self._mesh.triangles[reflection.triangle], reflection.weights)
        for light in sunny:  # its patches have sharp edges
            lux += self._sunlit(light, reflection)[:, None]
        if self._bounces:
            rays[reflection.hit] = shading.mirrored_albedo(self._mesh, reflection) * lux / np.pi
        gathered = ambient * np.float32(1 / np.pi)
        gathered[reflection.glossy] = reflection.blurred(rays)
        return gathered

    def _sunlit(self, light: SunLight, reflection: Reflection) -> F32:
        """(h,) lux of the sun where the mirrored rays end."""
        to_light, lux, _ = light.arriving(reflection.points, reflection.normals)
        lit = np.flatnonzero(lux)
        points, normals = reflection.points[lit], reflection.normals[lit]
        cosine = np.einsum("nk,nk->n", normals, to_light[lit])
        lux[lit] *= cosine * lit_share(light, points, normals, self._caster)
        return lux

    def _visible_share(self, gbuffer: GBuffer) -> F32:
        eye = gbuffer.view.origin
        offset = (self._samples - eye) * np.float32(1 - 1e-3)
        occluded = self._caster.occluded(eye, offset, far=1.0)
        return paint.visible_share(gbuffer, self._discs, occluded, self._samples)


class _Shading:
    """The pixels that show a surface, as columns for the shading kernels.

    Attributes
    ----------
    seen : (n,) int64
        Their flat index in the picture.
    normal, to_eye, points : (n, 3) float32
        The normal that is shaded with, tilted where a texture says so.
    material : base colour (n, 3) as painted, roughness, metallic, specular (n,) float32
    landmark : (H, W) int32
    """

    def __init__(self, mesh: SceneMesh, gbuffer: GBuffer, discs: paint.Discs) -> None:
        self.gbuffer = gbuffer
        self.seen = np.flatnonzero(gbuffer.triangle != NOTHING)
        triangle = gbuffer.triangle.reshape(-1)[self.seen]
        surface = mesh.surface[triangle]
        self._untilted = np.ascontiguousarray(gbuffer.normal.reshape(-1, 3)[self.seen])
        self.to_eye = np.ascontiguousarray(-gbuffer.view.directions.reshape(-1, 3)[self.seen])
        self.points = np.ascontiguousarray(gbuffer.position.reshape(-1, 3)[self.seen])
        self._surface = surface
        bary = gbuffer.barycentric.reshape(-1, 2)[self.seen]
        weights = np.column_stack([1 - bary.sum(axis=1), bary]).clip(min=0.0)  # no extrapolation past an edge
        self._weights = (weights / weights.sum(axis=1, keepdims=True)).astype(np.float32)
        self._corners = mesh.triangles[triangle]
        look = at_pixels(mesh, gbuffer, self.seen, self._weights)
        self.normal, table = look.normal, look.materials
        self._curved = mesh.curved[triangle] | look.tilted
        base_color = np.zeros((*gbuffer.surface.shape, 3), dtype=np.float32)
        base_color.reshape(-1, 3)[self.seen] = table.base_color
        self.landmark = paint.paint(gbuffer, discs, base_color)
        self.roughness = table.roughness
        self.material = (
            base_color.reshape(-1, 3)[self.seen],
            self.roughness,
            table.metallic,
            table.specular,
        )
        self._reflection: Reflection | None = None
        self._mirrored_albedo: F32 | None = None

    def interpolate(self, at_vertices: F32) -> F32:
        """(n, 3) values at the pixels from values at the mesh's vertices."""
        return interpolate(at_vertices, self._corners, self._weights)

    def visible_shares(self, lights: list[DirectLight], lux: list[F32], caster: RayCaster) -> list[F32]:
        """(n,) share of each light's disc that each pixel's point sees."""
        shape = self.gbuffer.surface.shape
        return visible_shares(lights, lux, self.points, self._untilted, caster, self.seen, shape)

    def reflection(self, mesh: SceneMesh, caster: RayCaster) -> Reflection:
        """The mirrored rays of glossy pixels, cast once."""
        if self._reflection is None:
            self._reflection = Reflection(
                mesh,
                caster,
                self.points,
                self.normal,
                self.to_eye,
                self.roughness,
                self._surface,
                self._curved,
                self.seen,
                self.gbuffer.surface.shape,
                HORIZON_Z,
            )
        return self._reflection

    def mirrored_albedo(self, mesh: SceneMesh, reflection: Reflection) -> F32:
        """(h, 3) albedo of the surfaces that the mirrored rays hit, looked up once."""
        if self._mirrored_albedo is None:
            hit = materials_at(mesh, reflection.triangle, reflection.weights, MIRRORED_FOOTPRINT_M)
            self._mirrored_albedo = diffuse_albedo(hit)
        return self._mirrored_albedo


def _add_emission(picture: F32, gbuffer: GBuffer, mesh: SceneMesh, lights: list[UnitLight]) -> None:
    """What shines into the camera by itself: the layer's luminous spheres and its sky."""
    triangle = gbuffer.triangle.reshape(-1)
    bulb = np.where(triangle != NOTHING, mesh.bulb[triangle], NOTHING)
    for light in lights:
        if isinstance(light, SkyLight):
            upwards = gbuffer.view.directions.reshape(-1, 3)[:, 2] > HORIZON_Z
            picture[(triangle == NOTHING) & upwards] += light.luminance
        elif isinstance(light, BulbLight):
            picture[bulb == light.index] += light.luminance(gbuffer.view.origin)


def _average(layers: F32, factor: int) -> F32:
    """Box-average the (L, H·f, W·f, 3) samples of each pixel."""
    if factor == 1:
        return layers
    n, height, width, _ = layers.shape
    blocks = layers.reshape(n, height // factor, factor, width // factor, factor, 3)
    return np.ascontiguousarray(blocks.mean(axis=(2, 4), dtype=np.float32))


def relight(
    basis: LightBasis, intensity: Mapping[str, float], colour: Mapping[str, NDArray[np.float64]]
) -> tuple[F32, F32]:
    """Weight a basis into the diffuse and specular luminance of one illumination.

    Parameters
    ----------
    intensity : mapping of layer to float
        Lux of sun and sky, lumen of each bulb of a group.
    colour : mapping of layer to (3,) float64
        Linear sRGB of the light, luminance-normalised (`renderers.illuminant.linear_srgb`).

    Returns
    -------
    diffuse, specular : (H, W, 3) float32
        Luminance per channel, cd/m².

    Raises
    ------
    RendererError
        If a layer has no colour or no intensity, or one that is negative or not finite.
    """
    weights = np.empty((len(basis.layers), 3), dtype=np.float32)
    for k, layer in enumerate(basis.layers):
        value = intensity.get(layer, np.nan)
        if not (np.isfinite(value) and value >= 0):
            raise RendererError(f"illumination: layer {layer!r} needs a finite intensity ≥ 0, not {value}")
        if layer not in colour:
            raise RendererError(f"illumination: layer {layer!r} has no colour")
        weights[k] = value * colour[layer]
    return _weighted(basis.diffuse, weights), _weighted(basis.specular, weights)


def _weighted(layers: F32, weights: F32) -> F32:
    """(H, W, 3) sum of the (L, H, W, 3) layers, each channel by its (L, 3) weight."""
    count, height, width, _ = layers.shape
    total = _weighted_rows(layers.reshape(count, height, -1), np.tile(weights, (1, width)))
    return total.reshape(height, width, 3)


@njit(cache=True)
def _weighted_rows(layers: F32, weights: F32) -> F32:
    """Sum of (L, H, n) rows of values by (L, n) weights; a row of the sum stays in the fastest cache."""
    count, height, values = layers.shape
    total = np.zeros((height, values), dtype=np.float32)
    for r in range(height):
        row = total[r]
        for k in range(0, count - 1, 2):  # two layers at a time halve the passes over the sum
            a, b, weight_a, weight_b = layers[k, r], layers[k + 1, r], weights[k], weights[k + 1]
            for j in range(values):
                row[j] = row[j] + weight_a[j] * a[j] + weight_b[j] * b[j]
        if count % 2:
            last, weight = layers[count - 1, r], weights[count - 1]
            for j in range(values):
                row[j] += weight[j] * last[j]
    return total


def mean_white(
    basis: LightBasis, intensity: Mapping[str, float], colour: Mapping[str, NDArray[np.float64]]
) -> NDArray[np.float64]:
    """(3,) linear sRGB of the picture's light: the layers' colours, weighted by what each adds to the mean.

    What an ideal automatic white balance would find.
    """
    share = np.array([intensity[layer] for layer in basis.layers]) * basis.mean_diffuse
    if share.sum() == 0:
        return np.ones(3)
    colours = np.stack([colour[layer] for layer in basis.layers])
    return np.asarray(share @ colours / share.sum(), dtype=np.float64)
