"""The DLR robot's own pictures beside its log: what a study or a data set reads of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.errors import BenchError
from bench.sequences.dlr import DlrLog
from bench.sequences.dlr_camera import HEIGHT, WIDTH
from vslam.camera import Calibration
from vslam.frame import Odometry
from vslam.geometry import rotation, to_local

FloatArray = NDArray[np.float64]

IMAGES = "images"


def read_picture(folder: Path, name: str) -> NDArray[np.uint8]:
    """One recorded picture.

    Parameters
    ----------
    folder : Path
        Of the log; its pictures lie in ``images``.
    name : str
        File name (`DlrLog.image_names`).

    Returns
    -------
    (288, 768, 3) uint8
        The grey level in all three channels, rows half as dense as columns.

    Raises
    ------
    BenchError
        When it is missing, damaged or of another size.
    """
    path = folder / IMAGES / name
    if not path.is_file():
        raise BenchError(f"{path}: no such picture; get them with: python -m bench fetch dlr --pictures")
    grey = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if grey is None or grey.shape != (HEIGHT, WIDTH):
        raise BenchError(f"{path}: not a whole picture of {WIDTH} × {HEIGHT}; fetch the pictures again")
    return np.repeat(np.asarray(grey, dtype=np.uint8)[..., None], 3, axis=2)


def thinned(log: DlrLog, stride: int) -> DlrLog:
    """Every so many steps of the log, from the first; the odometry between them is chained.

    Picture k · ``stride`` becomes step k: x ← x + R(θ) Δ, and the covariances add up through its Jacobians.
    """
    if stride == 1:
        return log
    kept = np.arange(0, len(log.steps), stride)
    starts = [0, *(kept[:-1] + 1)]
    steps = tuple(
        (_chained([o for o, _ in log.steps[a : b + 1]]), log.steps[b][1])
        for a, b in zip(starts, kept, strict=True)
    )
    rows = np.concatenate([[0], kept + 1])
    return replace(
        log,
        steps=steps,
        truth=log.truth[rows],
        batch_poses=None if log.batch_poses is None else log.batch_poses[rows],
        image_names=tuple(log.image_names[k] for k in kept),
    )


def _chained(increments: list[Odometry]) -> Odometry:
    delta, covariance = np.zeros(3), np.zeros((3, 3))
    for one in increments:
        R = rotation(float(delta[2]))
        moved = R @ one.delta[:2]
        before, now = np.eye(3), np.eye(3)
        before[:2, 2] = -moved[1], moved[0]
        now[:2, :2] = R
        covariance = before @ covariance @ before.T + now @ one.covariance @ now.T
        delta = np.array([delta[0] + moved[0], delta[1] + moved[1], delta[2] + one.delta[2]])
    return Odometry(delta, covariance)


def mapped_discs(log: DlrLog, step: int) -> FloatArray:
    """(m, 2) float64: all discs of the least-squares solution as its pose of a step sees them, metres.

    Without that solution, of ``truth.txt`` and the means of the observations (`DlrLog.landmark_positions`).
    """
    poses = log.truth if log.batch_poses is None else log.batch_poses
    return to_local(poses[step + 1], log.landmark_positions)


def on_picture(view: Calibration, points: FloatArray) -> FloatArray:
    """(n, 2) float64: column and row of floor points in the robot's frame; NaN behind the camera."""
    T = view.T_robot_camera
    return view.project((np.column_stack([points, np.zeros(len(points))]) - T[:3, 3]) @ T[:3, :3])[0]
