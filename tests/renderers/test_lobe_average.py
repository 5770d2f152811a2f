"""Mirror images from one ray a pixel: as smooth as those of many, and no wider."""

from __future__ import annotations

import numpy as np
import pytest

from renderers import lobe_average
from renderers.camera import Mount, Pinhole
from renderers.irradiance import DIRECT_ONLY
from renderers.lobe_average import _widen
from scenes.geometry import rectangle, surface
from scenes.model import Material

BLACK = Material((0.0, 0.0, 0.0), roughness=1.0, specular=0.0)
CAMERA, EYE = Pinhole(160, 120, 70.0), Mount(height_m=1.2, pitch_deg=30.0)


def mirrored_window(renderer_of, scene_of, floor, roughness, supersampling):
    """The sky through a window of 2 m in a black wall, 6 m off, in a floor of white metal: (H, W) cd/m²."""
    ground = floor(40.0, Material((1.0, 1.0, 1.0), roughness, metallic=1.0), 80.0)
    walls = [
        surface(f"wall {k}", BLACK, rectangle((6.0, y, z), (0, 0, height), (0, width, 0), 80.0))
        for k, (y, z, width, height) in enumerate(
            [(-40, 0, 80, 1.0), (-40, 3, 80, 60), (-40, 1, 39, 2), (1, 1, 39, 2)]
        )
    ]
    back = surface("back", BLACK, rectangle((-1.0, -40, 0), (0, 80, 0), (0, 0, 60), 80.0))
    scene = scene_of(ground, *walls, back)
    view = renderer_of(scene, CAMERA, EYE, quality=DIRECT_ONLY, supersampling=supersampling)
    basis = view.render(np.zeros(3))
    return np.where(basis.surface == 0, basis.specular[basis.layers.index("sky")][..., 1], 0)


def test_beside_the_sky_the_box_is_as_narrow_as_can_be():
    """Whatever the memory held: the size is an index, and a wild one reads anywhere."""
    box, up = np.full((1, 2), 2**30, dtype=np.int32), np.float32([[0, 0, 1]] * 4)
    to_eye = np.float32([[0, 0.6, 0.8], [0, 0, 0], [0, 0, 0], [0, 0, 0]])  # 2 × 2 pixels, three of the sky
    one, behind = np.ones(4, dtype=np.float32), np.ones((4, 2), dtype=np.float32)
    lobe_average._widen(np.array([0]), up, to_eye, 0.3 * one, (2, 2), behind, box)
    assert box.tolist() == [[0, 0]]


@pytest.mark.parametrize(("roughness", "most"), [(0.15, 0.024), (0.22, 0.030)])
def test_one_ray_a_pixel_shows_one_window(renderer_of, scene_of, floor, roughness, most):
    """The mean over 4 × 4 pixels alone shows its edges sixteen times, and is off by 0.032 and 0.043."""
    quick, many = (mirrored_window(renderer_of, scene_of, floor, roughness, n) for n in (1, 4))
    inside = slice(70, 115), slice(10, 150)
    off = quick[inside] - many[inside]
    assert np.sqrt((off**2).mean()) <= most * many[inside].max()
    assert quick[inside].max() == pytest.approx(many[inside].max(), rel=0.08)  # nor is the image spread


def test_beside_the_sky_a_box_is_as_narrow_as_can_be():
    """One pixel of floor with the sky around it: nothing tells how wide a pixel is, whatever memory held."""
    normal = np.tile(np.array([0, 0, 1], np.float32), (3, 1))
    to_eye = np.array([[0, 0, 0], [0, 0.6, 0.8], [0, 0, 0]], np.float32)  # of the sky: none
    roughness, behind = np.full(3, 0.2, np.float32), np.ones((3, 2), np.float32)
    box = np.full((1, 2), 2**30, np.int32)
    _widen(np.array([1]), normal, to_eye, roughness, (1, 3), behind, box)
    assert box.tolist() == [[0, 0]]
