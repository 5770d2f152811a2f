"""How much of a light's disc each point sees: soft shadows from shadow rays.

Every pixel casts one ray, to one of 16 points of the disc; neighbours take different points, so that any
4 × 4 pixels together try all 16 (interleaved sampling, Keller & Heidrich 2001). Where the rays of a
neighbourhood disagree, and only there, lies a penumbra: its pixels cast the other 15 rays as well.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, lru_cache

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.gbuffer import F32, I64
from renderers.lights import DirectLight
from renderers.mesh import NOTHING, RayCaster
from renderers.threads import ALONE, Threads

POINTS = 16
"""Of the disc that rays go to: a penumbra in steps of 1/16."""

NEIGHBOURHOOD = np.ones((5, 5), dtype=np.uint8)
"""The pixels about a pixel whose rays are compared; holds all 16 points of the disc."""

FAINT = 0.01
"""A light that brings less than this share of a point's light needs no smooth shadow."""

FAINT_OF_SPARSE = 0.05
"""The same where blocks of pixels share a ray."""

BLOCK_PX = 4
"""Side of the blocks of pixels that may share one first ray."""

PATTERN = np.array([[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]])
"""Bayer's ordered dither (1973): neighbours' numbers differ by much."""


@cache
def disc_points() -> F32:
    """(16, 2) float32: points of equal share on the unit disc along Vogel's spiral (1979)."""
    k = np.arange(POINTS)
    radius, angle = np.sqrt((k + 0.5) / POINTS), k * np.pi * (3 - np.sqrt(5))
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1).astype(np.float32)
    points.setflags(write=False)
    return points


