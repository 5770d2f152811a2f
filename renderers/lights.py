"""The scene's lights at unit intensity: 1 lux of sun, 1 lux of sky, 1 lumen per bulb."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numba import njit

from renderers.gbuffer import F32, I64
from renderers.mesh import RayCaster
from scenes.model import Scene


class UnitLight(Protocol):
    """A light of a layer, direct or sky."""

    @property
    def name(self) -> str:
        """For messages."""


@runtime_checkable
class DirectLight(UnitLight, Protocol):
    """A light with one direction at each point: it casts shadows and has a GGX highlight."""

    def arriving(self, points: F32, normals: F32, caster: RayCaster) -> tuple[F32, F32]:
        """Light at surface points at unit intensity.

        Parameters
        ----------
        points, normals : (n, 3) float32
            Points just off the surfaces, so that they do not shadow themselves.

        Returns
        -------
        to_light : (n, 3) float32, unit vectors
        illuminance : (n,) float32
            On a plane facing the light, lux; 0 in shadow and on surfaces turned away.
        """


@dataclass(frozen=True)
class SunLight:
    """Parallel light of 1 lux; ``direction`` points to the sun."""

    name: str
    direction: tuple[float, float, float]

    def arriving(self, points: F32, normals: F32, caster: RayCaster) -> tuple[F32, F32]:
        """See `DirectLight.arriving`. A sun below the horizon gives nothing."""
        direction = np.array(self.direction, dtype=np.float32)
        to_light = np.ascontiguousarray(np.broadcast_to(direction, points.shape))
        lux = np.zeros(len(points), dtype=np.float32)
        if direction[2] > 0:
            facing = np.flatnonzero(normals @ direction > 0)
            lux[facing] = ~caster.occluded(points[facing], to_light[facing])
        return to_light, lux


@dataclass(frozen=True)
class BulbLight:
    """1 lumen from a point: 1/4π candela in every direction. Its sphere does not shade its own light."""

    name: str
    index: int
    position: tuple[float, float, float]
    radius: float

    @property
    def luminance(self) -> float:
        """Of the sphere, cd/m² per lumen: I / (π r²)."""
        return 1.0 / (4 * np.pi) / (np.pi * self.radius**2)

    def arriving(self, points: F32, normals: F32, caster: RayCaster) -> tuple[F32, F32]:
        """See `DirectLight.arriving`: E = I / d²."""
        to_light, lux, facing, rays = _towards(points, normals, *self.position, 1.05 * self.radius)
        lux[facing] *= ~caster.any_hit(rays, far=1.0)
        return to_light, lux


HORIZON_Z = -0.02
"""Rays that leave the scene above this slope see the sky: a scene's ground ends before its horizon."""


@dataclass(frozen=True)
class SkyLight:
    """A uniform dome that gives 1 lux on open ground."""

    name: str
    luminance: float = 1 / np.pi


def unit_lights(scene: Scene) -> dict[str, list[UnitLight]]:
    """The scene's lights by layer: the sun, the sky, and each group of bulbs."""
    sun = tuple(float(v) for v in scene.sun.direction)
    layers: dict[str, list[UnitLight]] = {
        scene.sun.name: [SunLight(scene.sun.name, (sun[0], sun[1], sun[2]))],
        scene.sky.name: [SkyLight(scene.sky.name)],
    }
    for k, bulb in enumerate(scene.bulbs):
        layers.setdefault(bulb.group, []).append(
            BulbLight(f"{bulb.group} {k}", k, bulb.position, bulb.radius)
        )
    return layers


@njit(cache=True)
def _towards(
    points: F32, normals: F32, x: float, y: float, z: float, clearance: float
) -> tuple[F32, F32, I64, F32]:
    """Directions to a point of 1/4π cd, its unshadowed illuminance, shadow rays of the points facing it."""
    n = len(points)
    to_light, lux = np.empty((n, 3), dtype=np.float32), np.zeros(n, dtype=np.float32)
    facing, rays = np.empty(n, dtype=np.int64), np.empty((n, 6), dtype=np.float32)
    count = 0
    for i in range(n):
        dx, dy, dz = x - points[i, 0], y - points[i, 1], z - points[i, 2]
        d = max(np.sqrt(dx * dx + dy * dy + dz * dz), 1e-6)
        to_light[i, 0], to_light[i, 1], to_light[i, 2] = dx / d, dy / d, dz / d
        if normals[i, 0] * dx + normals[i, 1] * dy + normals[i, 2] * dz > 0:
            lux[i] = 1 / (4 * np.pi * d * d)
            reach = max(d - clearance, 0.0) / d
            rays[count, 0], rays[count, 1], rays[count, 2] = points[i, 0], points[i, 1], points[i, 2]
            rays[count, 3], rays[count, 4], rays[count, 5] = dx * reach, dy * reach, dz * reach
            facing[count] = i
            count += 1
    return to_light, lux, facing[:count], rays[:count]
