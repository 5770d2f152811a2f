"""A camera's sensor as its data sheet describes it: photons, electrons, digital numbers.

The linear model of EMVA 1288 release 4.0, in its order: photons → quantum efficiency → PRNU on the mean →
Poisson, with the dark current's electrons → read noise, DSNU → full well → gain and black level → rounding.
So per pixel, with K = DN per electron, and temporal noise alone,

    mean      μ_y  = K (μ_e + μ_dark) + μ_black
    variance  σ_y² = K² (μ_e + μ_dark + σ_read²) + σ_q²,   σ_q² = 1/12 DN²

The ground truth is that of the ideal sensor of the same sheet: no noise, no dark current, no fixed patterns.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields, replace
from difflib import get_close_matches
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from renderers.colour_filter_array import ARRAYS, NO_ARRAY
from renderers.colour_matrix import SENSITIVITIES, SRGB, to_camera
from renderers.demosaicing import methods
from renderers.errors import RendererError
from renderers.gbuffer import F32
from renderers.sensor_presets import PRESETS
from renderers.sensor_sheet import MOST_GAIN_DB, Settings, Sheet
from renderers.shot_noise import NONE, convert, read_out

PHOTONS_PER_LUX = 1.09e16
"""Photons per m², s and lux of D65 between 400 and 700 nm (CIE D65 × V(λ), 683 lm/W)."""

METERINGS = ("average", "centre-weighted", "highlight-priority")


@dataclass(frozen=True)
class Sensor(Settings, Sheet):
    """A camera's sensor, the numbers of its lens, and how it is set (`renderers.sensor_sheet`).

    Attributes
    ----------
    serial_number : int
        Seed of the fixed patterns: two cameras of one type differ by it.
    """

    serial_number: int = 0

    def __post_init__(self) -> None:
        for name in _POSITIVE:
            value = getattr(self, name)
            if value is not None and not (np.isfinite(value) and value > 0):
                raise RendererError(f"sensor: {name} must be positive, not {value}")
        for name in ("read_noise_e", "dark_current_e_per_s", "dsnu_e", "prnu", "serial_number"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                raise RendererError(f"sensor: {name} must be ≥ 0, not {value}")
        if not all(0 < q <= 1 for q in (*self.quantum_efficiency, self.lens_transmission)):
            raise RendererError("sensor: quantum efficiencies and lens transmission must lie in 0…1")
        if not 8 <= self.bit_depth <= 16 or not 0 <= self.black_level_dn < 2**self.bit_depth // 2:
            raise RendererError("sensor: bit_depth must be 8…16 and black_level_dn below half of its range")
        if self.max_exposure_s < self.min_exposure_s:
            raise RendererError("sensor: max_exposure_s must not be below min_exposure_s")
        if self.prnu > 0.3:
            raise RendererError(f"sensor: prnu {self.prnu:g} is a share of the signal, at most 0.3")
        if not all(-50 <= t <= 150 for t in (self.temperature_c, self.reference_temperature_c)):
            raise RendererError("sensor: temperatures must lie in −50…150 °C")
        if not all(0 <= gain <= MOST_GAIN_DB for gain in (self.gain_db, self.max_gain_db)):
            raise RendererError(f"sensor: gain_db and max_gain_db must lie in 0…{MOST_GAIN_DB:g} dB")
        for name, known in _CHOICES.items():
            if getattr(self, name) not in known:
                raise RendererError(f"sensor: unknown {name} {getattr(self, name)!r}; use {', '.join(known)}")

    @property
    def gain_dn_per_e(self) -> float:
        """K: at 0 dB full well fills the ADC above its black level."""
        return (self.largest_dn - self.black_level_dn) / self.saturation_e

    @property
    def saturation_e(self) -> float:
        """Electrons beyond which the numbers clip: full well at 0 dB, the ADC's range when amplified."""
        return float(self.full_well_e / 10 ** (self.gain_db / 20))

    @property
    def separable(self) -> bool:
        """Each channel of a pixel is developed from its own number alone: no mosaic and no colour matrix."""
        return self.colour_filter_array == NO_ARRAY and self.sensitivities == SRGB

    def amplified(self, gain_db: float) -> Sensor:
        """The same sensor at another gain, such as the one that automatic exposure chose."""
        return self if gain_db == self.gain_db else replace(self, gain_db=gain_db)

    @property
    def largest_dn(self) -> int:
        """The ADC's largest number."""
        return int(2**self.bit_depth - 1)

    @property
    def electrons_per_luminance(self) -> NDArray[np.float64]:
        """(3,) electrons per cd/m² and second in each channel."""
        illuminance = np.pi * self.lens_transmission / (4 * self.f_number**2)
        area = (self.pixel_pitch_um * 1e-6) ** 2
        return illuminance * area * PHOTONS_PER_LUX * np.array(self.quantum_efficiency)

    def dark_electrons(self, seconds: float) -> float:
        """Expected thermal electrons of an exposure at the sensor's temperature (EMVA 1288, dark current)."""
        doublings = (self.temperature_c - self.reference_temperature_c) / self.doubling_temperature_k
        return float(self.dark_current_e_per_s * 2.0**doublings * seconds)


