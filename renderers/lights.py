"""The scene's lights at unit intensity: 1 lux of sun, 1 lux of sky, 1 lumen per bulb."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol, runtime_checkable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.gbuffer import F32, I64
from scenes.model import Scene
from scenes.photometry import ISOTROPIC, Photometry

F64 = NDArray[np.float64]

OFFSET_M = 2e-3
"""Rays start this far off the surface, so that they do not hit it again."""

SUN_RADIUS = 0.00465
"""Angular radius of the sun's disc at one astronomical unit, rad (959.63″, IAU 1976)."""

CLEARANCE = 1.05
"""Shadow rays end this many radii before a bulb's centre: its sphere does not shade its own light."""


class UnitLight(Protocol):
    """A light of a layer, direct or sky."""

    @property
    def name(self) -> str:
        """For messages."""


@runtime_checkable
class DirectLight(UnitLight, Protocol):
    """A light seen as a small disc from each point: it casts shadows and has a GGX highlight."""

    def misses(self, centres: F64, radii: F64) -> NDArray[np.bool_]:
        """(k,) bool: balls, (k, 3) and (k,) metres, that surely get no light, whatever their normals."""

    def arriving(self, points: F32, normals: F32) -> tuple[F32, F32, F32]:
        """Light at surface points at unit intensity, as if nothing stood in its way.

        Parameters
        ----------
        points, normals : (n, 3) float32

        Returns
        -------
        to_light : (n, 3) float32, unit vectors to the light's centre
        illuminance : (n,) float32
            On a plane facing the light, lux; 0 on surfaces turned away.
        spread : (n,) float32
            Radius of the light's disc over its distance.
        """

    @property
    def far(self) -> float:
        """Where shadow rays end, in units of their directions' length."""

    def shadow_rays(self, points: F32, normals: F32, which: I64, disc: F32, first: I64, rays: F32) -> None:
        """Write down rays from surface points to points of the light's disc.

        Parameters
        ----------
        points, normals : (n, 3) float32
        which : (m,) int64
            Index of the point that rays start at.
        disc : (d, 2) float32
            Points on the unit disc.
        first : (m,) int64
            Index of the one that the first of them goes to; the next to the next, and so round.
        rays : (m, k, 6) float32, origin and direction; written
        """


@dataclass(frozen=True)
class SunLight:
    """1 lux from a disc of `SUN_RADIUS`; ``direction`` points to the sun."""

    name: str
    direction: tuple[float, float, float]

    @property
    def far(self) -> float:
        """See `DirectLight.far`."""
        return np.inf

    def misses(self, centres: F64, radii: F64) -> NDArray[np.bool_]:
        """See `DirectLight.misses`."""
        return np.full(len(radii), self.direction[2] <= 0)

    def arriving(self, points: F32, normals: F32) -> tuple[F32, F32, F32]:
        """See `DirectLight.arriving`. A sun below the horizon gives nothing."""
        return _towards_sun(normals, np.array(self.direction, dtype=np.float32))

    def shadow_rays(self, points: F32, normals: F32, which: I64, disc: F32, first: I64, rays: F32) -> None:
        """See `DirectLight.shadow_rays`."""
        _rays_to_sun(points, normals, which, disc, first, *self.direction, rays)


@dataclass(frozen=True)
class BulbLight:
    """1 lumen from a luminous sphere; an even one gives 1/4π candela in every direction."""

    name: str
    index: int
    position: tuple[float, float, float]
    radius: float
    aim: tuple[float, float, float] = (0.0, 0.0, -1.0)
    photometry: Photometry = ISOTROPIC

    @property
    def far(self) -> float:
        """See `DirectLight.far`."""
        return 1.0

    def luminance(self, eye: F32) -> float:
        """Of the sphere as seen from a point, cd/m² per lumen: I / (π r²), evenly over its disc."""
        x, y, z = (eye - np.asarray(self.position, dtype=np.float32)).astype(np.float64)
        table = self.photometry
        candela = _candela(
            x, y, z, _frame(self.aim), table.vertical, table.horizontal, table.candela_per_lumen
        )
        return float(candela / (np.pi * self.radius**2))

    def misses(self, centres: F64, radii: F64) -> NDArray[np.bool_]:
        """See `DirectLight.misses`: balls wholly outside the cone that a spot shines into."""
        widest = np.radians(self.photometry.vertical[-1])
        if self.photometry.candela_per_lumen.size == 1 or widest >= np.pi / 2:
            return np.zeros(len(radii), dtype=bool)
        offset, axis = centres - np.asarray(self.position), _frame(self.aim)[2]
        along = offset @ axis
        aside = np.linalg.norm(offset - along[:, None] * axis, axis=1)
        return np.asarray(aside * np.cos(widest) - along * np.sin(widest) > radii)

    def arriving(self, points: F32, normals: F32) -> tuple[F32, F32, F32]:
        """See `DirectLight.arriving`: E = I / d², which is exact for a sphere too."""
        table = self.photometry
        return _towards(
            points,
            normals,
            *self.position,
            self.radius,
            _frame(self.aim),
            table.vertical,
            table.horizontal,
            table.candela_per_lumen,
        )

    def shadow_rays(self, points: F32, normals: F32, which: I64, disc: F32, first: I64, rays: F32) -> None:
        """See `DirectLight.shadow_rays`."""
        _rays_to_bulb(points, normals, which, disc, first, *self.position, self.radius, rays)


