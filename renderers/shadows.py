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

        def blocked_at(which: I64, light: DirectLight = light) -> NDArray[np.bool_]:
            return _blocked(light, points, normals, which, number[which], caster, threads)

        blocked = _sparsely(facing, shape, blocked_at) if sparse else blocked_at(facing)
        share = np.zeros(len(points), dtype=np.float32)
        _note(facing, blocked, unshadowed, share, arrived)
        shares.append(share)
    for light, unshadowed, share in zip(lights, lux, shares, strict=True):
        if not share.any():
            continue
        mixed = _penumbra(share, unshadowed, arrived, shape, FAINT_OF_SPARSE if sparse else FAINT)
        others = (number[mixed, None] + np.arange(1, POINTS)) % POINTS
        which = np.repeat(mixed, POINTS - 1)
        blocked = _blocked(light, points, normals, which, others.reshape(-1), caster, threads)
        free = POINTS - 1 - blocked.reshape(-1, POINTS - 1).sum(axis=1)
        share[mixed] = (share[mixed] + free) / POINTS
    return shares


def lit_share(
    light: DirectLight,
    points: F32,
    normals: F32,
    caster: RayCaster,
    rays: int = 1,
    threads: Threads = ALONE,
) -> F32:
    """As `visible_shares`, for points that are no picture: ``rays`` each, going round the disc."""
    number = np.arange(len(points) * rays) % POINTS
    which = np.repeat(np.arange(len(points)), rays)
    free = ~_blocked(light, points, normals, which, number, caster, threads)
    return free.reshape(-1, rays).mean(axis=1, dtype=np.float32)


def _blocked(
    light: DirectLight,
    points: F32,
    normals: F32,
    which: I64,
    number: I64,
    caster: RayCaster,
    threads: Threads,
) -> NDArray[np.bool_]:
    """Whether the ray from each point ``which`` to a numbered point of the disc meets anything."""
    rays, disc = np.empty((len(which), 6), dtype=np.float32), disc_points()

    def aim(part: slice) -> None:
        rays[part] = light.shadow_rays(points, normals, which[part], disc, number[part])

    threads.over(len(which), aim)
    return caster.any_hit(rays, light.far)


def _sparsely(
    facing: I64, shape: tuple[int, int], blocked_at: Callable[[I64], NDArray[np.bool_]]
) -> NDArray[np.bool_]:
    """Which of the facing pixels are blocked, by one ray a block and by all where neighbours differ."""
    rows, columns = (-(-side // BLOCK_PX) for side in shape)
    first = _first_of_blocks(facing, shape[1], rows, columns)
    with_any = np.flatnonzero(first != NOTHING)
    probed = blocked_at(first[with_any])
    marks = np.zeros((rows * columns, 2), dtype=np.uint8)
    marks[with_any, probed.astype(np.intp)] = 1
    wide = cv2.dilate(marks.reshape(rows, columns, 2), np.ones((3, 3), np.uint8))
    near = np.asarray(wide, dtype=np.uint8).reshape(-1, 2)
    blocked, differ = _as_their_block(facing, shape[1], columns, marks, near)
    blocked[differ] = blocked_at(facing[differ])
    return blocked


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
) -> tuple[NDArray[np.bool_], I64]:
    """Whether the ray of each pixel's block was blocked, and the pixels for which that is not enough."""
    blocked, differ = np.empty(len(facing), dtype=np.bool_), np.empty(len(facing), dtype=np.int64)
    count = 0
    for k in range(len(facing)):
        block = (facing[k] // width) // BLOCK_PX * columns + (facing[k] % width) // BLOCK_PX
        blocked[k] = marks[block, 1] > 0
        if near[block, 0] > 0 and near[block, 1] > 0:
            differ[count] = k
            count += 1
    return blocked, differ[:count]


def _penumbra(share: F32, lux: F32, arrived: F32, shape: tuple[int, int], faint: float) -> I64:
    """The pixels about which some rays arrive and some do not, and to which the light matters."""
    marks = np.empty((*shape, 2), dtype=np.uint8)
    _mark(share, lux, marks.reshape(-1, 2))
    near = np.asarray(cv2.dilate(marks, NEIGHBOURHOOD), dtype=np.uint8).reshape(-1, 2)
    return np.flatnonzero(_disagree(near, lux, arrived, np.float32(faint)))


@njit(cache=True, nogil=True)
def _note(facing: I64, blocked: NDArray[np.bool_], lux: F32, share: F32, arrived: F32) -> None:
    """Write down the first rays, and add what they bring."""
    for k in range(len(facing)):
        if not blocked[k]:
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
