"""The presets, measured from their own flat fields by the EMVA 1288 reference package."""

from __future__ import annotations

import numpy as np
import pytest

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


def flat_fields(sensor, photons, count, rng):
    """Pictures of a monochrome sensor that ``photons`` fall on, per pixel and exposure."""
    electrons = np.full((SIDE, SIDE), photons * sensor.quantum_efficiency[1], dtype=np.float32)
    return [expose(sensor, electrons, rng, SECONDS) for _ in range(count)]


def measurement(sensor):
    """Pairs from dark to beyond full well, and two stacks for the patterns (EMVA 1288, chapters 6 and 8)."""
    rng = np.random.default_rng(4)
    full = sensor.full_well_e / sensor.quantum_efficiency[1]
    temporal = {float(p): flat_fields(sensor, p, 2, rng) for p in np.linspace(0, 1.15 * full, LEVELS)}
    spatial = {float(p): flat_fields(sensor, p, STACK, rng) for p in (0.0, full / 2)}
    return {"temporal": {SECONDS: temporal}, "spatial": {SECONDS: spatial}}


CAMERAS = [
    preset("machine-vision"),
    preset("webcam", bit_depth=12, black_level_dn=64),  # its own 10 bit hide its read noise of 0.3 DN
    preset("old-robot"),
    preset("standard", dsnu_e=30.0, prnu=0.03, dark_current_e_per_s=9_000.0, read_noise_e=25.0),
]


@pytest.mark.parametrize("sensor", CAMERAS, ids=["machine-vision", "webcam", "old-robot", "poor"])
def test_reference_package_recovers_the_sheet(emva1288, sensor):
    """Gain, quantum efficiency, temporal dark noise, PRNU and DSNU within 3 %."""
    found = emva1288(measurement(sensor))
    dark_noise = np.sqrt(sensor.read_noise_e**2 + sensor.dark_electrons(SECONDS))
    assert pytest.approx(sensor.gain_dn_per_e, rel=0.03) == found.K
    assert pytest.approx(sensor.quantum_efficiency[1], rel=0.03) == found.QE / 100
    assert found.sigma_d == pytest.approx(dark_noise, rel=0.03)
    assert pytest.approx(sensor.prnu, rel=0.03) == found.PRNU1288 / 100
    assert pytest.approx(sensor.dsnu_e, rel=0.03) == found.DSNU1288
