"""Simulated drives: a virtual sensor and odometry whose noise is exactly what the filter is told.

Noise enters where the models have it: n adds to the increment (eqs. 3-8, 3-9) and v to the landmark in the
robot's frame (eq. 3-6). The sensor's covariance comes from its range and bearing noise through the Jacobian
at the *true* place and is handed over as it is, so Cartesian observations are exactly Gaussian.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bench.drive_choice import LoopDrive, SimulatedOdometry, VirtualDrive, VirtualSensor
from bench.errors import BenchError
from bench.rng import generator
from bench.sequences.dlr import DlrLog
from bench.sequences.drive import Drive, from_start
from vslam.frame import Observations, Odometry
from vslam.geometry import to_local, wrap_angle

FloatArray = NDArray[np.float64]

# Discs stand up to this far from the loop's middle line, metres.
_BAND_M = 4.0


def along_log(choice: VirtualDrive, log: DlrLog, seed: int, run: int) -> Drive:
    """A virtual sensor on the DLR log's track; see `simulate`."""
    poses = resample(log.truth, choice.speed_mps * choice.frame_interval_s)
    return simulate(choice, poses, log.landmark_positions, seed, run)


def round_loop(choice: LoopDrive, seed: int, run: int) -> Drive:
    """A virtual sensor on laps round a rectangle; the discs are the same in every run of a study."""
    poses = loop_poses(choice)
    landmarks = loop_landmarks(choice, generator(seed, "simulated", choice.name, "landmarks"))
    return simulate(choice, poses, landmarks, seed, run)


def simulate(
    choice: VirtualDrive | LoopDrive, poses: FloatArray, landmarks: FloatArray, seed: int, run: int
) -> Drive:
    """Measure along a true track.

    Parameters
    ----------
    choice : VirtualDrive or LoopDrive
        Name, sensor and odometry count.
    poses : (n + 1, 3) float64
        True poses, the start first; headings not wrapped.
    landmarks : (m, 2) float64
        In the same frame, metres.
    seed, run : int
        Of the study, and the number of the repetition.

    Returns
    -------
    Drive

    Raises
    ------
    BenchError
        When the track has no step.
    """
    if len(poses) < 2:
        raise BenchError(f"drive {choice.name!r}: its track is shorter than one step")
    odometry_rng = generator(seed, "simulated", choice.name, "odometry", run)
    sensor_rng = generator(seed, "simulated", choice.name, "sensor", run)
    truth = from_start(poses)
    world = to_local(poses[0], landmarks)
    moves = _odometry(choice.odometry, truth, odometry_rng)
    steps = tuple(
        (u, look(choice.sensor, pose, world, sensor_rng)) for u, pose in zip(moves, truth[1:], strict=True)
    )
    return Drive(choice.name, steps, truth[1:], np.arange(len(world)), world)


def look(
    sensor: VirtualSensor, pose: FloatArray, landmarks: FloatArray, rng: np.random.Generator
) -> Observations:
    """What the sensor sees from a pose: ids are rows of ``landmarks``, (m, 2) metres.

    The generator is asked for the same numbers whatever is in view, so one landmark more changes no other.
    """
    local = to_local(pose, landmarks)
    found = rng.random(len(local)) < sensor.detection
    noise = rng.standard_normal((len(local), 2))
    distance = np.hypot(local[:, 0], local[:, 1])
    bearing = np.arctan2(local[:, 1], local[:, 0])
    seen = found & (distance <= sensor.range_m) & (np.abs(bearing) <= np.radians(sensor.half_angle_deg))
    ids = np.flatnonzero(seen & (distance > 1e-3))  # right under the robot there is no bearing
    ray = local[ids] / distance[ids, None]
    across = np.column_stack([-ray[:, 1], ray[:, 0]])
    roots = np.stack(
        [sensor.sigma_range_m * ray, np.radians(sensor.sigma_bearing_deg) * distance[ids, None] * across],
        axis=-1,
    )
    points = local[ids] + (roots @ noise[ids, :, None])[:, :, 0]
    return Observations(points, roots @ roots.transpose(0, 2, 1), ids.astype(np.int64))


def resample(poses: FloatArray, step_m: float) -> FloatArray:
    """Poses at equal distances along a track, the start first, (k, 3) float64.

    Where the robot turns on the spot its heading changes within one step.
    """
    way = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    travelled = np.concatenate([[0.0], np.cumsum(way)])
    keep = np.concatenate([way > 0.0, [True]])  # the last pose of each place
    at = np.arange(0.0, travelled[-1], step_m)
    headings = np.unwrap(poses[keep, 2])
    columns = (poses[keep, 0], poses[keep, 1], headings)
    return np.column_stack([np.interp(at, travelled[keep], column) for column in columns])


def loop_poses(choice: LoopDrive) -> FloatArray:
    """The true track, counter-clockwise from the middle of the lower side, (n + 1, 3) float64."""
    radius = min(2.0, 0.25 * min(choice.length_m, choice.width_m))
    a, b = choice.length_m - 2 * radius, choice.width_m - 2 * radius
    quarter = 0.5 * np.pi * radius
    lengths = np.array([a / 2, quarter, b, quarter, a, quarter, b, quarter, a / 2])
    turns = np.array([0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0]) / radius
    total = choice.laps * lengths.sum()
    fine = np.arange(0.0, total, 0.01)
    ends = np.cumsum(lengths)
    curvature = turns[np.minimum(np.searchsorted(ends, fine % ends[-1], side="right"), len(turns) - 1)]
    heading = np.concatenate([[0.0], np.cumsum(0.01 * curvature)])[:-1]
    xy = np.cumsum(0.01 * np.column_stack([np.cos(heading), np.sin(heading)]), axis=0)
    stride = max(1, round(100 * choice.speed_mps * choice.frame_interval_s))
    return np.column_stack([xy, heading])[::stride]


def loop_landmarks(choice: LoopDrive, rng: np.random.Generator) -> FloatArray:
    """Discs within `_BAND_M` of the first lap, evenly along it, (m, 2) float64."""
    lap = loop_poses(choice.model_copy(update={"laps": 1}))
    at = np.linspace(0, len(lap) - 1, choice.landmarks).round().astype(int)
    aside = rng.uniform(-_BAND_M, _BAND_M, choice.landmarks)
    heading = lap[at, 2]
    return lap[at, :2] + aside[:, None] * np.column_stack([-np.sin(heading), np.cos(heading)])


def _odometry(choice: SimulatedOdometry, truth: FloatArray, rng: np.random.Generator) -> list[Odometry]:
    sigma = np.array([choice.sigma_forward_m, choice.sigma_lateral_m, np.radians(choice.sigma_heading_deg)])
    noise = sigma * rng.standard_normal((len(truth) - 1, 3))
    if choice.protocol == "truth_fed":
        noise[:] = 0.0
    Q = np.diag(sigma**2)
    return [
        Odometry(true_increment(a, b) + n, Q) for a, b, n in zip(truth[:-1], truth[1:], noise, strict=True)
    ]


def true_increment(start: FloatArray, end: FloatArray) -> FloatArray:
    """The u for which f(start, u, 0) = end (eqs. 3-8, 3-9), (3,) float64."""
    local = to_local(start, end[None, :2])[0]
    return np.array([local[0], local[1], wrap_angle(end[2] - start[2])])
