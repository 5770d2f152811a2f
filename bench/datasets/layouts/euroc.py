"""``euroc``: the folders of the EuRoC MAV data set (Burri et al. 2016), as visual SLAM systems read them.

The body frame is the robot's (x forward, y left, z up, on the floor), so ``T_BS`` of the camera is
``T_robot_camera`` and the ground truth is ``T_world_robot``. There is no inertial unit: its biases are 0, and
wheel odometry stands in ``odom0``, which EuRoC does not have. Time is nanoseconds since the start of the
tour, 19 digits long as EuRoC's, so that names sort by time. Pictures have colour. Distortion coefficients are
OpenCV's, of which a pinhole's first four are EuRoC's.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.datasets.layout import Files, FloatArray, Layout, Picture, Track
from bench.datasets.model import Row
from bench.pictures import encode_png, read_png

TRUTH_COLUMNS = (
    "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z [],"
    "v_RS_R_x [m s^-1],v_RS_R_y [m s^-1],v_RS_R_z [m s^-1],b_w_RS_S_x [rad s^-1],b_w_RS_S_y [rad s^-1],"
    "b_w_RS_S_z [rad s^-1],b_a_RS_S_x [m s^-2],b_a_RS_S_y [m s^-2],b_a_RS_S_z [m s^-2]"
)
ODOMETRY_COLUMNS = (
    "#timestamp [ns],dx_R [m],dy_R [m],dtheta_R [rad],var_dx [m^2],var_dy [m^2],var_dtheta [rad^2]"
)
NO_BIAS = ",0,0,0,0,0,0"


class EuRoC:
    """``mav0`` with ``cam0``, ``state_groundtruth_estimate0`` and ``odom0``."""

    summary = "EuRoC: mav0/cam0 with sensor.yaml, state_groundtruth_estimate0, odom0"
    suffix = ".png"
    error_unit = ""

    def files(self, picture: Picture) -> Files:
        """The picture by its time; see `Layout.files`."""
        return Files({_path(picture.stamp_s): encode_png(picture.recording.image)})

    def lists(self, track: Track, rows: Iterable[Row]) -> Iterator[tuple[str, Iterable[str]]]:
        """Each sensor's ``data.csv`` and ``sensor.yaml``; see `Layout.lists`."""
        yield "mav0/body.yaml", ["comment: glarebench\n"]
        yield "mav0/cam0/sensor.yaml", [_camera_yaml(track)]
        yield "mav0/cam0/data.csv", _table("#timestamp [ns],filename", (_named(row) for row in rows))
        truth = "mav0/state_groundtruth_estimate0"
        yield f"{truth}/sensor.yaml", [_sensor_yaml("visual-inertial", "exact, from the scene's tour")]
        yield f"{truth}/data.csv", _table(TRUTH_COLUMNS, _truth(track, rows))
        yield "mav0/odom0/sensor.yaml", [_sensor_yaml("odometry", "increments in the robot's frame before")]
        yield "mav0/odom0/data.csv", _table(ODOMETRY_COLUMNS, _odometry(track, rows))

    def load(self, folder: Path, row: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        """The picture; see `Layout.load`."""
        return {"image": read_png(folder / _path(row["stamp_s"]))}


def _nanoseconds(stamp_s: float) -> str:
    return f"{round(stamp_s * 1e9):019d}"


def _path(stamp_s: float) -> str:
    return f"mav0/cam0/data/{_nanoseconds(stamp_s)}.png"


def _named(row: Row) -> str:
    stamp = _nanoseconds(row.stamp_s)
    return f"{stamp},{stamp}.png"


def _table(heading: str, lines: Iterable[str]) -> Iterator[str]:
    yield f"{heading}\n"
    for line in lines:
        yield f"{line}\n"


def _truth(track: Track, rows: Iterable[Row]) -> Iterator[str]:
    """Pose, velocity and no biases of the robot at each frame; z is 0 on the floor."""
    tour = track.sequence.scene.tour
    velocity = _velocity(tour.poses[:, :2], tour.stamps)
    for row in rows:
        x, y, theta = row.pose
        pose = f"{x:.9f},{y:.9f},0,{np.cos(theta / 2):.12f},0,0,{np.sin(theta / 2):.12f}"
        vx, vy = velocity[row.frame]
        yield f"{_nanoseconds(row.stamp_s)},{pose},{vx:.9f},{vy:.9f},0{NO_BIAS}"


def _velocity(positions: FloatArray, stamps: FloatArray) -> FloatArray:
    """(n, 2) m/s in the world's frame: central differences, one-sided at both ends."""
    if len(stamps) < 2:
        return np.zeros_like(positions)
    return np.asarray(np.gradient(positions, stamps, axis=0))


def _odometry(track: Track, rows: Iterable[Row]) -> Iterator[str]:
    from bench.sequences.rendered import odometry

    increments = odometry(track.sequence.study, track.sequence.scene.tour.poses, seed=0)
    for row in rows:
        step = increments[row.frame]
        numbers = [*step.delta, *np.diag(step.covariance)]
        yield f"{_nanoseconds(row.stamp_s)},{','.join(f'{number:.9g}' for number in numbers)}"


def _camera_yaml(track: Track) -> str:
    camera = track.calibration
    model = "equidistant" if camera.model == "fisheye" else "radial-tangential"
    distortion = ", ".join(repr(float(k)) for k in camera.distortion or (0, 0, 0, 0))
    focal = f"{camera.fx:.9f}, {camera.fy:.9f}, {camera.cx:.9f}, {camera.cy:.9f}"
    return (
        _sensor_yaml("camera", track.sequence.scene.name, camera.T_robot_camera)
        + f"rate_hz: {1 / track.sequence.study.tour.frame_interval_s:g}\n"
        + f"resolution: [{camera.width}, {camera.height}]\n"
        + "camera_model: pinhole\n"
        + f"intrinsics: [{focal}] #fu, fv, cu, cv\n"
        + f"distortion_model: {model}\n"
        + f"distortion_coefficients: [{distortion}]\n"
    )


def _sensor_yaml(kind: str, comment: str, T_BS: FloatArray | None = None) -> str:
    matrix = np.eye(4) if T_BS is None else T_BS
    rows = ",\n         ".join(", ".join(f"{number:.12g}" for number in row) for row in matrix)
    return f"sensor_type: {kind}\ncomment: {comment}\nT_BS:\n  cols: 4\n  rows: 4\n  data: [{rows}]\n"


LAYOUTS: dict[str, Layout] = {"euroc": EuRoC()}
