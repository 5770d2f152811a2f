"""Navigation: does a plan made on the estimated map hold in the true one?

Sources
-------
A* is eq. 3-38. The question: over random start-goal pairs, the share of plans on the estimated
grid that are collision-free on the true grid, and the cost of these paths over the true optimum.

Conventions
-----------
- Maps are bool ``(rows, cols)``, True = blocked, row = y, column = x; ``origin`` is the lower left corner of
  cell [0, 0], metres.
- The *planner* inflates by the robot's radius plus a margin (one cell of the true map unless stated), on the
  estimated and on the true map alike. The *checker* inflates the true map by the radius alone. The margin is
  what a map of cells is coarse by; without it every plan that hugs a corner would hang on the last rounding.
- Both ends of a pair keep the radius plus two margins from what is truly blocked, so a pair stays plannable
  when the two maps' cells are not aligned, and they are connected for the planner on the true map.
- The optimum is what the same planner finds on the true map. So the true map given as the estimate scores
  (1, 1). A path may cost slightly less than the optimum: by cutting into the margin, never into the radius.
- A path collides when any point of it, not only its vertices, lies in a blocked cell or outside the map.
- A start or goal that the estimated map holds for blocked or has not seen is a failure, not a skipped pair.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from bench.errors import BenchError
from vslam.occupancy import OccupancyGrid
from vslam.planner import Plan, Planner, inflate

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_DRAWS = 1000  # draws per pair before the distance asked for is called impossible


@dataclass(frozen=True, eq=False)
class NavigationTask:
    """Start-goal pairs in a true map with their optima, shared by all runs in that scene.

    Attributes
    ----------
    pairs : (n, 2, 2) float64
        Start and goal of each pair, metres.
    optimum_m : (n,) float64
        Length of the true optimum of each pair, metres.
    blocked : (rows, cols) bool
        The true map inflated by the robot's radius: what a path must not touch.
    origin : (2,) float64
        Of the true map, metres.
    resolution : float
        Of the true map, metres.
    planner_radius_m : float
        Radius plus margin: what a planner on the estimated map has to inflate by.
    """

    pairs: FloatArray
    optimum_m: FloatArray
    blocked: BoolArray
    origin: FloatArray
    resolution: float
    planner_radius_m: float


@dataclass(frozen=True)
class NavigationScores:
    """How far the estimated map can be driven by.

    Attributes
    ----------
    success : float
        Share of the pairs with a plan on the estimated map that is collision-free on the true map, 0…1.
    cost_ratio : float
        Mean of path cost over true optimum over the successes; NaN when there is none.
    planned : float
        Share of the pairs with any plan on the estimated map, 0…1.
    """

    success: float
    cost_ratio: float
    planned: float


def prepare(
    blocked: BoolArray,
    origin: ArrayLike,
    resolution: float,
    robot_radius_m: float,
    rng: np.random.Generator,
    n: int = 20,
    min_distance_m: float = 3.0,
    margin_m: float | None = None,
) -> NavigationTask:
    """Draw the pairs of a true map and find their optima.

    Parameters
    ----------
    blocked : (rows, cols) bool
        The true map.
    origin : (2,) array_like, metres
    resolution : float, metres
    robot_radius_m : float
    rng : numpy.random.Generator
    n : int
        Number of pairs.
    min_distance_m : float
        Straight distance between the ends of a pair, at least.
    margin_m : float, optional
        Planner's margin; one cell when left out.

    Raises
    ------
    BenchError
        When the map has no room for such pairs.
    """
    validate(blocked, resolution)
    margin = resolution if margin_m is None else margin_m
    origin = np.asarray(origin, dtype=np.float64)
    planner = Planner.of_blocked(blocked, origin, resolution, robot_radius_m + margin)
    roomy = ~inflate(blocked, robot_radius_m + 2.0 * margin, resolution) & _largest_region(~planner.blocked)
    pairs = sample_pairs(roomy, origin, resolution, rng, n, min_distance_m)
    plans = [planner.plan(start, goal) for start, goal in pairs]
    optimum = np.array([found.cost_m if isinstance(found, Plan) else np.nan for found in plans])
    truth = inflate(blocked, robot_radius_m, resolution)
    return NavigationTask(pairs, optimum, truth, origin, resolution, robot_radius_m + margin)


def validate(blocked: BoolArray, resolution: float) -> None:
    """Raise BenchError unless the map is a 2-d bool array with a positive resolution."""
    if blocked.ndim != 2 or blocked.dtype != np.bool_ or not resolution > 0.0:
        raise BenchError(
            f"navigation: needs a 2-d bool map and a positive resolution, "
            f"not {blocked.shape} {blocked.dtype} and {resolution}"
        )


def sample_pairs(
    free: BoolArray,
    origin: ArrayLike,
    resolution: float,
    rng: np.random.Generator,
    n: int = 20,
    min_distance_m: float = 3.0,
) -> FloatArray:
    """Centres of free cells, drawn uniformly, each start at least so far from its goal.

    Parameters
    ----------
    free : (rows, cols) bool
        Cells that may be drawn.
    origin : (2,) array_like, metres
    resolution : float, metres
    rng : numpy.random.Generator
    n : int
    min_distance_m : float

    Returns
    -------
    (n, 2, 2) float64
        Start and goal, x and y, metres.

    Raises
    ------
    BenchError
        When no cell is free or the free cells lie too close together.
    """
    cells = np.argwhere(free)[:, ::-1]
    if len(cells) == 0:
        raise BenchError(
            "navigation: no free cell in the true map to start from; use a smaller robot or a larger scene"
        )
    points = np.asarray(origin, dtype=np.float64) + (cells + 0.5) * resolution
    pairs = np.empty((n, 2, 2))
    for k in range(n):
        draws = points[rng.integers(len(points), size=(_DRAWS, 2))]
        far = np.linalg.norm(draws[:, 0] - draws[:, 1], axis=1) >= min_distance_m
        if not far.any():
            raise BenchError(
                f"navigation: no two free cells are {min_distance_m} m apart; lower the minimum distance"
            )
        pairs[k] = draws[np.argmax(far)]
    return pairs


def evaluate(estimate: OccupancyGrid | Planner, task: NavigationTask) -> NavigationScores:
    """Plan every pair on the estimated map and drive the plan through the true one.

    Parameters
    ----------
    estimate : OccupancyGrid or Planner
        A grid is inflated by ``task.planner_radius_m``, unknown cells blocked; a planner is taken as it is.
    task : NavigationTask
    """
    planner = estimate if isinstance(estimate, Planner) else Planner.of_grid(estimate, task.planner_radius_m)
    planned, ratios = 0, []
    for (start, goal), optimum in zip(task.pairs, task.optimum_m, strict=True):
        found = planner.plan(start, goal)
        if not isinstance(found, Plan):
            continue
        planned += 1
        if not collides(found.path, task.blocked, task.origin, task.resolution):
            ratios.append(found.cost_m / optimum)
    n = len(task.pairs)
    cost_ratio = float(np.mean(ratios)) if ratios else float("nan")
    return NavigationScores(len(ratios) / n, cost_ratio, planned / n)


def collides(path: FloatArray, blocked: BoolArray, origin: ArrayLike, resolution: float) -> bool:
    """Whether any point of a polyline lies in a blocked cell or outside the map.

    Parameters
    ----------
    path : (n, 2) float64, metres
    blocked : (rows, cols) bool
    origin : (2,) array_like, metres
    resolution : float, metres
    """
    vertices = (np.asarray(path, dtype=np.float64) - np.asarray(origin)) / resolution
    start, end = vertices[:-1], vertices[1:]
    # Between two crossings of grid lines a segment stays in one cell: test the middle of each stretch.
    t = np.sort(np.hstack([_crossings(start[:, k], end[:, k]) for k in (0, 1)]), axis=1)
    t = np.hstack([np.zeros((len(t), 1)), t, np.ones((len(t), 1))])
    middle = (t[:, 1:] + t[:, :-1]) / 2.0
    cells = np.floor(start[:, None] + middle[..., None] * (end - start)[:, None]).astype(int)
    cells = cells[np.diff(t, axis=1) > 1e-9]  # a stretch of no length is a corner that is only touched
    cells = np.vstack([cells, np.floor(vertices).astype(int)])
    col, row = cells.T
    inside = (row >= 0) & (row < blocked.shape[0]) & (col >= 0) & (col < blocked.shape[1])
    return bool(not inside.all() or blocked[row, col].any())


def _crossings(start: FloatArray, end: FloatArray) -> FloatArray:
    """(n, k) float64: where along each segment (0…1) one coordinate crosses an integer; padded with 1."""
    low, high = np.minimum(start, end), np.maximum(start, end)
    first = np.floor(low) + 1.0
    most = int(np.ceil(high - first).max(initial=0.0)) + 1
    lines = first[:, None] + np.arange(most)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (lines - start[:, None]) / (end - start)[:, None]
    return np.where(lines < high[:, None], t, 1.0)


def _largest_region(free: BoolArray) -> BoolArray:
    """The largest part that straight moves connect; diagonal ones without corner cutting add nothing."""
    labels, count = ndimage.label(free)
    if count == 0:
        return free
    sizes = np.bincount(labels.ravel())[1:]
    largest: BoolArray = labels == 1 + int(np.argmax(sizes))
    return largest
