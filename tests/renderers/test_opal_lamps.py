"""A lamp's globe by other light: white, and no part of its own light."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.camera import Mount, Pinhole
from renderers.irradiance import DIRECT_ONLY
from renderers.mesh import OPAL
from scenes.model import Bulb, Sun

CAMERA, EYE = Pinhole(64, 48, 20.0), Mount(height_m=1.0, pitch_deg=0.0)
BEHIND = Sun(azimuth_deg=270.0, elevation_deg=0.5, lux=1.0)  # the robot looks east, the sun past it
LAMP = Bulb((2.0, 0.0, 1.0), 1.0, radius=0.15)


@pytest.fixture(scope="module")
def basis(renderer_of, scene_of):
    view = renderer_of(scene_of(bulbs=[LAMP], sun=BEHIND), CAMERA, EYE, quality=DIRECT_ONLY)
    return view.render(np.zeros(3))


def test_a_lamp_that_is_off_is_white_glass_in_the_sun(basis):
    """Lambert's ρ E / π where the globe faces the sun, its facets turned by up to 11° twice; no gloss."""
    lit = basis.diffuse[basis.layers.index("sun"), 22:26, 30:34]
    np.testing.assert_allclose(lit, OPAL.base_color[0] / np.pi, rtol=0.05)
    assert not basis.specular[basis.layers.index("sun"), 22:26, 30:34].any()


def test_its_own_light_is_its_luminance_alone(basis):
    """I / (π r²) and not a lumen more: it neither lights nor shades itself."""
    k = basis.layers.index("bulbs")
    expected = 1 / (4 * np.pi) / (np.pi * LAMP.radius**2)
    np.testing.assert_allclose(basis.diffuse[k, 22:26, 30:34], expected, rtol=1e-5)
    assert not basis.specular[k, 22:26, 30:34].any()
