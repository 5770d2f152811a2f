"""Cameras: where each pixel looks. OpenCV axes (x right, y down, z forward); pixel centres at integers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import astuple, dataclass, replace
from functools import cached_property, lru_cache
from typing import ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from renderers.distortion import Distortion
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

    @property
    def intrinsics(self) -> Intrinsics:
        """Focal lengths and principal point."""

    def unproject(self, pixels: FloatArray) -> FloatArray:
        """(..., 2) pixels (u, v) to (..., 3) unit directions in the camera frame, NaN where there is none."""

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


@dataclass(frozen=True)
class Intrinsics:
    """Focal lengths and principal point in pixels, as ``cv2.calibrateCamera`` gives them."""

    fx: float
    fy: float
    cx: float
    cy: float


@dataclass(frozen=True)
class _Lens(ABC):
    """What the two models share: size, intrinsics and distortion.

    Attributes
    ----------
    width, height : int
        Pixels.
    view : float or Intrinsics
        Field of view across the width, degrees (square pixels, a centred principal point, tangential
        distortion not counted), or the intrinsics.
    distortion : tuple of float
        OpenCV's coefficients for the model (`renderers.distortion.Distortion`), or none.

    Raises
    ------
    RendererError
        For a camera that cannot be, or a distortion that folds inside the picture.
    """

    width: int
    height: int
    view: float | Intrinsics
    distortion: tuple[float, ...] = ()

    _widest_deg: ClassVar[float]

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise RendererError(f"camera {self.width} × {self.height}: both sides must be positive")
        if isinstance(self.view, Intrinsics):
            numbers = astuple(self.view)
            if not np.isfinite(numbers).all() or min(self.view.fx, self.view.fy) <= 0:
                raise RendererError(f"camera: {self.view}: finite numbers, fx and fy positive")
        elif not 0 < self.view < self._widest_deg:
            raise RendererError(
                f"camera: {self.view}° across: the field of view of a {self._name} "
                f"must lie above 0° and below {self._widest_deg:g}°"
            )
        self._refuse_folds()

    @cached_property
    def intrinsics(self) -> Intrinsics:
        """The given ones, or those of the field of view."""
        if isinstance(self.view, Intrinsics):
            return self.view
        focal = self.width / 2 / self._bent.radius(self._to_plane(np.radians(self.view) / 2))
        return Intrinsics(focal, focal, (self.width - 1) / 2, (self.height - 1) / 2)

    @property
    def focal(self) -> float:
        """Focal length along the rows in pixels, of a fisheye per radian."""
        return self.intrinsics.fx

    def unproject(self, pixels: FloatArray) -> FloatArray:
        """See `Camera.unproject`."""
        return self._rays(self._bent.invert(self._plane(pixels)))

    def project(self, points: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """See `Camera.project`."""
        plane = self._flatten(points)
        view = self.intrinsics
        with np.errstate(invalid="ignore", over="ignore"):
            bent = plane if self._bent.absent else self._bent.apply(plane)[0]
            pixels = bent * (view.fx, view.fy) + (view.cx, view.cy)
            # OpenCV's polynomials bring what lies far outside back into the picture
            near = np.hypot(plane[..., 0], plane[..., 1]) <= self._reach
        return pixels, near & _inside(pixels, self)

    def enlarged(self, factor: int) -> Self:
        """See `Camera.enlarged`."""
        view = self.view
        if isinstance(view, Intrinsics):
            centre = ((c + 0.5) * factor - 0.5 for c in (view.cx, view.cy))
            view = Intrinsics(view.fx * factor, view.fy * factor, *centre)
        return replace(self, width=self.width * factor, height=self.height * factor, view=view)

    @property
    def _name(self) -> str:
        return type(self).__name__.lower()

    @property
    @abstractmethod
    def _bent(self) -> Distortion:
        """What distorts the plane."""

    @abstractmethod
    def _to_plane(self, theta: float) -> float:
        """|p| of a direction so far off the axis, rad."""

    @abstractmethod
    def _rays(self, plane: FloatArray) -> FloatArray:
        """(..., 3) unit directions of (..., 2) points of the plane."""

    @abstractmethod
    def _flatten(self, points: FloatArray) -> FloatArray:
        """(..., 2) points of the plane that show (..., 3) points in the camera frame, NaN where none does."""

    def _plane(self, pixels: FloatArray) -> FloatArray:
        view = self.intrinsics
        return (pixels - (view.cx, view.cy)) / (view.fx, view.fy)

    @cached_property
    def _seen(self) -> FloatArray:
        """(n, 2) points of the plane that the picture's grid shows, NaN where the model has none."""
        return self._bent.invert(self._plane(_grid(self.width, self.height)))

    @cached_property
    def _reach(self) -> float:
        """|p| of the farthest point that the picture shows, and a thousandth."""
        return 1.001 * float(np.hypot(self._seen[:, 0], self._seen[:, 1]).max())

    def _refuse_folds(self) -> None:
        missing = np.isnan(self._seen[:, 0])
        if missing.any():
            u, v = _grid(self.width, self.height)[np.argmax(missing)]
            why = f"distortion {list(self.distortion)} folds" if self.distortion else "180° off the axis lies"
            raise RendererError(
                f"camera {self.width} × {self.height}: no direction has its image at ({u:g}, {v:g}), "
                f"as this {self._name}'s {why} inside the picture"
            )


