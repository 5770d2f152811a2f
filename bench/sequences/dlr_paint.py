"""What the log's pictures show of its discs: black or white, on a dark or a light floor."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.camera_choice import calibration
from bench.sequences.dlr_camera import CAMERA, robot_camera
from vslam.camera import Calibration

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

LOOKS = 3
"""Pictures of each disc, the nearest: the median of their answers stands."""
PAINT_M, FLOOR_M = 0.05, 0.135
"""Radii of circles well inside a disc of 0.095 m, and around it."""
LIGHT_FLOOR = 0.3
"""Share of white paper's linear light from which a floor is light.

Carpet has 0.1 to 0.2, tiles and linoleum 0.35 to 0.6.
"""


def read_paint(
    folder: Path,
    images: tuple[str, ...],
    pictures: NDArray[np.int64],
    discs: NDArray[np.int64],
    points: FloatArray,
    count: int,
) -> tuple[BoolArray, BoolArray]:
    """Whether discs are white, and whether they lie on a light floor.

    Where the folder has no pictures or no camera, and for a disc that no picture shows, a disc counts as
    white on a dark floor, as most are.

    Parameters
    ----------
    images : tuple of str
        File names of the log's pictures.
    pictures, discs : (k,) int64
        Of each observation: its picture, and its disc 0 … count − 1.
    points : (k, 2) float64
        Where it saw the disc, robot frame, metres.

    Returns
    -------
    white, light_floor : (count,) bool
    """
    white, light = np.ones(count, dtype=bool), np.zeros(count, dtype=bool)
    if not ((folder / CAMERA).is_file() and (folder / "images").is_dir()):
        return white, light
    view = calibration(robot_camera(folder))
    chosen = _nearest(discs, np.hypot(*points.T))
    levels: dict[int, list[tuple[float, float]]] = {}
    for picture in np.unique(pictures[chosen]):
        read = cv2.imread(str(folder / "images" / images[picture]), cv2.IMREAD_GRAYSCALE)
        if read is None or read.shape != (view.height, view.width):
            continue
        grey = np.asarray(read, dtype=np.uint8)
        for k in chosen[pictures[chosen] == picture]:
            paint = _level(grey, view, points[k], PAINT_M)
            levels.setdefault(int(discs[k]), []).append((paint, _level(grey, view, points[k], FLOOR_M)))
    for disc, looks in levels.items():
        paint, floor = np.median(np.array(looks), axis=0)
        white[disc] = paint > floor
        light[disc] = paint <= floor or floor > LIGHT_FLOOR * paint
    return white, light


def _nearest(discs: NDArray[np.int64], ranges: FloatArray) -> NDArray[np.int64]:
    """Rows of each disc's `LOOKS` nearest observations."""
    order = np.lexsort((ranges, discs))
    start = np.searchsorted(discs[order], discs[order])
    return np.asarray(order[np.arange(len(order)) - start < LOOKS])


def _level(grey: NDArray[np.uint8], view: Calibration, centre: FloatArray, radius: float) -> float:
    """Median linear light along a circle on the floor, full scale 1; the camera's curve counts as sRGB's."""
    angle = 2 * np.pi * np.arange(12) / 12
    circle = centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    T = view.T_robot_camera
    pixels, _ = view.project((np.column_stack([circle, np.zeros(len(circle))]) - T[:3, 3]) @ T[:3, :3])
    column, row = np.round(np.nan_to_num(pixels)).astype(int).T.clip(min=0)
    level = np.median(grey[row.clip(max=view.height - 1), column.clip(max=view.width - 1)]) / 255
    return float(level / 12.92 if level <= 0.04045 else ((level + 0.055) / 1.055) ** 2.4)
