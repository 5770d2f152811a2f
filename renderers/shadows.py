"""How much of a light's disc each point sees: soft shadows from shadow rays.

Every pixel casts one ray, to one of 16 points of the disc; neighbours take different points, so that any
4 × 4 pixels together try all 16 (interleaved sampling, Keller & Heidrich 2001). Where the rays of a
neighbourhood disagree, and only there, lies a penumbra: its pixels cast the other 15 rays as well.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from renderers.gbuffer import F32, I64
from renderers.lights import DirectLight
from renderers.mesh import RayCaster

POINTS = 16
"""Of the disc that rays go to: a penumbra in steps of 1/16."""

NEIGHBOURHOOD = np.ones((5, 5), dtype=np.uint8)
"""The pixels about a pixel whose rays are compared; holds all 16 points of the disc."""

FAINT = 0.01
"""A light that brings less than this share of a point's light needs no smooth shadow."""

PATTERN = np.array([[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]])
"""Bayer's ordered dither (1973): neighbours' numbers differ by much."""


def disc_points() -> F32:
    """(16, 2) float32: points of equal share on the unit disc along Vogel's spiral (1979)."""
    k = np.arange(POINTS)
    radius, angle = np.sqrt((k + 0.5) / POINTS), k * np.pi * (3 - np.sqrt(5))
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1).astype(np.float32)


def interleaved(shape: tuple[int, int]) -> NDArray[np.int64]:
    """(H·W,) int64: the number 0…15 of each pixel, every one once in any 4 × 4 pixels."""
    rows, columns = -(-shape[0] // 4), -(-shape[1] // 4)
    return np.tile(PATTERN, (rows, columns))[: shape[0], : shape[1]].reshape(-1)


def visible_shares(
    lights: Sequence[DirectLight],
    lux: Sequence[F32],
    points: F32,
    normals: F32,
    caster: RayCaster,
    pixels: I64,
    shape: tuple[int, int],
) -> list[F32]:
    """The share of each light's disc that the points of a picture see.

    Parameters
    ----------
    lux : one (n,) float32 for each light
        What arrives unshadowed. Lights of less than `FAINT` of what does arrive keep their first ray.
    points, normals : (n, 3) float32
        What pixels show.
    pixels : (n,) int64
        The points' flat index in the picture.
    shape : (H, W)

    Returns
    -------
    one (n,) float32 for each light, 0…1; 0 where no light could arrive
    """
    disc, number = disc_points(), interleaved(shape)[pixels]
    shares, arrived = [], np.zeros(len(points), dtype=np.float32)
    for light, unshadowed in zip(lights, lux, strict=True):
        facing = np.flatnonzero(unshadowed)
        share = np.zeros(len(points), dtype=np.float32)
        share[facing] = _free(light, points, normals, facing, disc[number[facing]], caster)
        arrived += unshadowed * share
        shares.append(share)
    for light, unshadowed, share in zip(lights, lux, shares, strict=True):
        edge = _disagree(share, unshadowed, pixels, shape) & (unshadowed > FAINT * arrived)
        mixed = np.flatnonzero(edge)
        others = (number[mixed, None] + np.arange(1, POINTS)) % POINTS
        which = np.repeat(mixed, POINTS - 1)
        free = _free(light, points, normals, which, disc[others.reshape(-1)], caster)
        share[mixed] = (share[mixed] + free.reshape(-1, POINTS - 1).sum(axis=1)) / POINTS
    return shares


def lit_share(light: DirectLight, points: F32, normals: F32, caster: RayCaster, rays: int = 1) -> F32:
    """As `visible_shares`, for points that are no picture: ``rays`` each, going round the disc."""
    first = np.arange(len(points)) * rays
    number = (first[:, None] + np.arange(rays)).reshape(-1) % POINTS
    which = np.repeat(np.arange(len(points)), rays)
    free = _free(light, points, normals, which, disc_points()[number], caster)
    return free.reshape(-1, rays).mean(axis=1, dtype=np.float32)


def _free(
    light: DirectLight, points: F32, normals: F32, which: I64, disc: F32, caster: RayCaster
) -> NDArray[np.bool_]:
    rays, far = light.shadow_rays(points, normals, which, disc)
    return ~caster.any_hit(rays, far)


def _disagree(share: F32, lux: F32, pixels: I64, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Whether a pixel's neighbourhood holds both rays that arrive and rays that do not."""
    lit, dark = np.zeros((2, shape[0] * shape[1]), dtype=np.uint8)
    lit[pixels], dark[pixels] = share > 0, (share == 0) & (lux > 0)
    near_lit = cv2.dilate(lit.reshape(shape), NEIGHBOURHOOD).reshape(-1)
    near_dark = cv2.dilate(dark.reshape(shape), NEIGHBOURHOOD).reshape(-1)
    return (near_lit > 0)[pixels] & (near_dark > 0)[pixels] & (lux > 0)
