"""The sensor of a study: a preset or its own numbers, and how it is exposed."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from bench.study_parts import NotNegative, Part, Positive, Share
from renderers.sensor_presets import PRESETS
from renderers.sensor_sheet import MOST_GAIN_DB, Settings

Celsius = Annotated[float, Field(ge=-50, le=150)]
Decibel = Annotated[float, Field(ge=0, le=MOST_GAIN_DB)]


class SensorChoice(Part):
    """A sensor as EMVA 1288 describes it, and how it is exposed.

    ``preset`` names a camera of `renderers.sensor_presets`, whose numbers stand for the keys left out;
    none is fitted to a result. ``quantum_efficiency`` is for the R, G and B channel; ``prnu`` a share of the
    signal; ``colour_filter_array`` none or a Bayer array by its 2 × 2 cell; ``sensitivities`` the camera
    whose filters these are. Automatic exposure aims at the mean level ``target``, as a share of full scale
    (18 % grey), and where ``max_exposure_s`` is too short amplifies from ``gain_db`` up to ``max_gain_db``;
    ``highlight_threshold`` τ of the ground truth, in grey levels of 255.
    """

    preset: Literal["standard", "machine-vision", "webcam", "old-robot"] = "standard"
    bit_depth: int = Field(ge=8, le=16)
    black_level_dn: int = Field(ge=0)
    full_well_e: Positive
    read_noise_e: NotNegative
    quantum_efficiency: tuple[Share, Share, Share]
    pixel_pitch_um: Positive
    f_number: Positive
    lens_transmission: Share
    dark_current_e_per_s: NotNegative
    reference_temperature_c: Celsius
    doubling_temperature_k: Positive
    temperature_c: Celsius
    dsnu_e: NotNegative
    prnu: float = Field(ge=0, le=0.3)
    colour_filter_array: Literal["none", "RGGB", "BGGR", "GRBG", "GBRG"]
    demosaicing: Literal["bilinear", "malvar", "edge-aware"]
    sensitivities: Literal["srgb", "nikon-5100", "sigma-sd-merrill"]
    min_exposure_s: Positive = Settings.min_exposure_s
    max_exposure_s: Positive = Settings.max_exposure_s
    exposure: Literal["auto"] | Positive = "auto"
    gain_db: Decibel = Settings.gain_db
    max_gain_db: Decibel = Settings.max_gain_db
    metering: Literal["average", "centre-weighted", "highlight-priority"] = "average"
    target: Annotated[float, Field(gt=0, lt=1)] = Settings.metering_target
    highlight_threshold: int = Field(16, ge=1, le=255)

    @model_validator(mode="before")
    @classmethod
    def _from_preset(cls, value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        name = value.get("preset", "standard")
        known = isinstance(name, str) and name in PRESETS
        return {**asdict(PRESETS[name if known else "standard"]), **value}

    @model_validator(mode="after")
    def _exposure_range(self) -> SensorChoice:
        if self.min_exposure_s > self.max_exposure_s:
            raise ValueError(
                f"min_exposure_s {self.min_exposure_s:g} exceeds max_exposure_s {self.max_exposure_s:g}"
            )
        if self.black_level_dn >= 2**self.bit_depth // 2:
            raise ValueError(f"black_level_dn {self.black_level_dn}: must be below {2**self.bit_depth // 2}")
        return self
