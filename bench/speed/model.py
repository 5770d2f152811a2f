"""What a benchmark of speed is and what comes out of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Configuration:
    """How large the measured task is; the defaults keep most benchmarks under half a minute.

    Attributes
    ----------
    width, height : int
        Pixels.
    poses, illuminations : int
        Of the tour, and for each of its poses.
    laps : float
        Length of the tour that the poses are taken from.
    rounds : int
        Alternating measurements; the medians are reported.
    cache : Path, optional
        Where baked light is kept.
    processes : int
        That both sides are given.
    fast_bake : bool
        Bake light coarsely, for tests: speed does not depend on the values baked.
    slam_steps : int, optional
        Steps of the DLR log; all by default.
    """

    width: int = 320
    height: int = 240
    poses: int = 4
    illuminations: int = 32
    laps: float = 1.0
    rounds: int = 5
    cache: Path | None = None
    processes: int = 1
    fast_bake: bool = False
    slam_steps: int | None = None


@dataclass(frozen=True)
class Sides:
    """The two sides of a benchmark, ready to be timed.

    Attributes
    ----------
    ours, baseline : callable
        Does a piece of work; returns how many units of it (pictures, poses) were done.
    note : callable
        Given the two medians in the benchmark's unit: the physical limit beside them, in one line.
    """

    ours: Callable[[], int]
    baseline: Callable[[], int]
    note: Callable[[float, float], str]


@dataclass(frozen=True)
class Benchmark:
    """A registered benchmark.

    Attributes
    ----------
    name, summary : str
    unit : str
        "pictures/s" or "ms"; ``rate`` tells whether work per time (True) or time per work is reported.
    target : str
        For a person: what ratio or value is aimed at.
    prepare : callable
        Opens the two sides for a configuration.
    rounds : int, optional
        At most so many, where one takes seconds.
    """

    name: str
    summary: str
    unit: str
    rate: bool
    target: str
    prepare: Callable[[Configuration], AbstractContextManager[Sides]]
    rounds: int | None = None


@dataclass(frozen=True)
class Result:
    """Ours and the baseline in one unit: medians over the rounds and the quartiles around them.

    ``ratio`` is ours / baseline, the median over the rounds: load that both sides of a round meet cancels.
    """

    name: str
    ours: float
    baseline: float
    ratio: float
    unit: str
    ours_quartiles: tuple[float, float]
    baseline_quartiles: tuple[float, float]
    target: str
    note: str

    def record(self) -> Mapping[str, str | float]:
        """The keys of ``--json``."""
        return {
            "name": self.name,
            "ours": self.ours,
            "baseline": self.baseline,
            "ratio": self.ratio,
            "unit": self.unit,
        }


def summarise(
    benchmark: Benchmark, ours: NDArray[np.float64], baseline: NDArray[np.float64], note: str
) -> Result:
    """Medians and quartiles of the rounds, each (n,) float64 in the benchmark's unit."""
    low, middle, high = np.percentile(ours, [25, 50, 75])
    base_low, base_middle, base_high = np.percentile(baseline, [25, 50, 75])
    return Result(
        name=benchmark.name,
        ours=float(middle),
        baseline=float(base_middle),
        ratio=float(np.median(ours / baseline)),
        unit=benchmark.unit,
        ours_quartiles=(float(low), float(high)),
        baseline_quartiles=(float(base_low), float(base_high)),
        target=benchmark.target,
        note=note,
    )
