"""Landmark discs, painted on the floor with exact circles and anti-aliased edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.gbuffer import F32, I32, GBuffer
from renderers.mesh import NOTHING
from scenes.model import Scene

SUBSAMPLES = 4
"""Samples along each side of a pixel for the share of it that a disc covers."""


@dataclass(frozen=True, eq=False)
class Discs:
    """A scene's landmarks as columns: centre (n, 2), radius (n,), colour (n, 3), float32; id (n,) int32.

    ``floor`` (surfaces + 2,) bool tells the surfaces that carry them; not the bulbs, nor, at −1, the sky.
    """

    centre: F32
    radius: F32
    colour: F32
    id: I32
    floor: NDArray[np.bool_]

    @staticmethod
    def of(scene: Scene) -> Discs:
        """Take a scene's landmarks."""
        paint = [scene.paint_white if m.white else scene.paint_black for m in scene.landmarks]
        return Discs(
            scene.landmark_positions.astype(np.float32),
            np.array([m.radius for m in scene.landmarks], dtype=np.float32),
            np.array(paint, dtype=np.float32).reshape(-1, 3),
            np.array([m.id for m in scene.landmarks], dtype=np.int32),
            np.array([*(s.name in (scene.floor, *scene.inlays) for s in scene.surfaces), False, False]),
        )


def paint(gbuffer: GBuffer, discs: Discs, base_color: F32) -> I32:
    """Paint the discs over the floor's pixels.

    Parameters
    ----------
    base_color : (H, W, 3) float32
        Changed in place: where a disc covers part of a pixel, its colour is mixed in by that part. The mix
        is exact for the pixel's light, as the reflected light is linear in the base colour.

    Returns
    -------
    landmark : (H, W) int32
        Id of the disc that covers at least half of the pixel, `NOTHING` elsewhere.
    """
    landmark = np.full(gbuffer.surface.shape, NOTHING, dtype=np.int32)
    if len(discs.id):
        _paint(
            discs.floor[gbuffer.surface],
            gbuffer.position,
            gbuffer.view.directions,
            float(gbuffer.view.origin[2]),
            discs.centre,
            discs.radius,
            discs.colour,
            discs.id,
            base_color,
            landmark,
        )
    return landmark


@njit(cache=True)
def _floor_step(rays: F32, height: float, r: int, c: int, down: int, right: int) -> tuple[float, float]:
    """How far on the floor one pixel down, or right, is, metres: half of two pixels, but at the border."""
    r0, r1 = max(r - down, 0), min(r + down, rays.shape[0] - 1)
    c0, c1 = max(c - right, 0), min(c + right, rays.shape[1] - 1)
    # rays that miss the floor are not painted
    a, b = height / min(rays[r0, c0, 2], -1e-3), height / min(rays[r1, c1, 2], -1e-3)
    pixels = max(r1 - r0 + c1 - c0, 1)
    return (a * rays[r0, c0, 0] - b * rays[r1, c1, 0]) / pixels, (
        a * rays[r0, c0, 1] - b * rays[r1, c1, 1]
    ) / pixels


@njit(cache=True)
def _paint(
    on_floor: NDArray[np.bool_],
    position: F32,
    rays: F32,
    eye_height: float,
    centre: F32,
    radius: F32,
    colour: F32,
    id: I32,
    base_color: F32,
    landmark: I32,
) -> None:
    height, width = on_floor.shape
    near, reach = np.empty(len(id), dtype=np.int64), np.empty(width, dtype=np.float32)
    row_step = np.empty((width, 2), dtype=np.float32)
    column_step = np.empty((width, 2), dtype=np.float32)
    for r in range(height):
        west = south = np.inf
        east = north = -np.inf
        for c in range(width):  # the part of the floor that this row shows
            if on_floor[r, c]:
                row_step[c] = _floor_step(rays, eye_height, r, c, 1, 0)
                column_step[c] = _floor_step(rays, eye_height, r, c, 0, 1)
                reach[c] = 0.5 * (
                    np.hypot(row_step[c, 0], row_step[c, 1]) + np.hypot(column_step[c, 0], column_step[c, 1])
                )
                west, east = min(west, position[r, c, 0] - reach[c]), max(east, position[r, c, 0] + reach[c])
                south, north = (
                    min(south, position[r, c, 1] - reach[c]),
                    max(north, position[r, c, 1] + reach[c]),
                )
        count = 0
        for k in range(len(id)):
            across = west - radius[k] <= centre[k, 0] <= east + radius[k]
            if across and south - radius[k] <= centre[k, 1] <= north + radius[k]:
                near[count] = k
                count += 1
        for c in range(width):
            if not on_floor[r, c]:
                continue
            x, y = position[r, c, 0], position[r, c, 1]
            for k in near[:count]:
                dx, dy = x - centre[k, 0], y - centre[k, 1]
                far = radius[k] + reach[c]
                if dx * dx + dy * dy > far * far:
                    continue
                covered = 0
                for i in range(SUBSAMPLES):
                    a = (i + 0.5) / SUBSAMPLES - 0.5
                    for j in range(SUBSAMPLES):
                        b = (j + 0.5) / SUBSAMPLES - 0.5
                        px = dx + a * row_step[c, 0] + b * column_step[c, 0]
                        py = dy + a * row_step[c, 1] + b * column_step[c, 1]
                        covered += px * px + py * py <= radius[k] * radius[k]
                share = covered / (SUBSAMPLES * SUBSAMPLES)
                for channel in range(3):
                    base_color[r, c, channel] += share * (colour[k, channel] - base_color[r, c, channel])
                if share >= 0.5:
                    landmark[r, c] = id[k]


def visible_share(gbuffer: GBuffer, discs: Discs, occluded: NDArray[np.bool_], samples: F32) -> F32:
    """The share of each disc's area that the picture shows, (n,) float32 in 0…1.

    Parameters
    ----------
    occluded : (n, k) bool
        Whether geometry stands between the camera and each sample point.
    samples : (n, k, 3) float32
        Points spread evenly over each disc, in the world.
    """
    T = gbuffer.view.T_world_camera
    in_camera = (samples - T[:3, 3]) @ T[:3, :3]
    _, inside = gbuffer.view.camera.project(in_camera)
    return np.asarray((inside & ~occluded).mean(axis=1), dtype=np.float32)


def disc_samples(discs: Discs, count: int = 48) -> F32:
    """(n, count, 3) float32: points spread evenly over each disc by Vogel's spiral (1979)."""
    k = np.arange(count) + 0.5
    radius, angle = np.sqrt(k / count), k * np.pi * (3 - np.sqrt(5))
    unit = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    flat = discs.centre[:, None, :] + discs.radius[:, None, None] * unit
    height = np.zeros((*flat.shape[:2], 1))
    return np.concatenate([flat, height], axis=-1).astype(np.float32)
