"""How much of a light's disc each point sees: soft shadows from shadow rays.

Every pixel casts one ray, to one of 16 points of the disc; neighbours take different points, so that any
4 × 4 pixels together try all 16 (interleaved sampling, Keller & Heidrich 2001). Where the rays of a
neighbourhood disagree, and only there, lies a penumbra: its pixels cast the other 15 rays as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, lru_cache

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.gbuffer import F32, I64
from renderers.lights import DirectLight
from renderers.mesh import RayCaster
from renderers.threads import ALONE, Threads

POINTS = 16
"""Of the disc that rays go to: a penumbra in steps of 1/16."""

NEIGHBOURHOOD = np.ones((5, 5), dtype=np.uint8)
"""The pixels about a pixel whose rays are compared; holds all 16 points of the disc."""

FAINT = 0.01
"""A light that brings less than this share of a point's light needs no smooth shadow."""

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
) -> list[F32]:
    """The share of each light's disc that the points of a picture see.

    Parameters
    ----------
    lux : one (H·W,) float32 for each light
        What arrives unshadowed. Lights of less than `FAINT` of what does arrive keep their first ray.
    points, normals : (H·W, 3) float32
        What pixels show.
    shape : (H, W)

    Returns
    -------
    one (H·W,) float32 for each light, 0…1; 0 where no light could arrive
    """
    number = interleaved(shape)
    shares, arrived = [], np.zeros(len(points), dtype=np.float32)
    for light, unshadowed in zip(lights, lux, strict=True):
        facing = np.flatnonzero(unshadowed)
        free = free_rays(light, points, normals, facing, number[facing], 1, caster, threads)
        share = np.zeros(len(points), dtype=np.float32)
        _note(facing, free, unshadowed, share, arrived)
        shares.append(share)
    for light, unshadowed, share in zip(lights, lux, shares, strict=True):
        if not share.any():
            continue
        mixed = _penumbra(share, unshadowed, arrived, shape)
        free = free_rays(
            light, points, normals, mixed, (number[mixed] + 1) % POINTS, POINTS - 1, caster, threads
        )
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
    return free_rays(light, points, normals, which, first, rays, caster, threads) / np.float32(rays)


def free_rays(
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
    if not len(which):
        return np.zeros(0, dtype=np.float32)
    rays, disc = np.empty((len(which), count, 6), dtype=np.float32), disc_points()

    def aim(part: slice) -> None:
        light.shadow_rays(points, normals, which[part], disc, first[part], rays[part])

    threads.over(len(which), aim)
    return _count(caster.any_hit(rays, light.far))


def _penumbra(share: F32, lux: F32, arrived: F32, shape: tuple[int, int]) -> I64:
    """The pixels about which some rays arrive and some do not, and to which the light matters."""
    marks = np.empty((*shape, 2), dtype=np.uint8)
    _mark(share, lux, marks.reshape(-1, 2))
    near = np.asarray(cv2.dilate(marks, NEIGHBOURHOOD), dtype=np.uint8).reshape(-1, 2)
    return np.flatnonzero(_disagree(near, lux, arrived, np.float32(FAINT)))


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
