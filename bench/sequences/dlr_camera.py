"""The DLR robot's own camera, as ``camera.json`` beside the log describes it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from bench.camera_choice import CameraChoice, IntrinsicsChoice
from bench.errors import BenchError

CAMERA = "camera.json"
WIDTH, HEIGHT = 768, 288
"""One PAL field: rows are half as dense as columns."""

_KEYS = ("fx", "fy", "cx", "cy", "k1", "k2", "x0_left", "f0_fwd", "h", "pitch", "roll", "yaw")


def robot_camera(folder: Path) -> CameraChoice:
    """Lens and mount of the camera that took the log's pictures.

    The file has angles in rad, to the left (yaw), down (pitch), and counter-clockwise as the camera sees it
    (roll), applied in this order, and metres.

    Raises
    ------
    BenchError
        If the folder has no such file, which the public sources lack, or it does not hold a camera.
    """
    path = folder / CAMERA
    try:
        number = {key: float(value) for key, value in json.loads(path.read_text(encoding="ascii")).items()}
        n = [number[key] for key in _KEYS]
    except OSError as error:
        raise BenchError(
            f"{path}: {error.strerror}; the public sources of the log lack it, so choose another camera"
        ) from None
    except (ValueError, TypeError, AttributeError, KeyError) as error:
        raise BenchError(f"{path}: no camera ({error}); it should hold numbers {', '.join(_KEYS)}") from None
    fx, fy, cx, cy, k1, k2, left, forward, height, pitch, roll, yaw = n
    try:
        return CameraChoice(
            model="pinhole",
            width=WIDTH,
            height=HEIGHT,
            fov_deg=None,
            intrinsics=IntrinsicsChoice(fx=fx, fy=fy, cx=cx, cy=cy),
            distortion=(k1, k2, 0.0, 0.0),
            height_m=height,
            forward_m=forward,
            left_m=left,
            pitch_deg=float(np.degrees(pitch)),
            roll_deg=-float(np.degrees(roll)),
            yaw_deg=float(np.degrees(yaw)),
        )
    except ValidationError as error:
        raise BenchError(f"{path}: no possible camera: {error.errors()[0]['msg']}") from None
