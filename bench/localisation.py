"""Phases 4 and 5 for one variant: EKF-SLAM over its detections, the map, and plans on it, seed by seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.illumination_grid import Illumination
from bench.kinds.rendered import RenderedStudy
from bench.metrics import landmarks, navigation, trajectory
from bench.oracle import observed, slam_settings
from bench.perception import Percept
from bench.run_facts import empty_run_row
from bench.schema import RUN_COLUMNS
from bench.sequences.drive import from_start
from bench.sequences.rendered import odometry
from vslam.errors import VslamError
from vslam.geometry import to_global, to_local
from vslam.motion import move
from vslam.occupancy import OccupancyGrid
from vslam.scan import Scan
from vslam.slam import SlamResult, run_slam

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class World:
    """What is true of the tour, and what the variants share.

    Attributes
    ----------
    poses : (n, 3) float64
        True poses in the world.
    landmarks : (m, 2) float64
        True positions in the world, metres.
    bounds : (x_min, y_min, x_max, y_max)
        That the occupancy grid covers.
    scans : tuple of n Scan
    navigation : NavigationTask
    """

    scene: str
    poses: FloatArray
    landmarks: FloatArray
    bounds: tuple[float, float, float, float]
    scans: tuple[Scan, ...]
    navigation: navigation.NavigationTask


@dataclass(frozen=True, eq=False)
class Variant:
    """One filter under one illumination: its detections along the tour."""

    study: RenderedStudy
    world: World
    illumination: Illumination
    filter: str
    percepts: tuple[Percept, ...]


@dataclass(frozen=True, eq=False)
class Localised:
    """One SLAM run.

    Attributes
    ----------
    row : dict
        Row of the runs table.
    poses : (n, 3) float64
        Estimated track in the world; empty if the run failed.
    landmark_table : (k, 5) float64
        Id, true x and y, estimated x and y of each landmark in the world; NaN where not mapped, further
        rows of the same id for duplicates.
    grid : OccupancyGrid, optional
        The map at the end, of the study's first seed.
    """

    row: dict[str, object]
    poses: FloatArray
    landmark_table: FloatArray
    grid: OccupancyGrid | None = None


def localise(variant: Variant) -> list[Localised]:
    """Run a variant with every seed of its study."""
    return [_run(variant, seed) for seed in range(variant.study.seeds)]


def _run(variant: Variant, seed: int) -> Localised:
    study, world = variant.study, variant.world
    increments = odometry(study, world.poses, seed)
    steps = [(u, observed(study.slam, p)) for u, p in zip(increments, variant.percepts, strict=True)]
    if all(p.failed for p in variant.percepts):
        return _failed(variant, seed, f"the filter failed on every picture: {variant.percepts[0].failed}")
    try:
        result = run_slam(steps, slam_settings(study.slam, seed))
    except VslamError as error:
        return _failed(variant, seed, str(error))
    return _score(variant, seed, result)


def _failed(variant: Variant, seed: int, reason: str) -> Localised:
    row = _labels(variant, seed) | {"status": f"failed: {reason}"}
    return Localised(row, np.zeros((0, 3)), np.zeros((0, 5)))


def _score(variant: Variant, seed: int, result: SlamResult) -> Localised:
    world, start = variant.world, variant.world.poses[0]
    truth = from_start(world.poses)
    true_landmarks = to_local(start, world.landmarks)
    seen = tuple(p.landmark for p in variant.percepts)
    track = trajectory.evaluate(result.poses, truth, result.covariances)
    marks = landmarks.evaluate(result.landmarks, result.matches, seen, true_landmarks)
    estimated = np.array([move(start, pose) for pose in result.poses])
    grid = OccupancyGrid.empty(world.bounds, world.navigation.resolution)
    for pose, scan in zip(estimated, world.scans, strict=True):
        grid.integrate(pose, scan)
    plans = navigation.evaluate(grid, world.navigation)
    row = _labels(variant, seed) | vars(track) | vars(marks)
    row |= {"nav_success": plans.success, "nav_cost_ratio": plans.cost_ratio, "status": "ok"}
    table = landmarks.table(result.landmarks, result.matches, seen, true_landmarks)
    table[:, 1:3], table[:, 3:5] = to_global(start, table[:, 1:3]), to_global(start, table[:, 3:5])
    return Localised({k: row[k] for k in RUN_COLUMNS}, estimated, table, grid if seed == 0 else None)


def _labels(variant: Variant, seed: int) -> dict[str, object]:
    """A runs row with every metric still empty."""
    return empty_run_row() | {
        "scene": variant.world.scene,
        **variant.illumination.labels(),
        "filter": variant.filter,
        "backend": variant.study.slam.backend,
        "association": variant.study.slam.association,
        "observation": variant.study.slam.observation,
        "seed": seed,
        "steps": len(variant.percepts),
        "landmarks_total": len(variant.world.landmarks),
    }