_POSITIVE = (
    "pixel_pitch_um",
    "f_number",
    "full_well_e",
    "min_exposure_s",
    "max_exposure_s",
    "metering_target",
    "exposure_s",
    "doubling_temperature_k",
)

_CHOICES = {
    "metering": METERINGS,
    "colour_filter_array": ARRAYS,
    "demosaicing": tuple(methods()),
    "sensitivities": SENSITIVITIES,
}


def preset(name: str, **overrides: Any) -> Sensor:
    """A sensor by name (`renderers.sensor_presets`), with other values where given.

    Raises
    ------
    RendererError
        For an unknown name or parameter, or values that are impossible together.
    """
    known = {f.name for f in fields(Sensor)}
    for given, names in ((name, set(PRESETS)), *((key, known) for key in overrides)):
        if given not in names:
            near = get_close_matches(given, names, n=2) or sorted(names)
            raise RendererError(f"sensor: unknown name {given!r}; did you mean {' or '.join(near)}?")
    return Sensor(**{**asdict(PRESETS[name]), **overrides})


def mean_electrons(sensor: Sensor, luminance: F32, seconds: float) -> F32:
    """Expected photo-electrons of each pixel behind each colour filter, before the full well clips them.

    Parameters
    ----------
    luminance : (H, W, 3) float32
        Linear sRGB, cd/m² per channel.
    seconds : float
        Exposure time.

    Returns
    -------
    (H, W, 3) float32
        Of which a mosaic's photosites have one channel each (`renderers.colour_filter_array`).
    """
    seen = to_camera(sensor.sensitivities, luminance)
    height, width, _ = seen.shape
    factors = per_row(sensor.electrons_per_luminance * seconds, width)
    return (seen.reshape(height, -1) * factors).reshape(seen.shape)


def per_row(channels: NDArray[np.float64], width: int) -> F32:
    """(width·3,) float32: a factor per channel, repeated along a row, as loops over whole rows are fast."""
    return np.tile(channels.astype(np.float32), width)


def expose(
    sensor: Sensor, electrons: F32, rng: np.random.Generator, seconds: float = 0.0
) -> NDArray[np.uint16]:
    """Record expected photo-electrons as the real sensor does: raw digital numbers with all noise.

    Parameters
    ----------
    electrons : float32, (H, W, 3) or (H, W)
        Expected photo-electrons, ≥ 0.
    seconds : float
        Exposure time, for the dark current.
    """
    response, offset = fixed_patterns(sensor, electrons.shape)
    return read_out(
        electrons,
        response,
        offset,
        sensor.dark_electrons(seconds),
        sensor.read_noise_e,
        sensor.full_well_e,
        sensor.gain_dn_per_e,
        sensor.black_level_dn,
        sensor.largest_dn,
        rng,
    )


def digitise(sensor: Sensor, electrons: F32) -> NDArray[np.uint16]:
    """What the ideal sensor records: clipped at full well, amplified, rounded, clipped to the ADC's range."""
    return convert(
        electrons, sensor.full_well_e, sensor.gain_dn_per_e, sensor.black_level_dn, sensor.largest_dn
    )


def fixed_patterns(sensor: Sensor, shape: tuple[int, ...]) -> tuple[F32, F32]:
    """PRNU as a factor per photosite and DSNU as electrons; both empty for a sensor without either.

    White noise over the photosites, as EMVA 1288 defines the two by their standard deviation alone.
    """
    if sensor.prnu == 0 and sensor.dsnu_e == 0:
        return NONE, NONE
    return _draw_patterns(sensor.prnu, sensor.dsnu_e, sensor.serial_number, shape)


@lru_cache(maxsize=4)
def _draw_patterns(prnu: float, dsnu: float, serial: int, shape: tuple[int, ...]) -> tuple[F32, F32]:
    rng = np.random.default_rng(np.random.SeedSequence([serial, *shape]))
    response = np.maximum(1 + prnu * rng.standard_normal(shape), 0).astype(np.float32)
    offset = (dsnu * rng.standard_normal(shape)).astype(np.float32)
    response.setflags(write=False)
    offset.setflags(write=False)
    return response, offset
