"""The camera of a study: its model, its lens, and where it sits on the robot."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, Literal

from pydantic import Field, model_validator

from bench.study_parts import Part, Positive
from renderers.camera import Camera, Fisheye, Intrinsics, Mount, Pinhole
from renderers.errors import RendererError
from vslam.camera import Calibration, mounting

FOV_DEG = 150.0
"""Across the picture: Table 4-1's ±75°."""


class OpticsChoice(Part):
    """What lens (`renderers.optics`) and open shutter (`renderers.motion_blur`) do: nothing by default."""

    vignetting: Literal["none", "natural"] = "none"
    blur_px: float = Field(0.0, ge=0, le=50)
    glare: float = Field(0.0, ge=0, lt=1)
    glare_radius_px: Positive = 4.0
    motion_blur: bool = False


class IntrinsicsChoice(Part):
    """Focal lengths (of a fisheye per radian) and principal point, pixels, as a calibration gives them."""

    fx: Positive
    fy: Positive
    cx: float
    cy: float


class CameraChoice(Part):
    """The robot's camera. 320 × 240 is Table 4-1.

    ``distortion`` is OpenCV's list for the model: (k1, k2, p1, p2[, k3[, k4, k5, k6]]) of a pinhole,
    (k1, k2, k3, k4) of a fisheye. ``intrinsics`` stand instead of ``fov_deg``. The mount is that of
    `renderers.camera.Mount`. ``source: dlr`` takes size, lens and mount from the DLR log's ``camera.json``
    when the study starts.
    """

    source: Literal["study", "dlr"] = "study"
    model: Literal["fisheye", "pinhole"] = "fisheye"
    width: int = Field(320, ge=16, le=4096)
    height: int = Field(240, ge=16, le=4096)
    fov_deg: float | None = Field(gt=0, lt=360)
    intrinsics: IntrinsicsChoice | None = None
    distortion: tuple[float, ...] = ()
    height_m: Positive = 1.2
    forward_m: float = 0.0
    left_m: float = 0.0
    pitch_deg: float = Field(25.0, ge=-90, le=90)
    yaw_deg: float = Field(0.0, ge=-180, le=180)
    roll_deg: float = Field(0.0, ge=-180, le=180)
    supersampling: int = Field(1, ge=1, le=8)
    optics: OpticsChoice = OpticsChoice()

    @model_validator(mode="before")
    @classmethod
    def _field_of_view_unless_intrinsics(cls, value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        return {"fov_deg": None if value.get("intrinsics") else FOV_DEG, **value}

    @model_validator(mode="after")
    def _possible(self) -> CameraChoice:
        if (self.fov_deg is None) == (self.intrinsics is None):
            raise ValueError("give either fov_deg or intrinsics")
        try:
            camera(self)
        except RendererError as error:
            raise ValueError(str(error).removeprefix("camera: ")) from None
        return self


def camera(choice: CameraChoice) -> Camera:
    """The camera that the renderer looks through.

    Raises
    ------
    RendererError
        For a camera that cannot be.
    """
    given = choice.intrinsics
    view = Intrinsics(given.fx, given.fy, given.cx, given.cy) if given else choice.fov_deg or FOV_DEG
    model = Fisheye if choice.model == "fisheye" else Pinhole
    return model(choice.width, choice.height, view, choice.distortion)


def mount(choice: CameraChoice) -> Mount:
    """Where the renderer puts the camera on the robot."""
    return Mount(**_mounted(choice))


def calibration(choice: CameraChoice) -> Calibration:
    """What the robot knows of its camera."""
    return Calibration(
        choice.model,
        choice.width,
        choice.height,
        **vars(camera(choice).intrinsics),
        T_robot_camera=mounting(**_mounted(choice)),
        distortion=choice.distortion,
    )


def _mounted(choice: CameraChoice) -> dict[str, float]:
    return {field.name: getattr(choice, field.name) for field in fields(Mount)}
