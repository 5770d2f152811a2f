"""The colour of light against CIE chromaticities written out by hand."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from renderers import illuminant
from renderers.errors import RendererError
from renderers.illuminant import linear_srgb

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # IEC 61966-2-1


def xy_of(rgb):
    """Chromaticity of linear sRGB by the standard's own matrix."""
    matrix = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    xyz = matrix @ rgb
    return xyz[:2] / xyz.sum()


def test_d65_is_white():
    np.testing.assert_allclose(linear_srgb("D65"), 1.0, atol=1e-3)


# CIE 15:2018, 1931 observer
@pytest.mark.parametrize(
    ("name", "xy"),
    [
        ("A", (0.44758, 0.40745)),
        ("D55", (0.3324, 0.3474)),
        ("D75", (0.2990, 0.3149)),
        ("LED-B3", (0.3756, 0.3723)),
    ],
)
def test_chromaticity(name, xy):
    np.testing.assert_allclose(xy_of(linear_srgb(name)), xy, atol=1e-3)


@pytest.mark.parametrize("name", ["A", "D50", "D55", "D65", "D75", "E", "FL2", "LED-B3"])
def test_lux_stay_lux(name):
    rgb = linear_srgb(name)
    assert rgb.shape == (3,) and rgb.dtype == np.float64
    assert rgb @ LUMINANCE == pytest.approx(1.0, abs=1e-9)
    assert (rgb >= 0).all()


def test_illuminant_a_has_2856_kelvin():
    """Its correlated colour temperature by McCamy's formula (1992), from the light that pictures get."""
    x, y = xy_of(linear_srgb("A"))
    n = (x - 0.3320) / (y - 0.1858)
    assert -449 * n**3 + 3525 * n**2 - 6823.3 * n + 5520.33 == pytest.approx(2856, abs=5)


def test_every_name_has_a_colour_in_colour_science():
    """And no illuminant of CIE 15 that it knows is missing; the others are film's and television's."""
    import colour

    theirs = set(colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"])
    assert set(illuminant.CIE) <= theirs
    assert not [name for name in theirs - set(illuminant.CIE) if name[:2] in ("D5", "FL", "HP", "LE", "ID")]


def test_incandescent_light_is_warm_and_the_north_sky_cold():
    red, green, blue = linear_srgb("A")
    assert red > 1.5 > green > 0.8 > 0.4 > blue
    red, green, blue = linear_srgb("D75")
    assert red < green < blue


@pytest.mark.parametrize(("name", "near"), [("LED_B3", "LED-B3"), ("d65", "D65"), ("FL-2", "FL2")])
def test_unknown_name_suggests_near_ones(name, near):
    with pytest.raises(RendererError, match=f"unknown illuminant '{name}'.*{near}"):
        linear_srgb(name)


FROM_FOLDER = """
import sys
from pathlib import Path
from renderers.illuminant import linear_srgb
print(linear_srgb("D55", Path(sys.argv[1])).tobytes().hex())
print("colour" in sys.modules)
"""


def ask_in_another_process(folder):
    done = subprocess.run(
        [sys.executable, "-c", FROM_FOLDER, str(folder)],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    rgb, imported = done.stdout.split()
    return rgb, imported == "True"


def test_kept_answers_are_the_same_bytes_without_the_import(tmp_path):
    rgb = linear_srgb("D55", tmp_path)
    np.testing.assert_array_equal(rgb, linear_srgb("D55"))
    assert ask_in_another_process(tmp_path) == (rgb.tobytes().hex(), False)


def test_damaged_file_is_replaced(tmp_path):
    linear_srgb("D55", tmp_path)
    (file,) = tmp_path.iterdir()
    whole = file.read_text()
    file.write_text(whole[:50])
    illuminant._kept.cache_clear()
    np.testing.assert_array_equal(linear_srgb("D55", tmp_path), linear_srgb("D55"))
    assert file.read_text() == whole
    assert list(tmp_path.iterdir()) == [file]


def test_folder_that_cannot_be_written_costs_no_result(tmp_path):
    (tmp_path / "file").write_text("")
    np.testing.assert_array_equal(linear_srgb("A", tmp_path / "file" / "cache"), linear_srgb("A"))


def test_answer_is_the_callers_own():
    """Changing a returned colour changes nobody else's."""
    linear_srgb("A")[:] = 0.0
    assert linear_srgb("A").any()
