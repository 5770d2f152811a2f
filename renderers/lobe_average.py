"""The mean over neighbours on one plane that makes many pixels' single rays a glossy lobe's image.

4 × 4 pixels hold all 16 rays of a lobe (a discontinuity buffer, Keller & Heidrich 2001). Sixteen rays alone
show a bright edge sixteen times, so the mean goes on over as many pixels as lie between two of these images.
That is a share of the lobe as it is seen: narrow beside the plane of incidence at a grazing look, and where
what is mirrored stands close to the surface. Both are boxes, along rows and then along columns.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import cv2
import numpy as np
from numba import njit

from renderers.gbuffer import F32, I32, I64
from renderers.surfaces import Surfaces
from renderers.threads import Threads

ALL_RAYS = np.array([0.5, 1, 1, 1, 0.5], dtype=np.float32)
"""Taps along rows and columns that hold each of the 16 rays once."""

NORMAL_STEP = 0.04
"""Of the components of a normal, within which pixels are averaged."""

GAP = 1.0
"""Between two of the 16 rays' half vectors, in units of α: four lie across the disc of radius 1 that GGX's
visible normals are warped from, whose middle is as wide as α."""

FARTHEST, STEPS = 8.0, 16
"""The widest box between images has this half side, pixels; boxes come in so many steps a pixel."""


def lobe_average(
    light: F32, weight: F32, behind: F32, pixels: I64, surfaces: Surfaces, threads: Threads
) -> None:
    """Replace, in place, what the ray of each pixel brings by what its lobe does.

    Parameters
    ----------
    light : (H·W, c) float32
    weight : (H·W,) float32
        Of each pixel's ray in its lobe.
    behind : (H·W, 2) float32
        How far off a pixel's ray ends, over the whole way from the eye (0 at the surface, 1 for the sky),
        times its weight, and the weight.
    pixels : (m,) int64
        Those that take part, by ascending flat index, on flat surfaces; of others nothing is read.
    """
    at, (height, width) = surfaces, surfaces.shape
    row_of = np.full(len(light), -1, dtype=np.int32)
    row_of[pixels] = np.arange(len(pixels), dtype=np.int32)
    plane, box = np.full(len(light), -1, dtype=np.int64), np.empty((len(pixels), 2), dtype=np.int32)
    total = np.empty((len(pixels), light.shape[1] + 1), dtype=np.float32)
    nearby: Any = behind.reshape(height, width, 2)
    nearby = cv2.sepFilter2D(nearby, -1, ALL_RAYS, ALL_RAYS, borderType=cv2.BORDER_CONSTANT).reshape(-1, 2)

    def widen(part: slice) -> None:
        _number_planes(pixels[part], at.surface, at.normal, plane)
        _widen(pixels[part], at.normal, at.to_eye, at.roughness, at.shape, nearby, box[part])

    def along_rows(part: slice) -> None:
        _along_rows(pixels[part], plane, width, _taps(), box[part], light, weight, total[part])

    def along_columns(part: slice) -> None:
        _along_columns(pixels[part], plane, row_of, at.shape, _taps(), box[part], total, light)

    for step in (widen, along_rows, along_columns):
        threads.over(len(pixels), step)


@cache
def _taps() -> F32:
    """(n, r) float32: taps at distances 0, 1, … of 4 pixels' box over one of half side k / `STEPS`."""
    distance = np.arange(int(FARTHEST) + 3)
    half = np.arange(int(FARTHEST) * STEPS + 1)[:, None, None] / STEPS
    shifted = np.abs(distance[:, None] - np.arange(-2, 3))
    taps = (np.clip(half + 0.5 - shifted, 0, 1) @ ALL_RAYS).astype(np.float32)
    taps.setflags(write=False)
    return taps


@njit(cache=True, nogil=True)
def _number_planes(pixels: I64, surface: I32, normal: F32, plane: I64) -> None:
    """The same number for pixels of one surface whose normals are the same to `NORMAL_STEP`."""
    for k in range(len(pixels)):
        i = pixels[k]
        number = np.int64(surface[i])
        for c in range(3):
            number = 128 * number + int((normal[i, c] + np.float32(1 + 0.3 * NORMAL_STEP)) / NORMAL_STEP)
        plane[i] = number