HORIZON_Z = -0.02
"""Rays that leave the scene above this slope see the sky: a scene's ground ends before its horizon."""


@dataclass(frozen=True)
class SkyLight:
    """A uniform dome that gives 1 lux on open ground."""

    name: str
    luminance: float = 1 / np.pi


def bounding_balls(points: F32, block: int) -> tuple[F64, F64]:
    """Centres (k, 3) and radii (k,) of balls about each ``block`` successive points of (n, 3), metres."""
    starts = np.arange(0, len(points), block)
    low = np.minimum.reduceat(points, starts).astype(np.float64)
    high = np.maximum.reduceat(points, starts).astype(np.float64)
    return 0.5 * (low + high), 0.5 * np.linalg.norm(high - low, axis=1) + 1e-3  # float32 rounds up to 1e-5


def unit_lights(scene: Scene) -> dict[str, list[UnitLight]]:
    """The scene's lights by layer: each sun, the sky, and each group of bulbs."""
    layers: dict[str, list[UnitLight]] = {}
    for sun in scene.suns:
        x, y, z = (float(v) for v in sun.direction)
        layers[sun.name] = [SunLight(sun.name, (x, y, z))]
    layers[scene.sky.name] = [SkyLight(scene.sky.name)]
    for k, bulb in enumerate(scene.bulbs):
        layers.setdefault(bulb.group, []).append(
            BulbLight(f"{bulb.group} {k}", k, bulb.position, bulb.radius, bulb.aim, bulb.photometry)
        )
    return layers


@lru_cache(maxsize=64)
def _frame(aim: tuple[float, float, float]) -> F64:
    """(3, 3): rows are the luminaire's 0° and 90° half-planes and its axis, in the world.

    A luminaire that looks down has its 0° half-plane along +x.
    """
    axis = np.asarray(aim, dtype=np.float64)
    axis = axis / np.linalg.norm(axis)
    helper = np.array([1.0, 0.0, 0.0]) if abs(axis[0]) < 0.9 else np.array([0.0, 0.0, 1.0])
    zero = helper - (helper @ axis) * axis
    zero /= np.linalg.norm(zero)
    frame = np.stack([zero, np.cross(axis, zero), axis])
    frame.setflags(write=False)
    return frame


@njit(cache=True, nogil=True)
def _towards_sun(normals: F32, direction: F32) -> tuple[F32, F32, F32]:
    n = len(normals)
    to_light, lux = np.empty((n, 3), dtype=np.float32), np.zeros(n, dtype=np.float32)
    x, y, z = direction
    for i in range(n):
        to_light[i, 0], to_light[i, 1], to_light[i, 2] = x, y, z
        if z > 0 and normals[i, 0] * x + normals[i, 1] * y + normals[i, 2] * z > 0:
            lux[i] = 1.0
    return to_light, lux, np.full(n, np.float32(SUN_RADIUS))


@njit(cache=True)
def _place(values: F64, value: float) -> tuple[int, float]:
    """The interval of ascending values that holds a value, and where in it; clamped at the ends."""
    k = min(max(int(np.searchsorted(values, value)) - 1, 0), len(values) - 2)
    return k, min(max((value - values[k]) / (values[k + 1] - values[k]), 0.0), 1.0)


@njit(cache=True)
def _candela(x: float, y: float, z: float, frame: F64, vertical: F64, horizontal: F64, table: F64) -> float:
    """Intensity in a direction (of any length), interpolated bilinearly in angle."""
    if table.size == 1:
        return table[0, 0]
    length = max(np.sqrt(x * x + y * y + z * z), 1e-12)
    cosine = (frame[2, 0] * x + frame[2, 1] * y + frame[2, 2] * z) / length
    polar = np.degrees(np.arccos(min(max(cosine, -1.0), 1.0)))
    if polar > vertical[-1] or polar < vertical[0]:
        return 0.0
    i, s = _place(vertical, polar)
    if len(horizontal) == 1:
        return (1 - s) * table[0, i] + s * table[0, i + 1]
    a = frame[0, 0] * x + frame[0, 1] * y + frame[0, 2] * z
    b = frame[1, 0] * x + frame[1, 1] * y + frame[1, 2] * z
    j, t = _place(horizontal, np.degrees(np.arctan2(b, a)) % 360.0)
    near = (1 - s) * table[j, i] + s * table[j, i + 1]
    return (1 - t) * near + t * ((1 - s) * table[j + 1, i] + s * table[j + 1, i + 1])


