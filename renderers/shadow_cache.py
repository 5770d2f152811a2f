"""Which parts of a scene's surfaces a light reaches: found once, as neither of them moves.

A ray from each corner of the surfaces' cells (`renderers.surface_cells`), to the disc's points in turn, tells
a cell whose own corners and the next ones all agree: it is taken to be lit, or dark, by every point of the
disc. In the other cells lies a shadow's border: pixels that show them cast rays of their own, as all do
without a cache (`renderers.shadows`). What throws a shadow narrower than the corners lie apart is missed.
Cells are told when they are first seen, by geometry alone, so a picture does not depend on those before it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.gbuffer import F32, I32, I64
from renderers.lights import DirectLight
from renderers.mesh import NOTHING, RayCaster
from renderers.shadows import PATTERN, POINTS, free_rays, interleaved
from renderers.surface_cells import CellGrid
from renderers.surfaces import Surfaces
from renderers.threads import ALONE, Threads

U8 = NDArray[np.uint8]

FAINT = 0.05
"""A light that brings less than this share of a point's light needs no smooth shadow."""

RIM = 5
"""Points at the rim of a light's disc, the last of its spiral: a straight shadow that divides none of
them from the others cuts off less than a tenth of the disc."""

COARSE = 2
"""Cells along each side of a square whose corners' rays are cast first; a triangle where they agree,
and agree with its neighbours', is done."""

REACH_PX = 2
"""Pixels about a pixel whose rays are compared; they hold all points of the disc."""

UNTOLD, AWAY, DARK, LIT, BORDER = range(5)
"""What is known of a cell: nothing yet; the light is behind it; no ray arrives; all do; not all do."""


