"""``astar``: the shortest path through a large map, ours against SciPy's Dijkstra on the same graph.

The map has 1000 × 1000 cells, a fifth of them blocked at random, and the path leads from corner to corner,
8-connected without corner cutting. The baseline builds the sparse graph with NumPy and searches it from the
start; both costs are equal. Where the package ``pyastar2d`` is installed its time
is told beside; its paths count a diagonal as one and so are not the shortest.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

from bench.speed.model import Benchmark, Configuration, Sides
from vslam.astar import shortest_path

SIDE, BLOCKED_SHARE, SEED = 1000, 0.2, 0
MAP_SIDE_PER_PIXEL = SIDE / 320  # a configuration with smaller pictures, as tests have it, has a smaller map


def grid(side: int) -> NDArray[np.bool_]:
    """(side, side) bool, a fifth of it blocked; two opposite corners are free."""
    blocked = np.random.default_rng(SEED).random((side, side)) < BLOCKED_SHARE
    blocked[0, 0] = blocked[-1, -1] = False
    return blocked


def dijkstra_cost(blocked: NDArray[np.bool_]) -> float:
    """Length of the path from the first to the last cell, by SciPy; its graph is made by shifted grids."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    free = np.pad(~blocked, 1)
    rows, cols = blocked.shape
    index = np.arange(blocked.size).reshape(blocked.shape)
    ends, lengths = [], []
    for dr, dc in ((0, 1), (1, 0), (1, 1), (1, -1)):
        there, by_row, by_col = (
            free[1 + r : 1 + r + rows, 1 + c : 1 + c + cols] for r, c in ((dr, dc), (dr, 0), (0, dc))
        )
        r, c = np.nonzero(~blocked & there & by_row & by_col)
        ends.append(np.stack([index[r, c], index[r + dr, c + dc]]))
        lengths.append(np.full(len(r), np.hypot(dr, dc)))
    graph = csr_array((np.concatenate(lengths), np.concatenate(ends, axis=1)), shape=(blocked.size,) * 2)
    distances: NDArray[np.float64] = dijkstra(graph, directed=False, indices=0)  # type: ignore[call-overload]
    return float(distances[-1])


@contextmanager
def prepare(configuration: Configuration) -> Iterator[Sides]:
    """One map for both sides."""
    side = round(configuration.width * MAP_SIDE_PER_PIXEL)
    blocked = grid(side)
    corner = (side - 1, side - 1)

    def ours() -> int:
        shortest_path(blocked, (0, 0), corner, 1.0)
        return 1

    def baseline() -> int:
        dijkstra_cost(blocked)
        return 1

    def note(milliseconds: float, _: float) -> str:
        free = int((~blocked).sum())
        told = f"{free:,} free cells: at least {free / milliseconds / 1e3:.1f} million a second"
        return told + _beside(blocked, milliseconds)

    yield Sides(ours, baseline, note)


def _beside(blocked: NDArray[np.bool_], milliseconds: float) -> str:
    """How long pyastar2d takes, the best of five, if it is there."""
    if find_spec("pyastar2d") is None:
        return "; pyastar2d is not installed"
    import pyastar2d

    weights = np.where(blocked, np.inf, 1.0).astype(np.float32)
    end = tuple(n - 1 for n in blocked.shape)
    seconds = []
    for _ in range(5):
        start = time.perf_counter()
        pyastar2d.astar_path(weights, (0, 0), end, allow_diagonal=True)
        seconds.append(time.perf_counter() - start)
    other = 1e3 * min(seconds)
    return f"; {milliseconds / other:.1f} times as long as pyastar2d, whose paths are not the shortest"


BENCHMARK = Benchmark(
    "astar",
    "a path through a map of 1000 × 1000 cells, against SciPy's Dijkstra with its graph",
    "ms",
    False,
    "ratio ≤ 0.1",
    prepare,
)