@lru_cache(maxsize=8)
def interleaved(shape: tuple[int, int]) -> I64:
    """(H·W,) int64: the number 0…15 of each pixel, every one once in any 4 × 4 pixels."""
    rows, columns = -(-shape[0] // 4), -(-shape[1] // 4)
    numbers = np.tile(PATTERN, (rows, columns))[: shape[0], : shape[1]].reshape(-1)
    numbers.setflags(write=False)
    return numbers


def visible_shares(
    lights: Sequence[DirectLight],
    lux: Sequence[F32],
    points: F32,
    normals: F32,
    caster: RayCaster,
    shape: tuple[int, int],
    threads: Threads = ALONE,
    sparse: bool = False,
) -> list[F32]:
    """The share of each light's disc that the points of a picture see.

    Parameters
    ----------
    lux : one (H·W,) float32 for each light
        What arrives unshadowed. Lights of less than `FAINT` of what does arrive keep their first ray.
    points, normals : (H·W, 3) float32
        What pixels show.
    shape : (H, W)
    sparse : bool
        Whether blocks of `BLOCK_PX` pixels share a first ray where their neighbourhood agrees.

    Returns
    -------
    one (H·W,) float32 for each light, 0…1; 0 where no light could arrive
    """
    number = interleaved(shape)
    shares, arrived = [], np.zeros(len(points), dtype=np.float32)
    for light, unshadowed in zip(lights, lux, strict=True):
        facing = np.flatnonzero(unshadowed)

        def one_each(which: I64, light: DirectLight = light) -> F32:
            return _free(light, points, normals, which, number[which], 1, caster, threads)

        free = _sparsely(facing, shape, one_each) if sparse else one_each(facing)
        share = np.zeros(len(points), dtype=np.float32)
        _note(facing, free, unshadowed, share, arrived)
        shares.append(share)
    for light, unshadowed, share in zip(lights, lux, shares, strict=True):
        if not share.any():
            continue
        mixed = _penumbra(share, unshadowed, arrived, shape, FAINT_OF_SPARSE if sparse else FAINT)
        free = _free(light, points, normals, mixed, (number[mixed] + 1) % POINTS, POINTS - 1, caster, threads)
        share[mixed] = (share[mixed] + free) / POINTS
    return shares


def lit_share(
    light: DirectLight,
    points: F32,
    normals: F32,
    which: I64,
    caster: RayCaster,
    rays: int = 1,
    threads: Threads = ALONE,
) -> F32:
    """As `visible_shares`, for the points ``which`` of no picture: ``rays`` each, going round the disc."""
    first = np.arange(0, len(which) * rays, rays) % POINTS
    return _free(light, points, normals, which, first, rays, caster, threads) / np.float32(rays)


def _free(
    light: DirectLight,
    points: F32,
    normals: F32,
    which: I64,
    first: I64,
    count: int,
    caster: RayCaster,
    threads: Threads,
) -> F32:
    """(m,) float32: how many of ``count`` rays from each point ``which`` to the disc meet nothing."""
    rays, disc = np.empty((len(which), count, 6), dtype=np.float32), disc_points()

    def aim(part: slice) -> None:
        light.shadow_rays(points, normals, which[part], disc, first[part], rays[part])

    threads.over(len(which), aim)
    return _count(caster.any_hit(rays, light.far))


def _sparsely(facing: I64, shape: tuple[int, int], free_at: Callable[[I64], F32]) -> F32:
    """(m,) float32: whether the facing pixels' rays are free, by one a block, all where neighbours differ."""
    rows, columns = (-(-side // BLOCK_PX) for side in shape)
    first = _first_of_blocks(facing, shape[1], rows, columns)
    with_any = np.flatnonzero(first != NOTHING)
    marks = np.zeros((rows * columns, 2), dtype=np.uint8)
    marks[with_any, (free_at(first[with_any]) > 0).astype(np.intp)] = 1
    wide = cv2.dilate(marks.reshape(rows, columns, 2), np.ones((3, 3), np.uint8))
    near = np.asarray(wide, dtype=np.uint8).reshape(-1, 2)
    free, differ = _as_their_block(facing, shape[1], columns, marks, near)
    free[differ] = free_at(facing[differ])
    return free


@njit(cache=True, nogil=True)
def _first_of_blocks(facing: I64, width: int, rows: int, columns: int) -> I64:
    """The first facing pixel of each block, `NOTHING` where it has none."""
    first = np.full(rows * columns, NOTHING, dtype=np.int64)
    for i in facing:
        block = (i // width) // BLOCK_PX * columns + (i % width) // BLOCK_PX
        if first[block] == NOTHING:
            first[block] = i
    return first


@njit(cache=True, nogil=True)
def _as_their_block(
    facing: I64, width: int, columns: int, marks: NDArray[np.uint8], near: NDArray[np.uint8]
) -> tuple[F32, I64]:
    """Whether the ray of each pixel's block was free, and the pixels for which that is not enough."""
    free, differ = np.empty(len(facing), dtype=np.float32), np.empty(len(facing), dtype=np.int64)
    count = 0
    for k in range(len(facing)):
        block = (facing[k] // width) // BLOCK_PX * columns + (facing[k] % width) // BLOCK_PX
        free[k] = marks[block, 1]
        if near[block, 0] > 0 and near[block, 1] > 0:
            differ[count] = k
            count += 1
    return free, differ[:count]


def _penumbra(share: F32, lux: F32, arrived: F32, shape: tuple[int, int], faint: float) -> I64:
    """The pixels about which some rays arrive and some do not, and to which the light matters."""
    marks = np.empty((*shape, 2), dtype=np.uint8)
    _mark(share, lux, marks.reshape(-1, 2))
    near = np.asarray(cv2.dilate(marks, NEIGHBOURHOOD), dtype=np.uint8).reshape(-1, 2)
    return np.flatnonzero(_disagree(near, lux, arrived, np.float32(faint)))


@njit(cache=True, nogil=True)
def _count(blocked: NDArray[np.bool_]) -> F32:
    """How many rays of each row are not."""
    free = np.zeros(len(blocked), dtype=np.float32)
    for k in range(len(blocked)):
        for m in range(blocked.shape[1]):
            free[k] += not blocked[k, m]
    return free


@njit(cache=True, nogil=True)
def _note(facing: I64, free: F32, lux: F32, share: F32, arrived: F32) -> None:
    """Write down the first rays, and add what they bring."""
    for k in range(len(facing)):
        if free[k]:
            i = facing[k]
            share[i] = 1.0
            arrived[i] += lux[i]


@njit(cache=True, nogil=True)
def _mark(share: F32, lux: F32, marks: NDArray[np.uint8]) -> None:
    """Rays that arrive in the first channel, rays that do not in the second."""
    for i in range(len(share)):
        marks[i, 0] = share[i] > 0
        marks[i, 1] = (share[i] == 0) & (lux[i] > 0)


@njit(cache=True, nogil=True)
def _disagree(near: NDArray[np.uint8], lux: F32, arrived: F32, faint: np.float32) -> NDArray[np.bool_]:
    mixed = np.empty(len(lux), dtype=np.bool_)
    for i in range(len(lux)):
        mixed[i] = (near[i, 0] > 0) & (near[i, 1] > 0) & (lux[i] > 0) & (lux[i] > faint * arrived[i])
    return mixed
