"""Tours over way-points of any kind: corners smoothed, speed held except in sharp turns."""

from __future__ import annotations

import numpy as np

from scenes.errors import SceneError
from scenes.model import FloatArray, Tour

SPACING_M = 0.02
TURN_RATE = np.pi / 2
"""Rad/s; indoor robots turn at up to π, and the camera has to follow."""


def resampled(way: FloatArray, closed: bool, spacing_m: float = SPACING_M) -> FloatArray:
    """(n, 2) points along a polyline at most ``spacing_m`` apart; a closed one ends before its start."""
    corners = np.concatenate([way, way[:1]]) if closed else way
    length = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    corners, length = corners[np.concatenate([[True], length > 1e-9])], length[length > 1e-9]
    if not len(length):
        raise SceneError("tour: needs two way-points that differ")
    along = np.concatenate([[0.0], np.cumsum(length)])
    n = int(np.ceil(along[-1] / spacing_m)) + 1
    at = np.linspace(0.0, along[-1], n)[: -1 if closed else None]
    return np.stack([np.interp(at, along, corners[:, k]) for k in range(2)], axis=-1)


def smoothed(way: FloatArray, closed: bool, sigma_m: float) -> FloatArray:
    """The polyline, evenly sampled, averaged along itself with a Gaussian; an open one keeps its ends."""
    from scipy.ndimage import gaussian_filter1d

    points = resampled(way, closed)
    if sigma_m == 0:
        return points
    if closed:
        return np.asarray(gaussian_filter1d(points, sigma_m / SPACING_M, axis=0, mode="wrap"))
    first, last = points[0], points[-1]
    reach = int(4 * sigma_m / SPACING_M)
    # mirrored through its ends, which so stay where they are
    before, after = 2 * first - points[reach:0:-1], 2 * last - points[-2 : -reach - 2 : -1]
    longer = np.concatenate([before, points, after])
    kept = gaussian_filter1d(longer, sigma_m / SPACING_M, axis=0)[len(before) : len(before) + len(points)]
    return np.asarray(kept)


def follow(way: FloatArray, closed: bool, laps: float, speed_mps: float, interval_s: float) -> Tour:
    """Drive along a dense polyline: at the speed given, slower where it turns faster than `TURN_RATE`.

    Parameters
    ----------
    way : (n, 2) float64
        As `smoothed` gives it.
    laps : float
        Times around a closed way; an open one is driven once.

    Raises
    ------
    SceneError
        If speed, interval or laps are not positive.
    """
    if not all(0 < value < np.inf for value in (speed_mps, interval_s, laps)):
        raise SceneError(
            f"tour: speed {speed_mps} m/s, interval {interval_s} s and {laps} laps must be positive"
        )
    corners = np.concatenate([way, way[:1]]) if closed else way
    segment = np.diff(corners, axis=0)
    heading = np.unwrap(np.arctan2(segment[:, 1], segment[:, 0]))
    round_trip = 0.0
    if closed:
        round_trip = 2 * np.pi * np.round((heading[-1] - heading[0]) / (2 * np.pi))
        before = np.concatenate([[heading[-1] - round_trip], heading])
        after = np.concatenate([heading, [heading[0] + round_trip]])
    else:
        before, after = np.concatenate([heading[:1], heading]), np.concatenate([heading, heading[-1:]])
    at_corner = 0.5 * (before + after)
    length = np.linalg.norm(segment, axis=1)
    seconds = np.maximum(length / speed_mps, np.abs(np.diff(at_corner)) / TURN_RATE)
    clock = np.concatenate([[0.0], np.cumsum(seconds)])
    end = clock[-1] * (laps if closed else 1.0)
    stamps = interval_s * np.arange(int(end / interval_s) + 1, dtype=np.float64)
    lap, within = np.floor(stamps / clock[-1]), np.mod(stamps, clock[-1])
    if not closed:
        lap, within = np.zeros_like(stamps), stamps
    poses = np.stack(
        [
            np.interp(within, clock, corners[:, 0]),
            np.interp(within, clock, corners[:, 1]),
            np.interp(within, clock, at_corner) + lap * (at_corner[-1] - at_corner[0]),
        ],
        axis=-1,
    )
    return Tour(poses, stamps)
