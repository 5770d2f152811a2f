"""What the SLAM benchmarks share: the drive, the limits of its arithmetic, and running ours over it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dsyrk
from threadpoolctl import threadpool_limits

from bench.data import dlr_folder
from bench.drive_choice import LoopDrive
from bench.errors import BenchError
from bench.sequences import dlr, simulated
from bench.sequences.drive import Drive, recorded
from bench.speed.measure import copy_bandwidth
from bench.speed.model import Configuration
from vslam.slam import SlamSettings, run_slam

_STAND_IN = LoopDrive(source="loop", length_m=60, width_m=40, laps=2, landmarks=576)


def drive(configuration: Configuration) -> Drive:
    """The DLR log, or where there is none a loop with as many landmarks; as many steps as asked for."""
    try:
        whole = recorded(dlr.load(dlr_folder()))
    except BenchError:
        whole = simulated.round_loop(_STAND_IN, 0, 0)
    steps = whole.steps[: configuration.slam_steps]
    return Drive(whole.name, steps, whole.truth[: len(steps)], whole.landmark_ids, whole.landmark_positions)


def ours(over: Drive) -> int:
    """``ekf_fej`` with known landmarks."""
    run_slam(over.steps, SlamSettings("ekf_fej", "annotated", "cartesian"))
    return len(over.steps)


@dataclass(frozen=True)
class Limits:
    """What one triangle of P costs over a drive, corrected once per picture.

    Ours can be faster than that: it corrects the neighbourhood with each picture and the rest of P when the
    robot leaves it (`vslam.backends.parts.active_area`).

    Attributes
    ----------
    bytes_moved : float
        Read and written.
    operations : float
        Of the rank-k updates.
    """

    bytes_moved: float
    operations: float

    def text(self, seconds: float) -> str:
        """Beside the seconds that ours took."""
        memory, arithmetic = self.bytes_moved / copy_bandwidth(), self.operations / dsyrk_rate()
        return (
            f"one triangle of P moves {self.bytes_moved / 1e9:.1f} GB if each picture rewrites it "
            f"({memory:.2f} s at this core's copy rate) and takes {self.operations / 1e9:.1f} GFLOP "
            f"({arithmetic:.2f} s at its dsyrk rate); ours took {seconds:.2f} s in all, "
            f"{seconds / memory:.2f} and {seconds / arithmetic:.1f} times as long"
        )


def limits(over: Drive) -> Limits:
    """Count bytes and operations; landmarks are founded at first sight."""
    seen: set[int] = set()
    moved = operations = 0.0
    for rows in over.seen:
        known = [r for r in rows.tolist() if r >= 0]
        again = sum(r in seen for r in known)
        n = 3 + 2 * len(seen)
        if again:
            moved += 2 * 8 * n * (n + 1) / 2
            operations += 2 * again * n * (n + 1)
        seen.update(known)
    return Limits(moved, operations)


def note_of(over: Drive) -> Callable[[float, float], str]:
    """What stands beside the rate of a drive: its steps, and the limits of their arithmetic."""
    bounds = limits(over)

    def note(rate: float, _: float) -> str:
        return f"{over.name}, {len(over.steps)} steps: {bounds.text(len(over.steps) / rate)}"

    return note


def dsyrk_rate(size: int = 1152, columns: int = 48, repeats: int = 5) -> float:
    """Operations per second of the fastest of some rank-k updates on one thread."""
    W, P = np.ones((size, columns), order="F"), np.zeros((size, size), order="F")
    best = np.inf
    with threadpool_limits(limits=1, user_api="blas"):
        for _ in range(repeats):
            start = time.perf_counter()
            P = dsyrk(-1.0, W, beta=1.0, c=P, lower=1, overwrite_c=1)
            best = min(best, time.perf_counter() - start)
    return columns * size * (size + 1) / best
