"""A building of corridors whose truth is known: discs on the floor, a drive with loops, the DLR log's noise.

The stated covariances are the medians that the log states. The noise of observations has them, but as
Student's t with four degrees of freedom: heavy tails, as the log has them.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from vslam.frame import Observations, Odometry
from vslam.geometry import to_local

FloatArray = NDArray[np.float64]

STEP_M = 0.155
NEAR_M, FAR_M, HALF_VIEW_RAD = 0.9, 4.4, np.deg2rad(58.0)
HALF_WIDTH_M = 1.6
DETECTED = 0.75
FALSE_SHARE = 0.03

# Corners of the drive, metres: a large loop, then smaller ones that share corridors with it both ways.
TOUR = [
    (0, 0), (30, 0), (30, 24), (0, 24), (0, 0), (15, 0), (15, 24), (30, 24), (30, 0), (0, 0),
    (0, 12), (15, 12), (15, 0), (0, 0),
]  # fmt: skip


@dataclass(frozen=True)
class Building:
    steps: list[tuple[Odometry, Observations]]
    truth: FloatArray
    discs: FloatArray


def simulate(seed: int = 0, tour=None, discs: FloatArray | None = None, density: float = 0.55) -> Building:
    """Drive the tour; ids of observations are rows of ``discs``, in the frame of the first pose."""
    generator = np.random.default_rng(seed)
    way = _track(np.array(TOUR if tour is None else tour, dtype=np.float64))
    world = _scatter(way, density, generator) if discs is None else discs
    start = way[0]
    world = to_local(start, world)
    poses = np.column_stack([to_local(start, way[:, :2]), way[:, 2] - start[2]])
    steps = [(_odometry(a, b, generator), _observe(b, world, generator)) for a, b in pairwise(poses)]
    return Building(steps, poses[1:], world)


def _track(corners: FloatArray) -> FloatArray:
    """Poses every STEP_M along the polyline, its corners rounded by a moving average."""
    pieces = [
        np.linspace(a, b, max(2, round(float(np.hypot(*(b - a))) / STEP_M)), endpoint=False)
        for a, b in pairwise(corners)
    ]
    points = np.concatenate([*pieces, corners[-1:]])
    half = 6
    padded = np.concatenate([np.repeat(points[:1], half, 0), points, np.repeat(points[-1:], half, 0)])
    kernel = np.ones(2 * half + 1) / (2 * half + 1)
    smooth = np.column_stack([np.convolve(padded[:, i], kernel, "valid") for i in range(2)])
    steps = np.diff(smooth, axis=0)
    # A U-turn has points without motion between: they turn on the spot.
    heading = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    return np.column_stack([smooth[:-1], heading])


def _scatter(way: FloatArray, density: float, generator: np.random.Generator) -> FloatArray:
    """Discs on the corridors' floors, no two closer than 0.4 m."""
    low, high = way[:, :2].min(0) - 2, way[:, :2].max(0) + 2
    points = generator.uniform(low, high, (int(density * np.prod(high - low) * 1.25), 2))
    points = points[cKDTree(way[:, :2]).query(points)[0] < HALF_WIDTH_M]
    kept: list[int] = []
    for i, point in enumerate(points):
        if not kept or np.hypot(*(points[kept] - point).T).min() > 0.4:
            kept.append(i)
    return points[kept]


def _noise(covariance: FloatArray, generator: np.random.Generator) -> FloatArray:
    """Student's t, ν = 4, with this covariance, whose scale matrix is (ν − 2) / ν of it."""
    size = len(covariance)
    return generator.multivariate_normal(np.zeros(size), covariance / 2) / np.sqrt(generator.chisquare(4) / 4)


def _odometry(a: FloatArray, b: FloatArray, generator: np.random.Generator) -> Odometry:
    delta = np.append(to_local(a, b[None, :2])[0], b[2] - a[2])
    length = np.hypot(*delta[:2]) + 0.01
    Q = np.diag([0.024 * length, 0.024 * length, 0.098 * length]) ** 2
    return Odometry(delta + generator.multivariate_normal(np.zeros(3), Q), Q)


def _observe(pose: FloatArray, world: FloatArray, generator: np.random.Generator) -> Observations:
    local = to_local(pose, world)
    distance, bearing = np.hypot(*local.T), np.arctan2(local[:, 1], local[:, 0])
    seen = (distance > NEAR_M) & (distance < FAR_M) & (np.abs(bearing) < HALF_VIEW_RAD)
    ids = np.flatnonzero(seen & (generator.random(len(world)) < DETECTED))
    S = np.diag([0.0475, 0.041]) ** 2
    points = [local[i] + _noise(S, generator) for i in ids]
    for _ in range(generator.poisson(FALSE_SHARE * max(len(ids), 1))):
        r, angle = generator.uniform(NEAR_M, FAR_M), generator.uniform(-HALF_VIEW_RAD, HALF_VIEW_RAD)
        points.append(r * np.array([np.cos(angle), np.sin(angle)]))
        ids = np.append(ids, -1)
    count = len(points)
    return Observations(np.array(points).reshape(-1, 2), np.tile(S, (count, 1, 1)), ids.astype(np.int64))