class ShadowCache:
    """What is known of one light's shadows.

    Attributes
    ----------
    told : (cells,) uint8
        `UNTOLD`, `AWAY`, `DARK`, `LIT` or `BORDER`.
    """

    def __init__(self, grid: CellGrid, light: DirectLight, caster: RayCaster, threads: Threads) -> None:
        self._grid, self._light, self._caster, self._threads = grid, light, caster, threads
        self.told: U8 = np.full(grid.count, UNTOLD, dtype=np.uint8)
        self._unseen = grid.side > 0
        self._alike: U8 = np.full(len(grid.side), UNTOLD, dtype=np.uint8)  # of triangles, by a few rays

    def tell(self, seen: NDArray[np.bool_]) -> None:
        """Cast rays for the triangles that were not seen before, (m,) bool of all."""
        fresh = np.flatnonzero(seen & self._unseen)
        if not len(fresh):
            return
        self._unseen[fresh] = False
        grid = self._grid
        about = grid.neighbours[fresh]
        wanted = np.unique(about.indices)
        wanted = wanted[self._alike[wanted] == UNTOLD]
        self._alike[wanted] = _alike(*self._probe(wanted, -(-grid.side[wanted] // COARSE)))
        same = _same_about(self._alike, fresh, about.indptr, about.indices)
        alike, others = fresh[same], fresh[~same]
        _fill(grid.first[alike], grid.side[alike], self._alike[alike], self.told)
        free, start = self._probe(others, grid.side[others], beyond=1)
        _judge(free, start, grid.side[others], grid.first[others], self.told)

    def _probe(self, triangles: I64, side: I32, beyond: int = 0) -> tuple[U8, I64]:
        """What is so at the corners of triangles' cells, and each triangle's first of them."""
        grid = self._grid
        points, place, start = grid.corners(triangles, side, beyond)
        number = PATTERN[place[:, 0] % 4, place[:, 1] % 4]
        normals = np.repeat(grid.mesh.normals[triangles], np.diff(start), axis=0)
        at = np.full(len(points), AWAY, dtype=np.uint8)
        facing = np.flatnonzero(self._light.arriving(points, normals)[1])
        rays = points, normals, facing, number[facing], 1, self._caster, self._threads
        at[facing] = np.where(free_rays(self._light, *rays) > 0, LIT, DARK)
        return at, start


def visible_points(
    lights: Sequence[DirectLight],
    caches: Sequence[ShadowCache],
    cells: I32,
    surfaces: Surfaces,
    caster: RayCaster,
    threads: Threads = ALONE,
) -> list[U8]:
    """How many points of each light's disc a picture's points see, rays cast where no cache can tell.

    As `renderers.shadows.visible_shares`, but that a light which brings little keeps its first ray sooner,
    and that where the first ray and those to the rim agree the rest are taken to be the same.

    Parameters
    ----------
    caches : one for each light
        That were told of the picture's triangles.
    cells : (H·W,) int32
        Of the picture's points.

    Returns
    -------
    one (H·W,) uint8 for each light, 0…`POINTS`
    """
    number, points, normals = interleaved(surfaces.shape), surfaces.points, surfaces.untilted
    states, borders, lux = [], [], []
    for light, cache in zip(lights, caches, strict=True):
        state, border = np.empty(len(cells), dtype=np.uint8), np.empty(len(cells), dtype=np.int64)
        border = border[: _look_up(cells, cache.told, state, border)]
        brought = light.arriving(points[border], surfaces.normal[border])[1]
        state[border] = AWAY
        border, brought = border[brought > 0], brought[brought > 0]
        free = free_rays(light, points, normals, border, number[border], 1, caster, threads)
        state[border] = np.where(free > 0, np.uint8(LIT), np.uint8(DARK))
        states.append(state)
        borders.append(border)
        lux.append(brought)
    arrived = _arrived(lights, states, borders, surfaces)
    for light, state, border, brought in zip(lights, states, borders, lux, strict=True):
        mixed = border[_disagree(border, state, brought, arrived, surfaces.shape)]
        lit = state[mixed] == LIT
        _count_points(state)
        rim = np.full(len(mixed), POINTS - RIM, dtype=np.int64)
        free = free_rays(light, points, normals, mixed, rim, RIM, caster, threads)
        cut = free != RIM * lit
        mixed, rest = mixed[cut], np.zeros(np.count_nonzero(cut), dtype=np.int64)
        free = free[cut] + free_rays(light, points, normals, mixed, rest, POINTS - RIM, caster, threads)
        state[mixed] = free
    return states


def _arrived(
    lights: Sequence[DirectLight], states: Sequence[U8], borders: Sequence[I64], surfaces: Surfaces
) -> F32:
    """(H·W,) float32: lux of all lights together, as far as is known, at the pixels on any light's border."""
    total = np.zeros(len(surfaces.surface), dtype=np.float32)
    some = np.zeros(len(total), dtype=bool)
    for border in borders:
        some[border] = True
    where = np.flatnonzero(some)
    points, normals = surfaces.points[where], surfaces.normal[where]
    for light, state in zip(lights, states, strict=True):
        lit = state[where] == LIT
        if lit.any():
            total[where] += lit * light.arriving(points, normals)[1]
    return total


def lit_shares(
    light: DirectLight,
    cache: ShadowCache,
    cells: I32,
    points: F32,
    normals: F32,
    which: I64,
    caster: RayCaster,
    threads: Threads = ALONE,
) -> F32:
    """As `renderers.shadows.lit_share`, with rays only where the cache cannot tell; (m,) cells of points."""
    told = np.full(len(cells), BORDER, dtype=np.uint8)
    within = cells != NOTHING
    told[within] = cache.told[cells[within]]
    share = (told == LIT).astype(np.float32)
    border = np.flatnonzero((told != LIT) & (told != DARK))
    share[border] = free_rays(light, points, normals, which[border], border % POINTS, 1, caster, threads)
    return share


@njit(cache=True)
def _alike(free: U8, start: I64) -> U8:
    """What all corners of each triangle are, `BORDER` where they differ."""
    alike = np.empty(len(start) - 1, dtype=np.uint8)
    for t in range(len(alike)):
        alike[t] = free[start[t]]
        for k in range(start[t], start[t + 1]):
            if free[k] != alike[t]:
                alike[t] = BORDER
    return alike


@njit(cache=True)
def _same_about(alike: U8, triangles: I64, first: I32, neighbours: I32) -> NDArray[np.bool_]:
    """Whether all neighbours of each of some triangles are as it is, and no border runs through any."""
    same = np.empty(len(triangles), dtype=np.bool_)
    for t in range(len(triangles)):
        own = alike[triangles[t]]
        same[t] = own != BORDER
        for k in range(first[t], first[t + 1]):
            same[t] &= alike[neighbours[k]] == own
    return same


@njit(cache=True)
def _fill(first: I32, side: I32, known: U8, told: U8) -> None:
    for t in range(len(first)):
        told[first[t] : first[t] + side[t] ** 2] = known[t]


@njit(cache=True)
def _judge(free: U8, start: I64, side: I32, first: I32, told: U8) -> None:
    """A cell is what its corners and those next to them are, beyond the triangle too, if they agree."""
    for t in range(len(side)):
        n = side[t]
        for j in range(n):
            for k in range(n):
                # the lower corner of the square that it is half of
                p, q = (j, k) if j + k < n else (n - 1 - j, n - 1 - k)
                all_of, any_of = 255, 0
                for row in range(p, p + 4):  # there is a row before the triangle's first
                    begin = start[t] + row * (n + 4) - row * (row - 1) // 2
                    for column in range(q, min(q + 3, n + 3 - row) + 1):
                        all_of &= free[begin + column]
                        any_of |= free[begin + column]
                told[first[t] + j * n + k] = all_of if all_of == any_of else BORDER


@njit(cache=True, nogil=True)
def _look_up(cells: I32, told: U8, state: U8, border: I64) -> int:
    """Write down what is known of each pixel, and give how many are unknown; those go to ``border``."""
    count = 0
    for i in range(len(cells)):
        state[i] = BORDER if cells[i] < 0 else told[cells[i]]
        border[count] = i
        count += state[i] == BORDER
    return count


@njit(cache=True, nogil=True)
def _disagree(border: I64, state: U8, lux: F32, arrived: F32, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Whether some rays arrive and some do not about a pixel to which the light matters."""
    height, width = shape
    mixed = np.zeros(len(border), dtype=np.bool_)
    for k in range(len(border)):
        i = border[k]
        if lux[k] <= np.float32(FAINT) * arrived[i]:
            continue
        y, x = i // width, i % width
        lit = dark = False
        for row in range(max(y - REACH_PX, 0), min(y + REACH_PX, height - 1) + 1):
            for at in range(
                row * width + max(x - REACH_PX, 0), row * width + min(x + REACH_PX, width - 1) + 1
            ):
                lit |= state[at] == LIT
                dark |= state[at] == DARK
        mixed[k] = lit and dark
    return mixed


@njit(cache=True, nogil=True)
def _count_points(state: U8) -> None:
    """Turn what is known into how many of the disc's points are seen."""
    for i in range(len(state)):
        state[i] = POINTS if state[i] == LIT else 0
