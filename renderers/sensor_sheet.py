"""What describes a camera's sensor, and how it is set; `renderers.sensor.Sensor` is both together.

Plain data, so that study files are checked without numba.
"""

from __future__ import annotations

from dataclasses import dataclass

MIDDLE_GREY = 0.18

MOST_GAIN_DB = 48.0
"""What the gain registers of machine vision sensors reach (Sony Pregius: 0…48 dB)."""


@dataclass(frozen=True)
class Sheet:
    """The camera itself and its lens, by their data sheet. The defaults are no product: a machine vision
    CMOS camera with large pixels, a filter for every channel of every pixel, and no flaws but shot and read
    noise.

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
        Of the ADC; full well is mapped to its largest number at 0 dB.
    dark_current_e_per_s : float
        At ``reference_temperature_c``; doubles every ``doubling_temperature_k`` up to ``temperature_c``.
    dsnu_e, prnu : float
        Standard deviations of the fixed patterns: electrons, and a share of the signal.
    colour_filter_array : str
        One of `renderers.colour_filter_array.ARRAYS`.
    demosaicing : str
        One of `renderers.demosaicing.methods`; only a mosaic needs it.
    sensitivities : str
        One of `renderers.colour_matrix.SENSITIVITIES`.
    """

    pixel_pitch_um: float = 6.0
    f_number: float = 2.0
    lens_transmission: float = 0.9
    quantum_efficiency: tuple[float, float, float] = (0.35, 0.45, 0.35)
    full_well_e: float = 20_000.0
    read_noise_e: float = 8.0
    bit_depth: int = 10
    black_level_dn: int = 16
    dark_current_e_per_s: float = 0.0
    reference_temperature_c: float = 25.0
    doubling_temperature_k: float = 8.0
    temperature_c: float = 25.0
    dsnu_e: float = 0.0
    prnu: float = 0.0
    colour_filter_array: str = "none"
    demosaicing: str = "malvar"
    sensitivities: str = "srgb"


@dataclass(frozen=True)
class Settings:
    """How the camera takes its pictures.

    Attributes
    ----------
    min_exposure_s, max_exposure_s : float
        Limits of the shutter; the longest leaves 30 pictures a second.
    exposure_s : float, optional
        A fixed exposure time; automatic exposure without one.
    gain_db : float
        Analogue gain, 20 log₁₀ of its factor: electrons become more digital numbers, and fewer fill the ADC.
    max_gain_db : float
        The most that automatic exposure amplifies, once the shutter is at its longest; no more than
        ``gain_db`` if that is higher.
    metering : str
        One of `renderers.sensor.METERINGS` (`renderers.metering`).
    metering_target : float
        Mean of the picture, as a share of what fills the ADC, that automatic exposure aims for.
    """

    min_exposure_s: float = 1e-5
    max_exposure_s: float = 0.033
    exposure_s: float | None = None
    gain_db: float = 0.0
    max_gain_db: float = 0.0
    metering: str = "average"
    metering_target: float = MIDDLE_GREY
