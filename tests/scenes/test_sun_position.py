"""Where the sun stands and how bright it is, against NREL's tables and pvlib."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest

from scenes.errors import SceneError
from scenes.model import Sky, Sun
from scenes.sun_position import _lux_and_kelvin

NOON = datetime(2024, 6, 21, 12, 0, tzinfo=UTC)
PLACE = (48.1, 11.6)


def test_sun_stands_where_nrel_says():
    """The worked example of Reda & Andreas 2004, A.5: Golden, Colorado, 1830 m."""
    mst = timezone(timedelta(hours=-7))
    sun = Sun.at(39.742476, -105.1786, datetime(2003, 10, 17, 12, 30, 30, tzinfo=mst), 1830.14)
    assert sun.azimuth_deg == pytest.approx(194.34024, abs=0.01)
    assert sun.elevation_deg == pytest.approx(90 - 50.11162, abs=0.01)


@pytest.mark.parametrize("hour", [5, 8, 11, 14, 17])
def test_sun_agrees_with_pvlibs_spa(hour):
    import pandas as pd
    from pvlib import spa

    time = NOON.replace(hour=hour)
    stamp = pd.DatetimeIndex([time]).as_unit("ns").astype("int64").to_numpy() / 1e9
    delta_t = spa.calculate_deltat(time.year, time.month)
    truth = spa.solar_position(stamp, *PLACE, 0.0, 1013.25, 12.0, delta_t, 0.5667, numthreads=1)
    sun = Sun.at(*PLACE, time)
    assert sun.elevation_deg == pytest.approx(float(truth[2][0]), abs=0.01)
    assert sun.azimuth_deg == pytest.approx(float(truth[4][0]), abs=0.01)


def test_night_is_dark_and_no_error():
    midnight = NOON.replace(hour=23)
    assert Sun.at(*PLACE, midnight).elevation_deg < 0
    assert Sun.at(*PLACE, midnight).lux == 0 and Sky.at(*PLACE, midnight).lux == 0


def test_high_sun_of_a_clear_day():
    """ASTM G-173 (97 klx at air mass 1.5) is clearer than most air; the sky adds an eighth to a third."""
    sun, sky = Sun.at(*PLACE, NOON), Sky.at(*PLACE, NOON)
    assert 75_000 < sun.lux < 105_000
    assert 8_000 < sky.lux < 25_000
    assert 5_000 < float(sun.illuminant[:-1]) < 6_000 < float(sky.illuminant[:-1])


def test_setting_sun_is_dimmer_and_redder():
    lux, kelvin = zip(
        *(
            (s.lux, float(s.illuminant[:-1]))
            for s in (Sun.at(*PLACE, NOON.replace(hour=h)) for h in (12, 16, 18))
        ),
        strict=True,
    )
    assert lux[0] > lux[1] > lux[2] > 0
    assert kelvin[0] > kelvin[1] > kelvin[2] > 1700


def test_lux_per_watt_is_that_of_g173():
    """The direct beam of ASTM G-173 has 900 W/m² and 97 klx, 108 lm/W."""
    from pvlib.spectrum import get_reference_spectra

    table = get_reference_spectra(standard="ASTM G173-03")
    wavelength, direct = table.index.to_numpy(dtype=float), table["direct"].to_numpy()
    lux, kelvin = _lux_and_kelvin(wavelength, direct, float(np.trapezoid(direct, wavelength)))
    assert lux == pytest.approx(97_000, rel=0.01)
    assert kelvin == pytest.approx(5300, abs=200)


def test_equal_energy_spectrum_at_one_wavelength():
    """A narrow line at 555 nm has 683 lm/W."""
    at = np.linspace(400.0, 700.0, 3001)
    lux, _ = _lux_and_kelvin(at, np.exp(-(((at - 555) / 2.0) ** 2)), 1.0)
    assert lux == pytest.approx(683.0, rel=0.005)


@pytest.mark.parametrize(
    ("place", "time"),
    [
        ((91.0, 0.0), NOON),
        ((0.0, 200.0), NOON),
        ((float("nan"), 0.0), NOON),
        (PLACE, NOON.replace(tzinfo=None)),
    ],
)
def test_no_such_place_or_time(place, time):
    with pytest.raises(SceneError, match=r"no place|no time zone"):
        Sun.at(*place, time)
