"""What is driven: starts, goals, and the shortest ways between them on the true map."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from bench.errors import BenchError
from bench.kinds.drive import ClosedLoopStudy
from bench.metrics.navigation import sample_pairs
from bench.rng import generator
from scenes.occupancy import TrueOccupancy
from vslam.planner import Plan, Planner, inflate

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Episode:
    """One drive, the same for every light and filter.

    Attributes
    ----------
    task : str
        "goal" or "explore".
    number : int
        Names its random streams.
    start : (3,) float64
        True pose: x, y in metres, heading in rad.
    believed_start : (3,) float64
        Where the robot is told to be.
    places : (k, 2) float64
        To be driven to, in this order, metres; none for exploring.
    optimum_m : float
        Length of the shortest way through them on the true map, as the robot's own planner would go; NaN for
        exploring.
    """

    task: str
    number: int
    start: FloatArray
    believed_start: FloatArray
    places: FloatArray
    optimum_m: float


def draw(study: ClosedLoopStudy, occupancy: TrueOccupancy) -> list[Episode]:
    """All episodes of a study: each pair of start and goal with its repetitions, then the explorations.

    Raises
    ------
    BenchError
        If the true map has no room for the robot, or none for pairs so far apart.
    """
    task, choice = study.navigation, study.drive
    planner = Planner.of_blocked(
        occupancy.blocked,
        occupancy.origin,
        occupancy.resolution,
        task.robot_radius_m + occupancy.resolution,
    )
    roomy = ~inflate(occupancy.blocked, task.robot_radius_m + 2 * occupancy.resolution, occupancy.resolution)
    roomy &= _largest(~planner.blocked)
    episodes: list[Episode] = []
    if "goal" in choice.tasks:
        rng = generator(study.seed, "drive", "goal")
        pairs = sample_pairs(
            roomy, occupancy.origin, occupancy.resolution, rng, task.pairs, choice.min_distance_m
        )
        for pair in pairs:
            start = _facing(pair[0], generator(study.seed, "drive", "goal", len(episodes)))
            places = np.array([pair[1], *([pair[0]] if choice.home else [])])
            optimum = shortest_m(planner, pair[0], places)
            for _ in range(study.seeds):
                episodes.append(Episode("goal", len(episodes), start, start, places, optimum))
    if "explore" in choice.tasks:
        rng = generator(study.seed, "drive", "explore")
        pairs = sample_pairs(roomy, occupancy.origin, occupancy.resolution, rng, choice.explorations, 0.0)
        for k, pair in enumerate(pairs):
            start = _facing(pair[0], generator(study.seed, "drive", "explore", k))
            episodes.append(Episode("explore", k, start, start, np.zeros((0, 2)), np.nan))
    return episodes


def shortest_m(planner: Planner, start: FloatArray, places: FloatArray) -> float:
    """Length of the way through places, metres.

    Raises
    ------
    BenchError
        If there is none.
    """
    total = 0.0
    for a, b in pairwise([start, *places]):
        found = planner.plan(a, b, any_angle=True)
        if not isinstance(found, Plan):
            raise BenchError(
                f"drive: no way from ({a[0]:g}, {a[1]:g}) to ({b[0]:g}, {b[1]:g}) m: {found.reason}"
            )
        total += found.cost_m
    return total


def _facing(place: FloatArray, rng: np.random.Generator) -> FloatArray:
    return np.array([*place, rng.uniform(-np.pi, np.pi)])


def _largest(free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    labels, count = ndimage.label(free)
    if not count:
        return free
    return np.asarray(labels == 1 + int(np.argmax(np.bincount(labels.ravel())[1:])))
