"""The parts of a study that say what the robot does: its tour, noise, detector, estimator and plans."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from bench.study_parts import Name, NotNegative, Part, Positive


class TourChoice(Part):
    """How the robot drives its tour; the speed is Table 4-1's."""

    speed_mps: Positive = 0.93
    frame_interval_s: Positive = 0.4


class OdometryNoise(Part):
    """Standard deviations of one motion increment, in proportion to its length and to its turn.

    Forward and lateral: the medians that the DLR log states for its own steps (σ per metre, steps over
    0.05 m). Heading: a turn is as uncertain as a metre, and straight driving adds 0.1° per step of 0.372 m,
    the upper end of the mild regime (0.05–0.1° per step) in which an EKF is still consistent; the DLR log
    itself states twenty times that, 0.098 rad/m.
    """

    sigma_forward_m_per_m: NotNegative = 0.023
    sigma_lateral_m_per_m: NotNegative = 0.024
    sigma_heading_rad_per_rad: NotNegative = 0.023
    sigma_heading_rad_per_m: NotNegative = 0.0047


class DepthNoise(Part):
    """σ_z = ``sigma_m_at_1m`` · z², the structured-light law of Khoshelham & Elberink (2012, eq. 10), which
    gives 1.4 mm at 1 m; no reading beyond ``max_m`` (Table 4-1's sensor range).
    """

    sigma_m_at_1m: NotNegative = 0.0014
    max_m: Positive = 12.0


class DiscChoice(Part):
    """What the detector looks for and how far it believes it (`vslam.detect.DetectorSettings`)."""

    min_radius_m: float = Field(0.10, ge=0.02, le=1)
    max_radius_m: float = Field(0.20, ge=0.02, le=1)
    max_misfit: float = Field(0.15, gt=0, le=1)
    max_sigma_m: Positive = 0.05
    tilt_sigma_deg: NotNegative = 0.0
    position_sigma_m: NotNegative = 0.0

    @model_validator(mode="after")
    def _in_order(self) -> DiscChoice:
        if not self.min_radius_m < self.max_radius_m:
            raise ValueError(
                f"min_radius_m {self.min_radius_m:g} must be below max_radius_m {self.max_radius_m:g}"
            )
        return self


class SlamChoice(Part):
    """The estimator by its registered names; ``gate`` is the probability of the χ² gate."""

    backend: Name = "ekf"
    association: Name = "icnn"
    observation: Name = "range_bearing"
    gate: Annotated[float, Field(gt=0, lt=1)] = 0.99


class NavigationTask(Part):
    """Random start–goal pairs that are planned on the estimated grid and judged on the true one."""

    pairs: int = Field(20, ge=1)
    resolution_m: Positive = 0.1
    robot_radius_m: Positive = 0.25
