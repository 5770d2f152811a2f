"""The presets, measured from their own flat fields by the EMVA 1288 reference package."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from renderers.colour_filter_array import behind_filters
from renderers.sensor import expose, preset

SIDE, SECONDS, LEVELS, STACK = 400, 0.02, 16, 24


@pytest.fixture(scope="module")
def emva1288():
    """The package calls a function that NumPy 2 removed; it means this."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(np, "asfarray", lambda a: np.asarray(a, dtype=np.float64), raising=False)
        from emva1288.process.data import Data1288
        from emva1288.process.loader import LoadImageData
        from emva1288.process.results import Results1288

        class Pictures(LoadImageData):
            def _load_imgs(self, pictures):
                self._shape.add(pictures[0].shape)
                return pictures

        yield lambda pictures: Results1288(Data1288(Pictures(pictures).data).data)


def flat_fields(sensor, photons, count, rng, side=SIDE):
    """Pictures of a monochrome sensor that ``photons`` fall on, per pixel and exposure."""
    electrons = np.full((side, side), photons * sensor.quantum_efficiency[1], dtype=np.float32)
    return [expose(sensor, electrons, rng, SECONDS) for _ in range(count)]


def red_sites(sensor, photons, count, rng):
    """The red photosites of pictures of a mosaic."""
    planes = np.broadcast_to(
        np.float32(photons) * np.float32(sensor.quantum_efficiency), (2 * SIDE, 2 * SIDE, 3)
    )
    row, column = divmod(sensor.colour_filter_array.index("R"), 2)
    mosaic = behind_filters(sensor.colour_filter_array, planes)
    return [expose(sensor, mosaic, rng, SECONDS)[row::2, column::2] for _ in range(count)]


def measurement(sensor, pictures=flat_fields, channel=1):
    """Pairs from dark to beyond saturation, and two stacks for the patterns (EMVA 1288, chapters 6 and 8)."""
    rng = np.random.default_rng(4)
    full = sensor.full_well_e / 10 ** (sensor.gain_db / 20) / sensor.quantum_efficiency[channel]
    temporal = {float(p): pictures(sensor, p, 2, rng) for p in np.linspace(0, 1.15 * full, LEVELS)}
    spatial = {float(p): pictures(sensor, p, STACK, rng) for p in (0.0, full / 2)}
    return {"temporal": {SECONDS: temporal}, "spatial": {SECONDS: spatial}}


POOR = {"dsnu_e": 30.0, "prnu": 0.03, "dark_current_e_per_s": 9_000.0, "read_noise_e": 25.0}


def check(found, sensor, channel=1):
    """Gain, quantum efficiency, temporal dark noise, PRNU and DSNU within 3 % of the sheet.

    Where dark noise is below 0.4 DN, the standard has quantisation hide it and states its upper limit, which
    is that of σ_y² = 0.24 DN² (EMVA 1288 release 4.0, 6.4).
    """
    K = (sensor.largest_dn - sensor.black_level_dn) / sensor.full_well_e * 10 ** (sensor.gain_db / 20)
    dark_noise = np.sqrt(sensor.read_noise_e**2 + sensor.dark_electrons(SECONDS))
    dark_noise = max(dark_noise, np.sqrt(0.24 - 1 / 12) / K)
    assert pytest.approx(K, rel=0.03) == found.K
    assert pytest.approx(sensor.quantum_efficiency[channel], rel=0.03) == found.QE / 100
    assert found.sigma_d == pytest.approx(dark_noise, rel=0.03)
    assert pytest.approx(sensor.prnu, rel=0.03) == found.PRNU1288 / 100
    assert pytest.approx(sensor.dsnu_e, rel=0.03) == found.DSNU1288


@pytest.mark.parametrize(
    ("name", "gain_db"),
    [
        ("machine-vision", 0.0),
        ("machine-vision", 12.0),
        ("webcam", 0.0),
        ("webcam", 12.0),
        ("old-robot", 0.0),
        ("poor", 0.0),
        ("poor", 12.0),
    ],
)
def test_reference_package_recovers_the_sheet(emva1288, name, gain_db):
    """Each preset at its own bit depth."""
    sensor = preset("standard", **POOR) if name == "poor" else preset(name)
    check(emva1288(measurement(sensor.amplified(gain_db))), sensor.amplified(gain_db))


def test_amplified_old_robot(emva1288):
    """At 12 dB zero cuts its noise of 3.5 DN unless black stands higher; and that noise hides the photons',
    so that K takes more photosites."""
    sensor = preset("old-robot", gain_db=12.0, black_level_dn=32)
    check(emva1288(measurement(sensor, partial(flat_fields, side=800))), sensor)


@pytest.mark.parametrize("name", ["machine-vision", "webcam"])
def test_red_photosites_of_a_mosaic_are_their_sheets(emva1288, name):
    sensor = preset(name)
    check(emva1288(measurement(sensor, red_sites, channel=0)), sensor, channel=0)
