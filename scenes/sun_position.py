"""The clear sky of a place and time: where the sun stands, how bright sun and sky are, and of what colour.

Position: NREL's SPA (Reda & Andreas 2004). Irradiance: the model of Ineichen & Perez (2002) with the
monthly Linke turbidity of the place. Lux per watt and colour: the spectra of SPECTRL2 (Bird & Riordan 1986)
weighted with the CIE 1931 observer; its ȳ is V(λ).
"""

from __future__ import annotations

from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError
from scenes.model import Sky, Sun

FloatArray = NDArray[np.float64]

LUMEN_PER_WATT = 683.0
"""Luminous efficacy of 555 nm (CIE)."""

WATER_CM, OZONE_ATM_CM, AEROSOL_500NM, ALBEDO = 1.42, 0.34, 0.084, 0.2
"""Of the standard atmosphere of ASTM G-173."""

LOWEST_SPECTRUM_DEG = 2.0
"""SPECTRL2's plane-parallel air fits above it; a lower sun keeps this colour."""

BLUEST_K = 25_000.0
"""Where CIE's daylight locus ends."""


def clear_sky(
    latitude_deg: float, longitude_deg: float, time: datetime, altitude_m: float = 0.0
) -> tuple[Sun, Sky]:
    """Sun and sky over a place at a time.

    Parameters
    ----------
    latitude_deg, longitude_deg : float
        North and east positive.
    time : datetime
        With its time zone.
    altitude_m : float
        Above sea level.

    Returns
    -------
    sun, sky
        Dark (0 lux) when the sun is below the horizon. The elevation is as seen, refraction included.

    Raises
    ------
    SceneError
        If the place is not on the globe or the time has no zone.
    """
    if not (abs(latitude_deg) <= 90 and abs(longitude_deg) <= 180 and np.isfinite(altitude_m)):
        raise SceneError(f"sun: no place at latitude {latitude_deg}, longitude {longitude_deg}")
    if time.tzinfo is None:
        raise SceneError(f"sun: {time} has no time zone; give one, such as +00:00")
    import pandas as pd
    from pvlib.location import Location

    times = pd.DatetimeIndex([time])
    place = Location(latitude_deg, longitude_deg, altitude=altitude_m)
    position = place.get_solarposition(times, method="nrel_numpy")
    azimuth, elevation = (float(position[name].iloc[0]) for name in ("azimuth", "apparent_elevation"))
    if elevation <= 0:
        return Sun(azimuth, elevation, 0.0), Sky(0.0)
    watts = place.get_clearsky(times, model="ineichen", solar_position=position).iloc[0]
    direct, diffuse = _spectra(max(elevation, LOWEST_SPECTRUM_DEG), place, time.timetuple().tm_yday)
    sun_lux, sun_k = _lux_and_kelvin(*direct, float(watts["dni"]))
    sky_lux, sky_k = _lux_and_kelvin(*diffuse, float(watts["dhi"]))
    return Sun(azimuth, elevation, sun_lux, f"{sun_k:.0f}K"), Sky(sky_lux, f"{sky_k:.0f}K")


def _spectra(
    elevation_deg: float, place: object, day: int
) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
    """Wavelengths (nm) and spectral irradiance (W/m²/nm) of the direct beam, and of the sky on the ground."""
    from pvlib import atmosphere, spectrum

    zenith = 90.0 - elevation_deg
    found = spectrum.spectrl2(
        apparent_zenith=zenith,
        aoi=zenith,
        surface_tilt=0.0,
        ground_albedo=ALBEDO,
        surface_pressure=atmosphere.alt2pres(place.altitude),  # type: ignore[attr-defined]
        relative_airmass=atmosphere.get_relative_airmass(zenith),
        precipitable_water=WATER_CM,
        ozone=OZONE_ATM_CM,
        aerosol_turbidity_500nm=AEROSOL_500NM,
        dayofyear=day,
    )
    at = np.asarray(found["wavelength"], dtype=np.float64)
    direct, diffuse = (np.asarray(found[key], dtype=np.float64).reshape(-1) for key in ("dni", "dhi"))
    return (at, np.nan_to_num(direct)), (at, np.nan_to_num(diffuse))


def _lux_and_kelvin(wavelength: FloatArray, spectrum: FloatArray, watts: float) -> tuple[float, float]:
    """Illuminance of an irradiance (W/m²) with this spectrum, and its correlated colour temperature."""
    import colour

    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    nm = np.asarray(observer.wavelengths, dtype=np.float64)
    XYZ = np.trapezoid(observer.values * np.interp(nm, wavelength, spectrum)[:, None], nm, axis=0)
    lux = LUMEN_PER_WATT * float(XYZ[1]) * watts / float(np.trapezoid(spectrum, wavelength))
    x, y = XYZ[:2] / XYZ.sum()
    n = (x - 0.3320) / (0.1858 - y)  # McCamy 1992
    kelvin = 449 * n**3 + 3525 * n**2 + 6823.3 * n + 5520.33
    return lux, float(np.clip(kelvin, 1700.0, BLUEST_K))
