"""Drives as parts of a study: where the robot went, and what it measured on the way."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from bench.camera_choice import CameraChoice
from bench.filter_choice import FilterChoice
from bench.robot_choice import OdometryNoise, TourChoice
from bench.scene_choice import SceneChoice
from bench.scenes_study import LightLevel
from bench.sensor_choice import SensorChoice
from bench.study_parts import Name, Part, Positive, Share


class VirtualSensor(Part):
    """A sensor that sees every disc within range and field of view, walls or not, with a stated probability.

    ``detection`` is the probability of each look; ``half_angle_deg`` counts to either side. The noise is that
    of range and bearing; its default is the median that the DLR log states for its own observations.
    """

    range_m: Positive = 12.0
    half_angle_deg: float = Field(75.0, gt=0, le=180)
    detection: Share = 0.6
    sigma_range_m: Positive = 0.05
    sigma_bearing_deg: Positive = 1.0


class SimulatedOdometry(Part):
    """Increments with independent noise of the same standard deviations at each step.

    ``measured``: the robot reads the true increment plus noise. ``truth_fed``: it reads the true increment,
    as the dissertation has it, while the filter still believes in the stated noise; a robot has no such
    odometry, and what is scored then is no localisation.
    """

    protocol: Literal["measured", "truth_fed"] = "measured"
    sigma_forward_m: Positive = 0.02
    sigma_lateral_m: Positive = 0.02
    sigma_heading_deg: Positive = 0.1


class RecordedDrive(Part):
    """The DLR log's own odometry and observations, with annotated ids."""

    source: Literal["recorded"]
    name: Name = "dlr"


class VirtualDrive(Part):
    """A virtual sensor along the true track of the DLR log, among its 576 discs."""

    source: Literal["virtual"]
    name: Name = "dlr-virtual"
    speed_mps: Positive = 0.93
    frame_interval_s: Positive = 0.5
    sensor: VirtualSensor = VirtualSensor.model_validate({})
    odometry: SimulatedOdometry = SimulatedOdometry.model_validate({})


class LoopDrive(Part):
    """A virtual sensor on laps round a rectangle with rounded corners, discs scattered along it."""

    source: Literal["loop"]
    name: Name = "loop"
    length_m: float = Field(20.0, ge=4)
    width_m: float = Field(10.0, ge=4)
    laps: int = Field(2, ge=1)
    landmarks: int = Field(60, ge=1)
    speed_mps: Positive = 0.93
    frame_interval_s: Positive = 0.5
    sensor: VirtualSensor = VirtualSensor.model_validate({})
    odometry: SimulatedOdometry = SimulatedOdometry.model_validate({})


class FileDrive(Part):
    """A landmark log in a text file of yours, with its own ids (`bench.sequences.landmark_log`).

    Its vertices are the reference; of a file without them, the smoothed solution of its own measurements is.
    """

    source: Literal["file"]
    path: str = Field(min_length=1)
    name: Name = "log"


class RenderedDrive(Part):
    """What the detector finds in the rendered pictures of a scene's tour (`bench.sequences.toured`).

    Each detection has the id of the disc that it shows, one of nothing none. ``light`` is in proportion to
    the scene's own; ``odometry`` is drawn anew for each repetition, the pictures stay.
    """

    source: Literal["rendered"]
    name: Name = "rendered"
    scene: SceneChoice = SceneChoice()
    light: LightLevel = LightLevel(name="lamps", lamps=1.0)
    filter: FilterChoice = FilterChoice(name="none")
    camera: CameraChoice = CameraChoice.model_validate({})
    sensor: SensorChoice = SensorChoice.model_validate({})
    tour: TourChoice = TourChoice()
    odometry: OdometryNoise = OdometryNoise()


AnyDrive = RecordedDrive | VirtualDrive | LoopDrive | FileDrive | RenderedDrive
