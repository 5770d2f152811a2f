"""Where a disc may be: pixels whose small ring on the floor is brighter, or darker, than their large one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vslam.camera import Calibration

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

_INNER, _OUTER = 4, 12  # samples on the rings
# Least step between the rings, grey levels. That all 5 inner samples exceed all 12 outer ones happens in pure
# noise with probability 1/6188, so two levels on top of it are enough.
LEAST_STEP = 2.0
_ALIKE = 1.25  # sizes that differ by less share a table


@dataclass(frozen=True, eq=False)
class RingTable:
    """The rings of one disc size around every pixel that can be the centre of such a disc.

    Attributes
    ----------
    radius_m : float
        Of the larger ring on the floor, metres.
    centres : (n,) int32
        Flat pixel numbers.
    rings : (16, n) int32
        Flat pixel numbers: 12 outer samples (opposite ones first), then 4 inner samples.
    """

    radius_m: float
    centres: IntArray
    rings: IntArray


def ring_tables(
    calibration: Calibration, min_radius_m: float, max_radius_m: float, searched: NDArray[np.bool_]
) -> tuple[RingTable, ...]:
    """Tables for small and for large discs, whose sizes meet at the geometric mean; one where all are alike.

    A table covers the searched pixels where the smallest of its discs is a pixel thick and whose rings lie
    inside the picture; every second column where a disc is so wide that one of two pixels well inside it
    does.

    Parameters
    ----------
    searched : (H·W,) bool
        Pixels whose floor point may be a disc's centre.
    """
    middle = float(np.sqrt(min_radius_m * max_radius_m))
    alike = max_radius_m <= _ALIKE * min_radius_m
    spans = ((min_radius_m, max_radius_m),) if alike else ((min_radius_m, middle), (middle, max_radius_m))
    return tuple(_ring_table(calibration, low, high, searched) for low, high in spans)


def _ring_table(
    calibration: Calibration, smallest: float, largest: float, searched: NDArray[np.bool_]
) -> RingTable:
    pixels = calibration.pixel_grid()
    floor, jacobian = calibration.floor_points(pixels)
    jacobian = np.nan_to_num(jacobian, nan=1e9)
    thick = np.linalg.norm(jacobian, ord=2, axis=(1, 2)) <= 2.0 * smallest
    # Around its centre, half of a disc's radius passes the test: of 3 pixels, every second one does.
    wide = np.linalg.norm(jacobian[:, :, 0], axis=1) <= smallest / 6.0
    centres = np.flatnonzero(searched & thick & ~(wide & (pixels[:, 0] % 2 == 1)))
    # Inner ring: well inside the smallest disc. Outer: clear of the largest by a tenth and a pixel's blur.
    inner = _ring(calibration, pixels[centres], floor[centres], 0.5 * smallest, _INNER, stretch_px=0.0)
    outer = _ring(calibration, pixels[centres], floor[centres], 1.1 * largest, _OUTER, stretch_px=1.0)
    opposite_first = np.argsort(np.arange(_OUTER) % (_OUTER // 4), kind="stable")
    rings = np.concatenate([outer[:, opposite_first], inner], axis=1)
    columns, rows = rings[..., 0], rings[..., 1]
    inside = (columns >= 0) & (columns < calibration.width) & (rows >= 0) & (rows < calibration.height)
    keep = inside.all(axis=1)
    flat = rows[keep] * calibration.width + columns[keep]
    return RingTable(
        1.1 * largest, centres[keep].astype(np.int32), np.ascontiguousarray(flat.T, dtype=np.int32)
    )


def _ring(
    calibration: Calibration,
    pixels: FloatArray,
    floor: FloatArray,
    radius: float,
    count: int,
    stretch_px: float,
) -> FloatArray:
    """(n, count, 2): nearest pixels to a floor circle, pushed outwards in the picture; −1 outside it."""
    angle = 2.0 * np.pi * np.arange(count) / count
    circle = floor[:, None] + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    robot = np.concatenate([circle, np.zeros((*circle.shape[:2], 1))], axis=2).reshape(-1, 3)
    T = calibration.T_robot_camera
    ring, _ = calibration.project((robot - T[:3, 3]) @ T[:3, :3])
    offset = ring.reshape(*circle.shape) - pixels[:, None]
    length = np.linalg.norm(offset, axis=2, keepdims=True)
    offset = offset * (1.0 + stretch_px / np.maximum(length, 1e-9))
    return np.nan_to_num(np.round(pixels[:, None] + offset), nan=-1.0)


@njit(cache=True)
def _answers(grey, centres, rings, least, share, found, strength):  # type: ignore[no-untyped-def]
    """Count the pixels that pass the ring test; write their number and signed contrast to the arrays."""
    n = 0
    for i in range(len(centres)):
        centre = float(grey[centres[i]])
        margin = max(least, share * centre)
        first = float(grey[rings[0, i]])
        if centre > first + margin:
            sign = 1.0
        elif centre < first - margin:
            sign = -1.0
        else:
            continue
        low, high = sign * centre, sign * first
        for k in range(1, rings.shape[0]):
            value = sign * grey[rings[k, i]]
            if k < _OUTER:
                high = max(high, value)
            else:
                low = min(low, value)
            if low < high + margin:
                break
        if low >= high + margin:
            found[n] = centres[i]
            strength[n] = sign * (low - high)
            n += 1
    return n


@dataclass(frozen=True, eq=False)
class Seed:
    """A pixel near a possible disc centre.

    Attributes
    ----------
    pixel : int
        Flat pixel number.
    white : bool
        Brighter than its surroundings.
    ring_m : float
        Radius of the larger ring, metres: an upper bound of the disc's.
    """

    pixel: int
    white: bool
    ring_m: float


def find_seeds(
    grey: NDArray[np.uint8], tables: tuple[RingTable, ...], floor: FloatArray, share: float
) -> list[Seed]:
    """Answers to the ring test, strongest first; of a table none nearer than half its ring to a stronger one.

    Parameters
    ----------
    grey : (H, W) uint8
        sRGB-encoded, where shot noise and quantisation are nearly even.
    tables : tuple of RingTable
    floor : (H, W, 2) float64
        Floor point of each pixel, metres.
    share : float
        Least contrast as a share of the centre's level.
    """
    flat = np.ascontiguousarray(grey).ravel()
    places = floor.reshape(-1, 2)
    seeds: list[tuple[float, Seed]] = []
    for table in tables:
        found = np.empty(len(table.centres), dtype=np.int64)
        strength = np.empty(len(table.centres))
        n = _answers(flat, table.centres, table.rings, LEAST_STEP, share, found, strength)
        strongest = np.argsort(-np.abs(strength[:n]), kind="stable")
        for k in _apart(places, found[:n][strongest], 0.5 * table.radius_m):
            chosen = strongest[k]
            seed = Seed(int(found[chosen]), bool(strength[chosen] > 0.0), table.radius_m)
            seeds.append((abs(float(strength[chosen])), seed))
    return [seed for _, seed in sorted(seeds, key=lambda entry: -entry[0])]


@njit(cache=True)
def _apart(places, pixels, distance):  # type: ignore[no-untyped-def]
    """Positions in the list that keep a distance on the floor from every earlier one kept."""
    kept = np.empty(len(pixels), dtype=np.int64)
    n = 0
    for i in range(len(pixels)):
        x, y = places[pixels[i], 0], places[pixels[i], 1]
        alone = True
        for k in range(n):
            other = pixels[kept[k]]
            if np.hypot(places[other, 0] - x, places[other, 1] - y) < distance:
                alone = False
                break
        if alone:
            kept[n] = i
            n += 1
    return kept[:n]
