"""``slam_graph``: steps per second of the whole DLR log through ``ekf_fej``, against iSAM2 online.

iSAM2 (GTSAM, QR, its default relinearisation) is updated with every picture and asked for the newest
pose. Its factors and first guesses are made beforehand, and it is asked for no covariance, so it does less
than ours.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.sequences.drive import Drive
from bench.speed import slam_stage
from bench.speed.model import Benchmark, Configuration, Sides
from vslam.geometry import to_global
from vslam.observation import RangeBearing
from vslam.slam import SlamSettings, run_slam


@dataclass(frozen=True, eq=False)
class Update:
    """What iSAM2 gets with one picture: factors, first guesses, and the key of the pose."""

    factors: Any
    values: Any
    pose: int


def updates(over: Drive) -> list[Update]:
    """All factors of a drive, first guesses from our own filter."""
    import gtsam

    symbol, noise = gtsam.symbol, gtsam.noiseModel
    track = run_slam(over.steps, SlamSettings("ekf_fej", "annotated", "cartesian")).poses
    first = gtsam.NonlinearFactorGraph()
    first.add(gtsam.PriorFactorPose2(symbol("x", 0), gtsam.Pose2(), noise.Isotropic.Sigma(3, 1e-6)))
    start = gtsam.Values()
    start.insert(symbol("x", 0), gtsam.Pose2())
    made, known = [Update(first, start, symbol("x", 0))], set()
    for k, ((odometry, observations), pose) in enumerate(zip(over.steps, track, strict=True), start=1):
        factors, values, key = gtsam.NonlinearFactorGraph(), gtsam.Values(), symbol("x", k)
        values.insert(key, gtsam.Pose2(*pose))
        covariance = noise.Gaussian.Covariance(odometry.covariance)
        delta = gtsam.Pose2(*odometry.delta)
        factors.add(gtsam.BetweenFactorPose2(symbol("x", k - 1), key, delta, covariance))
        z, S = RangeBearing().measure(observations)
        for i, one, R, point in zip(observations.ids.tolist(), z, S, observations.points, strict=True):
            if i < 0:
                continue
            if i not in known:
                known.add(i)
                values.insert(symbol("l", i), to_global(pose, point[None])[0])
            seen = noise.Gaussian.Covariance(np.ascontiguousarray(R[::-1, ::-1]))
            factors.add(gtsam.BearingRangeFactor2D(key, symbol("l", i), gtsam.Rot2(one[1]), one[0], seen))
        made.append(Update(factors, values, key))
    return made


def baseline(made: list[Update]) -> int:
    """ISAM2, update by update."""
    import gtsam

    parameters = gtsam.ISAM2Params()
    parameters.setFactorization("QR")
    isam = gtsam.ISAM2(parameters)
    for one in made:
        isam.update(one.factors, one.values)
        isam.calculateEstimatePose2(one.pose)
    return len(made) - 1


@contextmanager
def prepare(configuration: Configuration) -> Iterator[Sides]:
    """Read the log and make the factors."""
    over = slam_stage.drive(configuration)
    made = updates(over)
    yield Sides(lambda: slam_stage.ours(over), lambda: baseline(made), slam_stage.note_of(over))


BENCHMARK = Benchmark(
    "slam_graph",
    "the whole DLR log through ekf_fej, against iSAM2 online",
    "steps/s",
    True,
    "ratio ≥ 5",
    prepare,
    rounds=3,
)
