"""A virtual planar laser scan from a depth image: what stands in the robot's way, by bearing."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vslam.camera import Calibration
from vslam.errors import VslamError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ScanSettings:
    """What counts as an obstacle, and the fan of beams.

    Attributes
    ----------
    min_height_m, max_height_m : float
        Points between these heights above the floor block the robot; the upper end is the robot's own height.
    floor_height_m : float
        Points closer to z = 0 than this are floor.
    surface_depth_m : float
        A beam's range is the mean over the points up to so far behind the nearest: of 150 noisy points the
        nearest alone would stand 2.5 σ in front of the wall. A cell of the map is a natural choice.
    max_range_m : float
        Table 4-1's sensor range.
    half_angle_deg, step_deg : float
        The beams lie at −half … +half in steps; Table 4-1's field of view is ±75°.
    """

    min_height_m: float = 0.10
    max_height_m: float = 1.0
    floor_height_m: float = 0.05
    surface_depth_m: float = 0.10
    max_range_m: float = 12.0
    half_angle_deg: float = 75.0
    step_deg: float = 1.0


@dataclass(frozen=True, eq=False)
class Scan:
    """A fan of beams in the robot's frame.

    Attributes
    ----------
    bearings : (n,) float64
        Counter-clockwise from the robot's x axis, rad, ascending.
    ranges : (n,) float64
        Metres. To the nearest obstacle where ``hit``; elsewhere how far the way was seen to be free
        (0 = nothing seen).
    hit : (n,) bool
        True where the beam ends at an obstacle.
    origin : (2,) float64
        Where the beams start in the robot's frame: the camera's place on the floor plan, metres.
    """

    bearings: FloatArray
    ranges: FloatArray
    hit: NDArray[np.bool_]
    origin: FloatArray = field(default_factory=lambda: np.zeros(2))


def scan(depth: NDArray[np.float32], calibration: Calibration, settings: ScanSettings | None = None) -> Scan:
    """Reduce a depth image to the nearest obstacle of each bearing.

    A bearing without an obstacle within range is free up to the farthest floor point seen there.

    Parameters
    ----------
    depth : (H, W) float32
        z in the camera frame, metres; 0 or non-finite where there is no reading.
    calibration : Calibration
    settings : ScanSettings, optional

    Raises
    ------
    VslamError
        When the depth image has not the calibration's size.
    """
    settings = settings or ScanSettings()
    if depth.shape != (calibration.height, calibration.width):
        raise VslamError(
            f"scan: depth is {depth.shape}, the calibration {(calibration.height, calibration.width)}"
        )
    beams, slopes, spread = _beam_table(calibration, settings)
    count = round(2 * settings.half_angle_deg / settings.step_deg) + 1
    ranges, hit = _reduce(
        np.ascontiguousarray(depth, dtype=np.float32),
        beams,
        slopes,
        spread,
        calibration.T_robot_camera[2, 3],
        settings.min_height_m,
        settings.max_height_m,
        settings.floor_height_m,
        settings.surface_depth_m,
        settings.max_range_m,
        count,
    )
    bearings = np.radians(np.linspace(-settings.half_angle_deg, settings.half_angle_deg, count))
    return Scan(bearings, ranges, hit, calibration.T_robot_camera[:2, 3].copy())


@lru_cache(maxsize=4)
def _beam_table(
    calibration: Calibration, settings: ScanSettings
) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.float32]]:
    """Per pixel: its beam (−1 outside the fan), and height and floor-plan distance per metre of depth."""
    rays = calibration.rays()
    ahead = rays[..., 2] > 0.05  # beyond 87° from the axis z says next to nothing about distance
    direction = (rays / np.where(ahead, rays[..., 2], 1.0)[..., None]) @ calibration.T_robot_camera[:3, :3].T
    bearing = np.degrees(np.arctan2(direction[..., 1], direction[..., 0]))
    beams = np.floor((bearing + settings.half_angle_deg) / settings.step_deg + 0.5)
    count = round(2 * settings.half_angle_deg / settings.step_deg) + 1
    inside = ahead & (beams >= 0) & (beams < count)
    return (
        np.where(inside, beams, -1).astype(np.int32),
        direction[..., 2].astype(np.float32),
        np.hypot(direction[..., 0], direction[..., 1]).astype(np.float32),
    )


@njit(cache=True)
def _reduce(depth, beams, slopes, spread, mount, low, high, floor, surface, max_range, count):  # type: ignore[no-untyped-def]
    nearest = np.full(count, np.inf)
    farthest_floor = np.zeros(count)
    for v in range(depth.shape[0]):
        for u in range(depth.shape[1]):
            z, beam = depth[v, u], beams[v, u]
            if beam < 0 or not (z > 0.0 and z < np.inf):
                continue
            height = mount + z * slopes[v, u]
            distance = z * spread[v, u]
            if low <= height <= high:
                nearest[beam] = min(nearest[beam], distance)
            elif abs(height) < floor:
                farthest_floor[beam] = max(farthest_floor[beam], distance)
    total, points = np.zeros(count), np.zeros(count)
    for v in range(depth.shape[0]):
        for u in range(depth.shape[1]):
            z, beam = depth[v, u], beams[v, u]
            if beam < 0 or not (z > 0.0 and z < np.inf):
                continue
            distance = z * spread[v, u]
            if distance <= nearest[beam] + surface and low <= mount + z * slopes[v, u] <= high:
                total[beam] += distance
                points[beam] += 1.0
    hit = nearest <= max_range
    ranges = np.where(hit, total / np.maximum(points, 1.0), np.minimum(farthest_floor, max_range))
    return ranges, hit