@njit(cache=True, nogil=True)
def _along_rows(
    pixels: I64, plane: I64, width: int, taps: F32, box: I32, values: F32, weight: F32, total: F32
) -> None:
    """A box's sum of weighted values, and of the weights, along the picture's rows."""
    last = values.shape[1]
    for k in range(len(pixels)):
        i, tap = pixels[k], taps[box[k, 0]]
        x, reach, row = i % width, _reach(box[k, 0]), total[k]
        row[:] = 0.0
        for near in range(i - min(reach, x), i + min(reach, width - 1 - x) + 1):
            if plane[near] == plane[i]:
                share, value = tap[abs(near - i)] * weight[near], values[near]
                for j in range(last):
                    row[j] += share * value[j]
                row[last] += share


@njit(cache=True, nogil=True)
def _along_columns(
    pixels: I64,
    plane: I64,
    row_of: I32,
    shape: tuple[int, int],
    taps: F32,
    box: I32,
    total: F32,
    values: F32,
) -> None:
    """Means over a box of what `_along_rows` summed, along the picture's columns."""
    height, width = shape
    last = values.shape[1]
    row = np.empty(last, dtype=np.float32)
    for k in range(len(pixels)):
        i, tap = pixels[k], taps[box[k, 1]]
        y, reach = i // width, _reach(box[k, 1])
        row[:] = 0.0
        sum_of_weights = np.float32(0)
        for d in range(max(-reach, -y), min(reach, height - 1 - y) + 1):
            near = i + d * width
            if plane[near] == plane[i]:
                share, sums = tap[abs(d)], total[row_of[near]]
                for j in range(last):
                    row[j] += share * sums[j]
                sum_of_weights += share * sums[last]
        per_weight, mean = np.float32(1) / max(sum_of_weights, np.float32(1e-12)), values[i]
        for j in range(last):
            mean[j] = row[j] * per_weight


@njit(cache=True, nogil=True)
def _reach(box: int) -> int:
    """How far the taps of a box go."""
    return 2 + (box + STEPS // 2 - 1) // STEPS


@njit(cache=True, nogil=True)
def _widen(
    pixels: I64,
    normal: F32,
    to_eye: F32,
    roughness: F32,
    shape: tuple[int, int],
    behind: F32,
    box: I32,
) -> None:
    """Boxes that reach from one image to the next, along columns and rows of the picture.

    A half vector turned by δ turns the ray by 2 δ in the plane of incidence, and by 2 δ (n · e) beside it.
    """
    height, width = shape
    for k in range(len(pixels)):
        i = pixels[k]
        ex, ey, ez = to_eye[i, 0], to_eye[i, 1], to_eye[i, 2]
        nv = normal[i, 0] * ex + normal[i, 1] * ey + normal[i, 2] * ez
        ax, ay, az = normal[i, 0] - nv * ex, normal[i, 1] - nv * ey, normal[i, 2] - nv * ez
        length = max(np.sqrt(ax * ax + ay * ay + az * az), np.float32(1e-6))
        angle = (
            np.float32(2 * GAP)
            * roughness[i]
            * roughness[i]
            * behind[i, 0]
            / max(behind[i, 1], np.float32(1e-12))
        )
        for axis in range(2):
            stride, place, end = (1, i % width, width) if axis == 0 else (width, i // width, height)
            at = i + stride if place + 1 < end else i - stride
            dx, dy, dz = to_eye[at, 0] - ex, to_eye[at, 1] - ey, to_eye[at, 2] - ez
            pixel = np.sqrt(dx * dx + dy * dy + dz * dz)
            box[k, axis] = 0
            if pixel <= 0 or pixel > 0.2:  # the neighbour is the sky
                box[k, axis] = 0
                continue
            within = (ax * dx + ay * dy + az * dz) / (length * pixel)
            square = within * within
            turned = angle * np.sqrt(square + (np.float32(1) - square) * nv * nv)
            half = min(np.float32(0.5) * turned / pixel, np.float32(FARTHEST))
            box[k, axis] = int(half * STEPS + np.float32(0.5))
