"""How lamps spread their light: flux, cones, and IES files good and bad."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes.errors import SceneError
from scenes.model import Bulb, Sky, Sun
from scenes.photometry import ISOTROPIC, Photometry, flux
from scenes.photometry_ies import PhotometryFileError, read_ies


def ies(vertical, horizontal, candela, multiplier=1.0, ballast=1.0, tilt="NONE", extra=""):
    """An LM-63-2002 file of these numbers."""
    rows = "\n".join(" ".join(f"{v:.10g}" for v in row) for row in np.atleast_2d(candela))
    return (
        f"IESNA:LM-63-2002\n[TEST] made for a test\n[MANUFAC] none\nTILT={tilt}\n{extra}"
        f"1 1000 {multiplier} {len(vertical)} {len(horizontal)} 1 2 0.1 0.1 0\n{ballast} 1 20\n"
        f"{' '.join(map(str, vertical))}\n{' '.join(map(str, horizontal))}\n{rows}\n"
    )


@pytest.fixture
def read(tmp_path):
    def reading(text):
        path = tmp_path / "lamp.ies"
        path.write_text(text)
        return read_ies(path)

    return reading


def test_isotropic_lamp_has_one_lumen():
    assert flux(ISOTROPIC.vertical, ISOTROPIC.horizontal, ISOTROPIC.candela_per_lumen) == pytest.approx(1.0)


def test_lambertian_lamp_has_pi_times_its_axial_intensity(read):
    theta = np.arange(0, 91)
    web = read(ies(theta, [0], 100 * np.cos(np.radians(theta))))
    assert web.lumen == pytest.approx(100 * np.pi, rel=1e-4)
    assert web.candela_per_lumen[0, 0] == pytest.approx(1 / np.pi, rel=1e-4)


def test_factors_of_the_file_scale_its_flux(read):
    plain, scaled = (read(ies([0, 90], [0], [10, 10], *factors)) for factors in ((1.0, 1.0), (3.0, 0.9)))
    assert plain.lumen == pytest.approx(2 * np.pi * 10)  # half a sphere of 10 cd
    assert scaled.lumen == pytest.approx(2.7 * plain.lumen)


@pytest.mark.parametrize("last", [90, 180, 360])
def test_left_out_half_planes_are_mirrored(read, last):
    horizontal = np.arange(0, last + 1, 45)
    bumps = {0: 1.0, 45: 2.0, 90: 4.0, 135: 3.0, 180: 5.0, 225: 3.0, 270: 4.0, 315: 2.0, 360: 1.0}
    web = read(ies([0, 180], horizontal, [[bumps[h], bumps[h]] for h in horizontal]))
    np.testing.assert_array_equal(web.horizontal, np.arange(0, 361, 45))
    expected = [bumps[h] for h in web.horizontal] if last > 90 else [1, 2, 4, 2, 1, 2, 4, 2, 1]
    np.testing.assert_allclose(web.candela_per_lumen[:, 0] * web.lumen, expected, rtol=1e-6)
    mean = np.trapezoid(expected, np.radians(web.horizontal))
    assert web.lumen == pytest.approx(2 * mean, rel=1e-6)


def test_numbers_may_wrap_and_tilt_is_skipped(read):
    text = ies([0, 45, 90], [0], [3, 2, 1]).replace("0 45 90", "0\n45\n\n 90")
    tilted = ies([0, 45, 90], [0], [3, 2, 1], tilt="INCLUDE", extra="1 2\n0 90\n1.0 0.8\n")
    assert read(text).lumen == pytest.approx(read(tilted).lumen)


GOOD = ies([0, 45, 90], [0], [3, 2, 1])


@pytest.mark.parametrize(
    ("text", "line", "what"),
    [
        ("hello\nworld\n", 2, "no TILT= line"),
        (GOOD.replace("3 2 1", "3 x 1"), 9, "'x' is not a number"),
        (GOOD.replace("3 2 1", "3 2"), 9, "ends after 2 of 3"),
        (GOOD.replace("3 2 1", "3 nan 1"), 9, "not a finite number"),
        (GOOD.replace("3 2 1", "3 -2 1"), 9, "negative"),
        (GOOD.replace("3 2 1", "0 0 0"), 9, "no light"),
        (GOOD.replace("0 45 90", "0 90 45"), 7, "do not ascend"),
        (GOOD.replace("1 1 2 0.1", "1 2 2 0.1"), 5, "type 2"),
        (GOOD.replace(" 3 1 1 2", " -3 1 1 2"), 5, "is no count"),
    ],
    ids=str,
)
def test_bad_file_names_itself_and_the_line(read, text, line, what):
    with pytest.raises(PhotometryFileError, match=what) as caught:
        read(text)
    assert f"lamp.ies, line {line}: " in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_file_is_one_line(tmp_path):
    with pytest.raises(PhotometryFileError, match="cannot be read"):
        read_ies(tmp_path / "none.ies")


@settings(max_examples=60, deadline=None)
@given(st.text(max_size=200), st.integers(0, 300), st.integers(0, 40))
def test_damaged_file_parses_or_says_so(tmp_path_factory, junk, at, cut):
    path = tmp_path_factory.mktemp("ies") / "damaged.ies"
    path.write_text(GOOD[:at] + junk + GOOD[at + cut :], encoding="utf-8", errors="replace")
    try:
        assert np.isfinite(read_ies(path).lumen)
    except PhotometryFileError as error:
        assert "damaged.ies" in str(error)


@pytest.mark.parametrize(("inner", "outer"), [(0, 30), (20, 21), (10, 60), (40, 120)])
def test_spot_has_the_flux_of_its_cone(inner, outer):
    """With c the cosine, 1 lm = I ∫ clamp((c − c_o) / (c_i − c_o))² dω = 2π I (1 − c_i + (c_i − c_o) / 3)."""
    web = Photometry.spot(inner, outer)
    c_in, c_out = np.cos(np.radians([inner, outer]))
    axial = 1 / (2 * np.pi * ((1 - c_in) + (c_in - c_out) / 3))
    assert web.candela_per_lumen[0, 0] == pytest.approx(axial, rel=1e-3)
    assert flux(web.vertical, web.horizontal, web.candela_per_lumen) == pytest.approx(1.0)


@pytest.mark.parametrize(("inner", "outer"), [(30, 30), (-1, 20), (20, 200), (float("nan"), 20)])
def test_impossible_cone(inner, outer):
    with pytest.raises(SceneError, match="spot: needs"):
        Photometry.spot(inner, outer)


def test_lamps_are_told_apart():
    assert repr(Photometry.spot(10, 20)) == repr(Photometry.spot(10, 20)) != repr(Photometry.spot(10, 21))


@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_impossible_intensities(value):
    with pytest.raises(SceneError, match=r"sun: .* must be finite and ≥ 0"):
        Sun(0.0, 45.0, lux=value)
    with pytest.raises(SceneError, match=r"sky: .* must be finite and ≥ 0"):
        Sky(lux=value)
    with pytest.raises(SceneError, match=r"bulb at .* must be finite and ≥ 0"):
        Bulb((0.0, 0.0, 1.0), lumen=value)


def test_impossible_bulbs():
    with pytest.raises(SceneError, match="radius 0"):
        Bulb((0.0, 0.0, 1.0), 1.0, radius=0.0)
    with pytest.raises(SceneError, match="aim"):
        Bulb((0.0, 0.0, 1.0), 1.0, aim=(0.0, 0.0, 0.0))
