"""From luminance to a recorded picture: optics, photons, electrons, digital numbers, sRGB.

The sensor is the linear model of EMVA 1288 release 4.0: photons → quantum efficiency → Poisson → read noise
→ full well → gain and black level → quantisation. So per pixel, with K = DN per electron,

    mean      μ_y  = K μ_e + μ_black
    variance  σ_y² = K² (μ_e + σ_read²) + σ_q²,   σ_q² = 1/12 DN²

The ground truth goes the same way without noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.errors import RendererError
from renderers.gbuffer import F32
from renderers.shot_noise import count_electrons

PHOTONS_PER_LUX = 1.09e16
"""Photons per m², s and lux of D65 between 400 and 700 nm (CIE D65 × V(λ), 683 lm/W)."""

MIDDLE_GREY = 0.18


@dataclass(frozen=True)
class Sensor:
    """A camera's optics and sensor by their data sheet.

    Attributes
    ----------
    pixel_pitch_um : float
        Edge of the square photosensitive area, µm.
    f_number, lens_transmission : float
        Image-plane illuminance is π T L / (4 N²) of the luminance L.
    quantum_efficiency : (r, g, b)
        Electrons per photon of 400–700 nm white light behind each colour filter.
    full_well_e, read_noise_e : float
        Electrons.
    bit_depth, black_level_dn : int
        Of the ADC; full well is mapped to its largest number.
    min_exposure_s, max_exposure_s : float
        Limits of the shutter.
    exposure_s : float, optional
        A fixed exposure time; automatic exposure without one.
    metering_target : float
        Mean of the picture, as a share of full well, that automatic exposure aims for.
    """

    pixel_pitch_um: float = 6.0
    f_number: float = 2.0
    lens_transmission: float = 0.9
    quantum_efficiency: tuple[float, float, float] = (0.35, 0.45, 0.35)
    full_well_e: float = 20_000.0
    read_noise_e: float = 8.0
    bit_depth: int = 10
    black_level_dn: int = 16
    min_exposure_s: float = 1e-5
    max_exposure_s: float = 0.008
    exposure_s: float | None = None
    metering_target: float = MIDDLE_GREY

    def __post_init__(self) -> None:
        positive = {
            "pixel_pitch_um": self.pixel_pitch_um,
            "f_number": self.f_number,
            "full_well_e": self.full_well_e,
            "min_exposure_s": self.min_exposure_s,
            "max_exposure_s": self.max_exposure_s,
            "metering_target": self.metering_target,
            "exposure_s": self.min_exposure_s if self.exposure_s is None else self.exposure_s,
        }
        for name, value in positive.items():
            if not (np.isfinite(value) and value > 0):
                raise RendererError(f"sensor: {name} must be positive, not {value}")
        if not all(0 < q <= 1 for q in (*self.quantum_efficiency, self.lens_transmission)):
            raise RendererError("sensor: quantum efficiencies and lens transmission must lie in 0…1")
        if not 8 <= self.bit_depth <= 16 or not 0 <= self.black_level_dn < 2**self.bit_depth // 2:
            raise RendererError("sensor: bit_depth must be 8…16 and black_level_dn below half of its range")
        if not (np.isfinite(self.read_noise_e) and self.read_noise_e >= 0):
            raise RendererError(f"sensor: read_noise_e must be ≥ 0, not {self.read_noise_e}")
        if self.max_exposure_s < self.min_exposure_s:
            raise RendererError("sensor: max_exposure_s must not be below min_exposure_s")

    @property
    def gain_dn_per_e(self) -> float:
        """K: full well fills the ADC above its black level."""
        return (2**self.bit_depth - 1 - self.black_level_dn) / self.full_well_e

    @property
    def electrons_per_luminance(self) -> NDArray[np.float64]:
        """(3,) electrons per cd/m² and second in each channel."""
        illuminance = np.pi * self.lens_transmission / (4 * self.f_number**2)
        area = (self.pixel_pitch_um * 1e-6) ** 2
        return illuminance * area * PHOTONS_PER_LUX * np.array(self.quantum_efficiency)


@dataclass(frozen=True, eq=False)
class Exposure:
    """The settings that one picture is taken with.

    Attributes
    ----------
    seconds : float
    white_balance : (3,) float64
        Factor on each channel, the smallest 1, so that a clipped pixel stays white.
    """

    seconds: float
    white_balance: NDArray[np.float64]


def meter(sensor: Sensor, luminance: F32, white: NDArray[np.float64]) -> Exposure:
    """Choose exposure time and white balance for a scene's luminance.

    Averaging metering: the exposure at which the mean over pixels and channels, each clipped at full well,
    is the target. The white balance makes light of the colour ``white`` grey.

    Parameters
    ----------
    luminance : (H, W, 3) float32, cd/m² per channel
    white : (3,) float64
        Linear sRGB of the light to be rendered white.
    """
    response = sensor.electrons_per_luminance / sensor.full_well_e
    balance = 1.0 / (response * np.maximum(white, 1e-6))
    balance /= balance.min()
    if sensor.exposure_s is not None:
        return Exposure(sensor.exposure_s, balance)
    fill_rate = (luminance[::4, ::4] * response.astype(np.float32)).astype(np.float64)
    low, high = np.log([sensor.min_exposure_s, sensor.max_exposure_s])
    for _ in range(24):  # the clipped mean grows with time: bisect its logarithm
        middle = (low + high) / 2
        if np.minimum(fill_rate * np.exp(middle), 1.0).mean() < sensor.metering_target:
            low = middle
        else:
            high = middle
    return Exposure(float(np.exp((low + high) / 2)), balance)


def mean_electrons(sensor: Sensor, luminance: F32, exposure: Exposure) -> F32:
    """Expected electrons in each pixel and channel, before the full well clips them."""
    return luminance * (sensor.electrons_per_luminance * exposure.seconds).astype(np.float32)


def expose(sensor: Sensor, electrons: F32, rng: np.random.Generator) -> NDArray[np.uint16]:
    """Record expected electrons with shot and read noise as raw digital numbers.

    Far above full well the count is clipped whatever its noise, so the expectation is bounded at twice the
    full well before it is drawn.
    """
    bounded = np.minimum(electrons, np.float32(2 * sensor.full_well_e))
    return digitise(sensor, count_electrons(bounded, sensor.read_noise_e, rng))


def digitise(sensor: Sensor, electrons: F32) -> NDArray[np.uint16]:
    """Clip at full well, apply gain and black level, round, clip to the ADC's range."""
    dn = np.minimum(electrons, np.float32(sensor.full_well_e)) * np.float32(sensor.gain_dn_per_e)
    dn += np.float32(sensor.black_level_dn + 0.5)  # truncation below then rounds to nearest
    np.clip(dn, 0, 2**sensor.bit_depth - 1, out=dn)
    return dn.astype(np.uint16)


def develop(sensor: Sensor, raw: NDArray[np.uint16], exposure: Exposure) -> NDArray[np.uint8]:
    """Raw numbers to an sRGB picture: black level, white balance, clip, IEC 61966-2-1 encoding."""
    numbers = np.arange(2**sensor.bit_depth, dtype=np.float64)
    linear = (numbers - sensor.black_level_dn) / (2**sensor.bit_depth - 1 - sensor.black_level_dn)
    balanced = np.clip(np.outer(linear, exposure.white_balance), 0.0, 1.0)
    picture = np.empty(raw.shape, dtype=np.uint8)
    _look_up(_encode(balanced), raw.reshape(-1, 3), picture.reshape(-1, 3))
    return picture


@njit(cache=True)
def _look_up(table: NDArray[np.uint8], raw: NDArray[np.uint16], out: NDArray[np.uint8]) -> None:
    """Each channel's number by its own column of the table: four times as fast as NumPy's indexing."""
    for i in range(len(raw)):
        for c in range(3):
            out[i, c] = table[raw[i, c], c]


def _encode(linear: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Linear 0…1 to 8-bit sRGB (IEC 61966-2-1)."""
    curve = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.round(255 * curve).astype(np.uint8)
