"""``tum``: TUM RGB-D (Sturm et al. 2012), with masks and the linear light split beside it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.datasets.files import as_json
from bench.datasets.layout import Files, Layout, Picture, Track
from bench.datasets.model import Row
from bench.pictures import encode_png, read_png
from bench.provenance import version

DEPTH_FACTOR = 5000
"""Grey levels per metre in depth pictures, as TUM RGB-D has them."""

LARGEST = 65535


class Tum:
    """Lists by time, z in 16-bit PNG at 5000 per metre, and the camera's pose."""

    summary = "TUM RGB-D: rgb, depth (z, metres × 5000), mask, diffuse, specular, groundtruth.txt"
    suffix = ".png"
    error_unit = "of the sensor's range, where the sum is inside it"

    def files(self, picture: Picture) -> Files:
        """Five PNGs; see `Layout.files`."""
        depth = np.round(picture.basis.depth * DEPTH_FACTOR)
        diffuse, specular, error = _linear(picture)
        content: dict[str, NDArray[Any]] = {
            "rgb": picture.recording.image,
            "depth": np.where(depth <= LARGEST, depth, 0).astype(np.uint16),  # no number beyond 13.1 m
            "mask": picture.recording.highlight,
            "diffuse": diffuse,
            "specular": specular,
        }
        return Files({_path(part, picture.frame): encode_png(p) for part, p in content.items()}, error)

    def lists(self, track: Track, rows: Iterable[Row]) -> Iterator[tuple[str, Iterable[str]]]:
        """Lists, poses, landmarks and what the numbers mean; see `Layout.lists`."""
        for part in ("rgb", "depth"):
            yield f"{part}.txt", _lines("timestamp filename", (_named(part, row) for row in rows))
        yield (
            "groundtruth.txt",
            _lines("timestamp tx ty tz qx qy qz qw", (_pose_line(track, row) for row in rows)),
        )
        yield "landmarks.csv", _landmarks(track)
        yield "meta.json", [as_json(_meta(track))]

    def load(self, folder: Path, row: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        """Picture, depth in metres, mask, light as shares of the sensor's range; see `Layout.load`."""
        image, depth, mask, diffuse, specular = (
            read_png(folder / _path(part, row["frame"]))
            for part in ("rgb", "depth", "mask", "diffuse", "specular")
        )
        return {
            "image": image,
            "depth": depth.astype(np.float32) / np.float32(DEPTH_FACTOR),
            "mask": mask > 0,
            "diffuse": diffuse.astype(np.float32) / np.float32(LARGEST),
            "specular": specular.astype(np.float32) / np.float32(LARGEST),
        }


def _path(part: str, frame: int) -> str:
    return f"{part}/{frame:06d}.png"


def _linear(picture: Picture) -> tuple[NDArray[np.uint16], NDArray[np.uint16], float]:
    """Both parts as 16-bit numbers, 65535 where the sensor clips; the largest error of their sum."""
    from renderers.sensor import mean_electrons

    exposure, (diffuse, specular) = picture.recording.exposure, picture.light
    sensor = picture.track.sequence.sensor.amplified(exposure.gain_db)
    diffuse, specular, full = (
        mean_electrons(sensor, light, exposure.seconds) / np.float32(sensor.saturation_e)
        for light in (diffuse, specular, diffuse + specular)
    )
    stored = [np.round(np.clip(part, 0, 1) * LARGEST).astype(np.uint16) for part in (diffuse, specular)]
    error = np.abs(full - sum(part / LARGEST for part in stored))[full < 1]
    return stored[0], stored[1], float(error.max(initial=0.0))


def _lines(heading: str, lines: Iterable[str]) -> Iterator[str]:
    yield f"# {heading}\n"
    for line in lines:
        yield f"{line}\n"


def _named(part: str, row: Row) -> str:
    return f"{row.stamp_s:.6f} {_path(part, row.frame)}"


def _pose_line(track: Track, row: Row) -> str:
    """A pose of the camera as TUM RGB-D writes it: stamp, position, quaternion (x y z w)."""
    from scipy.spatial.transform import Rotation

    T = track.T_world_camera(row.frame)
    numbers = [*T[:3, 3], *Rotation.from_matrix(T[:3, :3]).as_quat(canonical=True)]
    return " ".join([f"{row.stamp_s:.6f}", *(f"{number:.9f}" for number in numbers)])


def _landmarks(track: Track) -> Iterator[str]:
    yield "id,x_m,y_m,radius_m,colour\n"
    for mark in track.sequence.scene.landmarks:
        colour = "white" if mark.white else "black"
        yield f"{mark.id},{mark.position[0]:.6f},{mark.position[1]:.6f},{mark.radius:.6f},{colour}\n"


def _meta(track: Track) -> dict[str, object]:
    from renderers.colour_matrix import correction

    study, view = track.sequence.study, track.calibration
    return {
        "scene": track.sequence.scene.name,
        "illumination": asdict(track.illumination),
        "glarebench": version("glarebench"),
        "engine": track.engine,
        "seed": study.seed,
        "camera": {
            **{field.name: getattr(view, field.name) for field in fields(view)},
            "T_robot_camera": view.T_robot_camera.tolist(),
        },
        "poses": "groundtruth.txt holds T_world_camera = T_world_robot · T_robot_camera",
        "depth": {
            "factor": DEPTH_FACTOR,
            "meaning": "z in the camera frame, exact, without noise; 0 = none, or beyond 13.1 m",
        },
        "linear": (
            "diffuse + specular: 65535 = saturation, behind the colour filters, noise-free, clipped; "
            "times the white balance, then colour_matrix, it is linear sRGB"
        ),
        "colour_matrix": correction(study.sensor.sensitivities).tolist(),
        "mask": f"255 where specular light adds {study.sensor.highlight_threshold} grey levels or more",
        "sensor": study.sensor.model_dump(mode="json"),
        "per_picture": "exposure, gain and white balance stand in frames.csv at the data set's root",
    }


LAYOUTS: dict[str, Layout] = {"tum": Tum()}