@njit(cache=True, nogil=True)
def _towards(
    points: F32,
    normals: F32,
    x: float,
    y: float,
    z: float,
    radius: float,
    frame: F64,
    vertical: F64,
    horizontal: F64,
    table: F64,
) -> tuple[F32, F32, F32]:
    n = len(points)
    to_light, lux = np.empty((n, 3), dtype=np.float32), np.empty(n, dtype=np.float32)
    spread = np.empty(n, dtype=np.float32)
    bx, by, bz, br = np.float32(x), np.float32(y), np.float32(z), np.float32(radius)
    zero, one, tiny = np.float32(0), np.float32(1), np.float32(1e-6)
    even = np.float32(table[0, 0]) if table.size == 1 else one
    for i in range(n):  # in float32 and without calls, so that it runs on several pixels at once
        dx, dy, dz = bx - points[i, 0], by - points[i, 1], bz - points[i, 2]
        per_d = one / max(np.sqrt(dx * dx + dy * dy + dz * dz), tiny)
        to_light[i, 0], to_light[i, 1], to_light[i, 2] = dx * per_d, dy * per_d, dz * per_d
        spread[i] = br * per_d
        facing = normals[i, 0] * dx + normals[i, 1] * dy + normals[i, 2] * dz > zero
        lux[i] = even * per_d * per_d if facing else zero
    if table.size > 1:
        for i in range(n):
            if lux[i] > zero:
                fx, fy, fz = -to_light[i, 0], -to_light[i, 1], -to_light[i, 2]
                lux[i] *= _candela(fx, fy, fz, frame, vertical, horizontal, table)
    return to_light, lux, spread


@njit(cache=True)
def tangents(x: float, y: float, z: float) -> tuple[float, float, float, float, float, float]:
    """Two unit vectors across a unit vector (Duff et al. 2017, Building an orthonormal basis, revisited)."""
    one = np.float32(1)  # leaves the arguments their precision
    sign = np.copysign(one, z)
    a = -one / (sign + z)
    b = x * y * a
    return one + sign * x * x * a, sign * b, -sign * x, b, sign + y * y * a, -y


@njit(cache=True)
def _around(number: int, count: int) -> int:
    """Modulo of less than twice the count, without the slow division."""
    return number if number < count else number - count


@njit(cache=True, nogil=True)
def _rays_to_bulb(
    points: F32,
    normals: F32,
    which: I64,
    disc: F32,
    first: I64,
    x: float,
    y: float,
    z: float,
    radius: float,
    rays: F32,
) -> None:
    """To the disc across the line of sight, stopped in front of the sphere."""
    cx, cy, cz, cr = np.float32(x), np.float32(y), np.float32(z), np.float32(radius)
    zero, one, tiny = np.float32(0), np.float32(1), np.float32(1e-6)
    off, clear = np.float32(OFFSET_M), np.float32(CLEARANCE * radius)
    for k in range(len(which)):
        i = which[k]
        ox = points[i, 0] + off * normals[i, 0]
        oy = points[i, 1] + off * normals[i, 1]
        oz = points[i, 2] + off * normals[i, 2]
        dx, dy, dz = cx - ox, cy - oy, cz - oz
        per_d = one / max(np.sqrt(dx * dx + dy * dy + dz * dz), tiny)
        tx, ty, tz, bx, by, bz = tangents(dx * per_d, dy * per_d, dz * per_d)
        reach = max(one - clear * per_d, zero)
        for m in range(rays.shape[1]):
            number = _around(first[k] + m, len(disc))
            u, v = cr * disc[number, 0], cr * disc[number, 1]
            rays[k, m, 0], rays[k, m, 1], rays[k, m, 2] = ox, oy, oz
            rays[k, m, 3] = reach * (dx + u * tx + v * bx)
            rays[k, m, 4] = reach * (dy + u * ty + v * by)
            rays[k, m, 5] = reach * (dz + u * tz + v * bz)


@njit(cache=True, nogil=True)
def _rays_to_sun(
    points: F32, normals: F32, which: I64, disc: F32, first: I64, x: float, y: float, z: float, rays: F32
) -> None:
    tx, ty, tz, bx, by, bz = tangents(x, y, z)
    for k in range(len(which)):
        i = which[k]
        for m in range(rays.shape[1]):
            number = _around(first[k] + m, len(disc))
            u, v = SUN_RADIUS * disc[number, 0], SUN_RADIUS * disc[number, 1]
            for c in range(3):
                rays[k, m, c] = points[i, c] + OFFSET_M * normals[i, c]
            rays[k, m, 3], rays[k, m, 4] = x + u * tx + v * bx, y + u * ty + v * by
            rays[k, m, 5] = z + u * tz + v * bz
