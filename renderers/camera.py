"""Cameras: where each pixel looks. OpenCV axes (x right, y down, z forward); pixel centres at integers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from renderers.errors import RendererError

FloatArray = NDArray[np.float64]


class Camera(Protocol):
    """A camera model of ``width`` × ``height`` pixels; a value, equal and hashable by its parameters."""

    def __hash__(self) -> int: ...

    @property
    def width(self) -> int:
        """Columns."""

    @property
    def height(self) -> int:
        """Rows."""

    def unproject(self, pixels: FloatArray) -> FloatArray:
        """(..., 2) pixels (u, v) to (..., 3) unit directions in the camera frame."""

    def project(self, points: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """(..., 3) points in the camera frame to (..., 2) pixels, and where they lie inside the picture."""

    def enlarged(self, factor: int) -> Camera:
        """The same view with ``factor`` times as many pixels along each side."""


@lru_cache(maxsize=8)
def pixel_rays(camera: Camera) -> FloatArray:
    """(H, W, 3) float64: each pixel's unit direction in the camera frame; read-only, as it is kept."""
    rays = camera.unproject(pixel_grid(camera))
    rays.setflags(write=False)
    return rays


def pixel_grid(camera: Camera) -> FloatArray:
    """(H, W, 2) float64: each pixel's own (u, v)."""
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    return np.stack([u, v], axis=-1).astype(np.float64)


def _check(width: int, height: int, fov_deg: float, largest_deg: float) -> None:
    if width < 1 or height < 1 or not 0 < fov_deg < largest_deg:
        raise RendererError(
            f"camera {width} × {height}, {fov_deg}°: sides must be positive, "
            f"the field of view above 0° and below {largest_deg}°"
        )


def _inside(pixels: FloatArray, camera: Camera) -> NDArray[np.bool_]:
    u, v = pixels[..., 0], pixels[..., 1]
    return (u >= -0.5) & (u < camera.width - 0.5) & (v >= -0.5) & (v < camera.height - 0.5)


@dataclass(frozen=True)
class Pinhole:
    """A pinhole camera with square pixels and a centred principal point; ``fov_deg`` is across the width."""

    width: int
    height: int
    fov_deg: float

    def __post_init__(self) -> None:
        _check(self.width, self.height, self.fov_deg, 180.0)

    @property
    def focal(self) -> float:
        """Focal length in pixels."""
        return float(self.width / 2 / np.tan(np.radians(self.fov_deg) / 2))

    def unproject(self, pixels: FloatArray) -> FloatArray:
        """See `Camera.unproject`."""
        x = (pixels[..., 0] - (self.width - 1) / 2) / self.focal
        y = (pixels[..., 1] - (self.height - 1) / 2) / self.focal
        rays = np.stack([x, y, np.ones_like(x)], axis=-1)
        return rays / np.linalg.norm(rays, axis=-1, keepdims=True)

    def project(self, points: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """See `Camera.project`."""
        z = np.where(points[..., 2] > 1e-9, points[..., 2], np.nan)
        centre = np.array([(self.width - 1) / 2, (self.height - 1) / 2])
        pixels = self.focal * points[..., :2] / z[..., None] + centre
        return pixels, _inside(pixels, self)

    def enlarged(self, factor: int) -> Pinhole:
        """See `Camera.enlarged`."""
        return Pinhole(self.width * factor, self.height * factor, self.fov_deg)


@dataclass(frozen=True)
class Fisheye:
    """An equidistant fisheye, r = f θ (OpenCV's fisheye with zero k); ``fov_deg`` is across the width."""

    width: int
    height: int
    fov_deg: float

    def __post_init__(self) -> None:
        _check(self.width, self.height, self.fov_deg, 360.0)

    @property
    def focal(self) -> float:
        """Pixels per radian."""
        return float(self.width / np.radians(self.fov_deg))

    def unproject(self, pixels: FloatArray) -> FloatArray:
        """See `Camera.unproject`."""
        x = (pixels[..., 0] - (self.width - 1) / 2) / self.focal
        y = (pixels[..., 1] - (self.height - 1) / 2) / self.focal
        theta = np.hypot(x, y)
        stretch = np.sinc(theta / np.pi)  # sin θ / θ, 1 on the axis
        return np.stack([x * stretch, y * stretch, np.cos(theta)], axis=-1)

    def project(self, points: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """See `Camera.project`."""
        r = np.hypot(points[..., 0], points[..., 1])
        theta = np.arctan2(r, points[..., 2])
        scale = np.where(r > 1e-12, self.focal * theta / np.maximum(r, 1e-12), 0.0)
        centre = np.array([(self.width - 1) / 2, (self.height - 1) / 2])
        pixels = points[..., :2] * scale[..., None] + centre
        return pixels, _inside(pixels, self)

    def enlarged(self, factor: int) -> Fisheye:
        """See `Camera.enlarged`."""
        return Fisheye(self.width * factor, self.height * factor, self.fov_deg)


@dataclass(frozen=True)
class Mount:
    """Where the camera sits on the robot: above the origin, tilted down."""

    height_m: float = 1.2
    forward_m: float = 0.0
    pitch_deg: float = 25.0

    @property
    def T_robot_camera(self) -> FloatArray:
        """(4, 4): maps camera coordinates to robot coordinates."""
        p = np.radians(self.pitch_deg)
        forward, down = np.array([np.cos(p), 0, -np.sin(p)]), np.array([-np.sin(p), 0, -np.cos(p)])
        T = np.eye(4)
        T[:3, :3] = np.stack([np.array([0.0, -1.0, 0.0]), down, forward], axis=1)
        T[:3, 3] = [self.forward_m, 0.0, self.height_m]
        return T


def T_world_robot(pose: FloatArray) -> FloatArray:
    """(4, 4) from (x, y, θ): maps robot coordinates to world coordinates (eq. 3-7)."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    T = np.eye(4)
    T[:2, :2] = [[c, -s], [s, c]]
    T[:2, 3] = pose[:2]
    return T
