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
from renderers.camera import Camera, Mount, T_world_robot
from renderers.engine import make_engine
from renderers.errors import RendererError
from renderers.gbuffer import F32, I32, GBuffer, View, fill
from renderers.irradiance import FULL_QUALITY, BakeQuality
from renderers.irradiance_cache import load_or_bake
from renderers.layers import LayerShader
from renderers.lights import unit_lights
from renderers.mesh import RayCaster, build_mesh
from renderers.motion_blur import mirror_depth
from renderers.surfaces import Surfaces
from renderers.threads import Threads
from scenes.model import Scene


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
    mirror_depth : (H, W) float32
        Where asked for, depth of what glossy pixels mirror, whose image lies behind the surface, inf for the
        sky; elsewhere ``depth``.
    """

    layers: tuple[str, ...]
    diffuse: F32
    specular: F32
    depth: F32
    surface: I32
    landmark: I32
    visible_share: F32
    mirror_depth: F32

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
        For ray casting and shading, 0 for all cores; the result is the same for any number.
    cache : Path, optional
        Folder where baked light is kept between runs.
    quality : BakeQuality
        How much work goes into baked light; less for previews and tests.
    mirrored : bool
        Whether bases tell the depth of what is mirrored, which motion blur needs.
    cached_shadows : bool
        Whether what lights reach is told once and kept, for a robot that waits for its pictures
        (`renderers.shadow_cache`).
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
        mirrored: bool = False,
        cached_shadows: bool = False,
    ) -> None:
        if supersampling < 1:
            raise RendererError(f"supersampling {supersampling}: must be at least 1")
        self.scene, self._camera, self._mount = scene, camera, mount
        self._factor, self._threads = supersampling, Threads(threads)
        self._mirrored = mirrored
        self._mesh = build_mesh(scene)
        self._caster = RayCaster(self._mesh.vertices, self._mesh.triangles, threads)
        self._lights = unit_lights(scene)
        self._discs = paint.Discs.of(scene)
        self._samples = paint.disc_samples(self._discs)
        layers = list(self._lights.values())
        irradiance = load_or_bake(self._mesh, self._caster, layers, cache, quality)
        self._shader = LayerShader(
            self._mesh,
            self._caster,
            layers,
            irradiance,
            quality.bounces >= 0,
            self._threads,
            supersampling,
            cached_shadows,
        )
        self._engine = make_engine(engine, self._mesh, camera.enlarged(supersampling), self._caster)

    @property
    def layers(self) -> tuple[str, ...]:
        """Names of the light basis' layers, in order."""
        return tuple(self._lights)

    def render(self, pose: NDArray[np.float64]) -> LightBasis:
        """Render what the robot sees at a pose (x, y, θ), metres and rad."""
        T = T_world_robot(pose) @ self._mount.T_robot_camera
        gbuffer = fill(self._mesh, View(self._camera.enlarged(self._factor), T), self._engine, self._threads)
        surfaces = Surfaces.of(self._mesh, gbuffer, self._discs)
        diffuse, specular = self._shader.shade(gbuffer, surfaces)
        centre = (self._factor - 1) // 2
        pick = np.s_[centre :: self._factor, centre :: self._factor]
        depth = gbuffer.depth
        mirrored = mirror_depth(gbuffer, surfaces, self._caster) if self._mirrored else depth
        return LightBasis(
            layers=self.layers,
            diffuse=_average(diffuse, self._factor),
            specular=_average(specular, self._factor),
            depth=np.ascontiguousarray(depth[pick]),
            surface=np.ascontiguousarray(gbuffer.surface[pick]),
            landmark=np.ascontiguousarray(surfaces.landmark[pick]),
            visible_share=self._visible_share(gbuffer),
            mirror_depth=np.ascontiguousarray(mirrored[pick]),
        )

    def close(self) -> None:
        """Give back what the engine holds outside of Python, and end the threads."""
        self._engine.close()
        self._threads.close()

    def _visible_share(self, gbuffer: GBuffer) -> F32:
        eye = gbuffer.view.origin
        offset = (self._samples - eye) * np.float32(1 - 1e-3)
        occluded = self._caster.occluded(eye, offset, far=1.0)
        return paint.visible_share(gbuffer, self._discs, occluded, self._samples)


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