@lru_cache(maxsize=8)
def _grid(width: int, height: int, along: int = 33) -> FloatArray:
    """(n, 2) float64: ``along``² pixels from edge to edge, the picture's outline among them."""
    u, v = np.meshgrid(np.linspace(-0.5, width - 0.5, along), np.linspace(-0.5, height - 0.5, along))
    return np.stack([u, v], axis=-1).reshape(-1, 2)


def _inside(pixels: FloatArray, camera: Camera) -> NDArray[np.bool_]:
    u, v = pixels[..., 0], pixels[..., 1]
    return (u >= -0.5) & (u < camera.width - 0.5) & (v >= -0.5) & (v < camera.height - 0.5)


@dataclass(frozen=True)
class Pinhole(_Lens):
    """A pinhole camera with the distortion of ``cv2.projectPoints``: (k1, k2, p1, p2[, k3[, k4, k5, k6]])."""

    _widest_deg: ClassVar[float] = 180.0

    @cached_property
    def _bent(self) -> Distortion:
        return Distortion.pinhole(self.distortion)

    def _to_plane(self, theta: float) -> float:
        return float(np.tan(theta))

    def _rays(self, plane: FloatArray) -> FloatArray:
        rays = np.concatenate([plane, np.ones_like(plane[..., :1])], axis=-1)
        return rays / np.linalg.norm(rays, axis=-1, keepdims=True)

    def _flatten(self, points: FloatArray) -> FloatArray:
        z = np.where(points[..., 2] > 1e-9, points[..., 2], np.nan)
        return points[..., :2] / z[..., None]


@dataclass(frozen=True)
class Fisheye(_Lens):
    """A fisheye as ``cv2.fisheye``, θ' = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸); equidistant without any k."""

    _widest_deg: ClassVar[float] = 360.0

    @cached_property
    def _bent(self) -> Distortion:
        return Distortion.fisheye(self.distortion)

    def _to_plane(self, theta: float) -> float:
        return theta

    def _rays(self, plane: FloatArray) -> FloatArray:
        theta = np.hypot(plane[..., 0], plane[..., 1])[..., None]
        return np.concatenate([plane * np.sinc(theta / np.pi), np.cos(theta)], axis=-1)  # sin θ / θ

    def _flatten(self, points: FloatArray) -> FloatArray:
        r = np.hypot(points[..., 0], points[..., 1])
        theta = np.arctan2(r, points[..., 2])
        scale = np.where(r > 1e-12, theta / np.maximum(r, 1e-12), 0.0)
        return points[..., :2] * scale[..., None]


@dataclass(frozen=True)
class Mount:
    """Where the camera sits on the robot, above its origin, and where it looks.

    It is turned to the left by ``yaw_deg``, then tilted down by ``pitch_deg``, then about its optical axis by
    ``roll_deg``, clockwise as it sees it.
    """

    height_m: float = 1.2
    forward_m: float = 0.0
    pitch_deg: float = 25.0
    left_m: float = 0.0
    yaw_deg: float = 0.0
    roll_deg: float = 0.0

    @property
    def T_robot_camera(self) -> FloatArray:
        """(4, 4): maps camera coordinates to robot coordinates."""
        p, y, r = np.radians([self.pitch_deg, self.yaw_deg, self.roll_deg])
        turned = np.array([[np.cos(y), -np.sin(y), 0], [np.sin(y), np.cos(y), 0], [0, 0, 1]])
        forward, down = np.array([np.cos(p), 0, -np.sin(p)]), np.array([-np.sin(p), 0, -np.cos(p)])
        tilted = np.stack([np.array([0.0, -1.0, 0.0]), down, forward], axis=1)
        rolled = np.array([[np.cos(r), -np.sin(r), 0], [np.sin(r), np.cos(r), 0], [0, 0, 1]])
        T = np.eye(4)
        T[:3, :3] = turned @ tilted @ rolled
        T[:3, 3] = [self.forward_m, self.left_m, self.height_m]
        return T


def T_world_robot(pose: FloatArray) -> FloatArray:
    """(4, 4) from (x, y, θ): maps robot coordinates to world coordinates (eq. 3-7)."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    T = np.eye(4)
    T[:2, :2] = [[c, -s], [s, c]]
    T[:2, 3] = pose[:2]
    return T
