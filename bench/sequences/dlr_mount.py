"""The mount of the DLR robot's camera, calibrated on the map.

``camera.json`` was fitted to the log's own rows, whose ranges are biased against the log's own least-squares
map: +4 cm at 1.5 m, −9 cm at 3.5 m, −22 cm at 4.5 m (medians). The lens may be kept. Of the mount, height,
offsets and three angles are fitted anew, so that the discs which our detector finds in some pictures fall
where the map has them. What the fit does not see confirms it: disc radii come out alike at all distances.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from bench.camera_choice import CameraChoice, calibration
from bench.errors import BenchError
from bench.metrics.detection import match
from bench.sequences.dlr_pictures import on_picture

FloatArray = NDArray[np.float64]
Sighting = tuple[FloatArray, FloatArray]
"""Detections of one picture, (n, 2) pixels, and all mapped discs in the robot's frame, (m, 2) metres."""

PARAMETERS = ("height_m", "forward_m", "left_m", "pitch_deg", "roll_deg", "yaw_deg")
_SCALE = (0.1, 0.1, 0.1, 1.0, 1.0, 1.0)
_GATES_M = (0.45, 0.20, 0.15)  # wide enough for the bias first; the last is that of scoring
_ROW_WEIGHT = 2.0  # rows are half as dense as columns
_TAIL_PX = 2.0  # residuals beyond it count linearly
_LEAST = 50


def calibrated(camera: CameraChoice, sightings: Sequence[Sighting]) -> CameraChoice:
    """The camera with its mount fitted to mapped discs, the lens as it was.

    Raises
    ------
    BenchError
        When fewer than 50 detections lie near a mapped disc.
    """
    for gate in _GATES_M:
        pixels, discs = _pairs(camera, sightings, gate)
        if len(pixels) < _LEAST:
            raise BenchError(
                f"mount: {len(pixels)} detections within {gate:g} m of a mapped disc: too few to calibrate "
                f"the camera ({_LEAST} needed); lower calibrate_every or set it to 0"
            )
        start = [float(getattr(camera, name)) for name in PARAMETERS]
        found = least_squares(
            _residuals(camera, pixels, discs), start, x_scale=_SCALE, loss="soft_l1", f_scale=_TAIL_PX
        )
        camera = _moved(camera, found.x)
    return camera


def _moved(camera: CameraChoice, values: FloatArray) -> CameraChoice:
    return camera.model_copy(update={n: float(v) for n, v in zip(PARAMETERS, values, strict=True)})


def _residuals(
    camera: CameraChoice, pixels: FloatArray, discs: FloatArray
) -> Callable[[FloatArray], FloatArray]:
    def residuals(values: FloatArray) -> FloatArray:
        apart = on_picture(calibration(_moved(camera, values)), discs) - pixels
        return np.asarray((apart * (1.0, _ROW_WEIGHT)).ravel())

    return residuals


def _pairs(
    camera: CameraChoice, sightings: Sequence[Sighting], gate_m: float
) -> tuple[FloatArray, FloatArray]:
    view = calibration(camera)
    pixels, discs = [np.zeros((0, 2))], [np.zeros((0, 2))]
    for found, mapped in sightings:
        floor, _ = view.floor_points(found)
        seen = np.isfinite(floor).all(axis=1)
        pairs = match(floor[seen], mapped, gate_m)
        pixels.append(found[seen][pairs[:, 0]])
        discs.append(mapped[pairs[:, 1]])
    return np.concatenate(pixels), np.concatenate(discs)
