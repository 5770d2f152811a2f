"""A rendered tour as a drive among known landmarks: what the detector found in its pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.drive_choice import RenderedDrive
from bench.kinds.downstream import DownstreamStudy
from bench.kinds.rendered import RenderedStudy
from bench.light_levels import in_scene
from bench.perception import FramePercepts, Percept
from bench.sequences.drive import Drive, from_start
from bench.sequences.lighting import load_scene
from bench.sequences.rendered import odometry
from vslam.geometry import to_local

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Seen:
    """What a tour gave, before any odometry is drawn.

    Attributes
    ----------
    study : RenderedStudy
        Of `rendered`.
    poses : (n, 3) float64
        True poses in the world.
    landmarks : (m, 2) float64
        True positions in the world, metres.
    percepts : tuple of n Percept
    """

    study: RenderedStudy
    poses: FloatArray
    landmarks: FloatArray
    percepts: tuple[Percept, ...]


def rendered(choice: RenderedDrive, seed: int, data: Path | None = None) -> RenderedStudy:
    """The study of one scene, one light and one filter whose pictures a drive looks at.

    Parameters
    ----------
    seed : int
        Of the study that has the drive.
    data : Path, optional
        The DLR folder from ``--data``, for a scene or camera that needs the log.

    Raises
    ------
    BenchError, SceneError
        If the scene does not exist, or lacks what the drive asks of it.
    """
    shared = {key: getattr(choice, key) for key in ("camera", "sensor", "tour", "odometry")}
    several = DownstreamStudy(
        sequence="downstream",
        name=choice.name,
        seed=seed,
        scenes=(choice.scene,),
        split=choice.scene.split or "test",
        levels=(choice.light,),
        filters=(choice.filter,),
        **shared,
    )
    return in_scene(several, choice.scene, data)


def seen(study: RenderedStudy, frames: list[FramePercepts], label: str) -> Seen:
    """What the filter of this label left of each picture, to be found by the detector."""
    scene, (light,) = load_scene(study), study.illuminations.grid()
    percepts = tuple(frame.percepts[light.name, label] for frame in frames)
    return Seen(study, scene.tour.poses, scene.landmark_positions, percepts)


def drive(name: str, tour: Seen, run: int) -> Drive:
    """One repetition: the odometry is drawn anew, what was seen is the same.

    The first increment is exactly zero, as the robot takes its first picture where it starts.
    """
    increments = odometry(tour.study, tour.poses, run)
    steps = tuple(
        (u, replace(p.observations, ids=p.landmark)) for u, p in zip(increments, tour.percepts, strict=True)
    )
    ids = np.arange(len(tour.landmarks))
    return Drive(name, steps, from_start(tour.poses), ids, to_local(tour.poses[0], tour.landmarks))
