"""The colour of a CIE illuminant as light, from colour-science.

Importing colour-science takes seconds (it brings pandas and matplotlib with it), its answers never change: so
they may be kept in a folder between runs, under the version that gave them.
"""

from __future__ import annotations

import json
import os
import re
from contextlib import suppress
from difflib import get_close_matches
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from renderers.errors import RendererError

LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Of linear sRGB's primaries (IEC 61966-2-1)."""

REDDEST_K, DAYLIGHT_K, BLUEST_K = 1667, 4000, 25_000
"""Where the formulas of black body and daylight begin, meet and end."""

CIE = (
    *("A", "B", "C", "D50", "D55", "D60", "D65", "D75", "E", "ID50", "ID65"),
    *(f"FL{k}" for k in range(1, 13)),
    *(f"FL3.{k}" for k in range(1, 16)),
    *(f"HP{k}" for k in range(1, 6)),
    *(f"LED-B{k}" for k in range(1, 6)),
    *("LED-BH1", "LED-RGB1", "LED-V1", "LED-V2"),
)
"""The illuminants of CIE 15:2018 by their names in colour-science; D60 is of the daylight series."""

Rgb = tuple[float, float, float]


def check_name(name: str) -> None:
    """Say whether a light has such a colour, without working it out.

    Raises
    ------
    RendererError
        If there is no such illuminant (the nearest names are suggested) or colour temperature.
    """
    if (kelvin := _kelvin(name)) is not None:
        chromaticity(kelvin)
    elif name not in CIE:
        near = get_close_matches(name, CIE, n=3, cutoff=0.3)
        raise RendererError(f"unknown illuminant {name!r}; did you mean {', '.join(near) or 'D65'}?")


def _kelvin(name: str) -> float | None:
    """The colour temperature of a name such as "5200K"."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?) ?K", name)
    return float(match[1]) if match else None


def linear_srgb(name: str, folder: Path | None = None) -> NDArray[np.float64]:
    """The linear sRGB colour of an illuminant, luminance-normalised, so that lux stay lux.

    Parameters
    ----------
    name : str
        One of `CIE`, such as "A", "D55", "D65", "FL2", "LED-B3", …; or a colour temperature of
        1667…25000 K such as "5200K": CIE daylight from 4000 K on, a black body below.
    folder : Path, optional
        Where colour-science's answers are kept between runs; without one it is imported, which takes seconds.

    Returns
    -------
    (3,) float64
        With luminance 0.2126 r + 0.7152 g + 0.0722 b = 1. D65 gives (1, 1, 1).

    Raises
    ------
    RendererError
        As `check_name`.
    """
    check_name(name)
    if (kelvin := _kelvin(name)) is not None:
        return np.array(_luminance_one(_srgb_matrix() @ _xyz(*chromaticity(kelvin))))
    known = _computed() if folder is None else _kept(folder)
    return np.array(known[name], dtype=np.float64)


def chromaticity(kelvin: float) -> tuple[float, float]:
    """CIE 1931 x, y of daylight (CIE 15:2004, eq. 3.3, 3.4), below 4000 K of a black body (Kim et al. 2002).

    Raises
    ------
    RendererError
        Outside of 1667…25000 K, where the formulas end.
    """
    if not REDDEST_K <= kelvin <= BLUEST_K:
        raise RendererError(f"colour temperature {kelvin:g} K: must lie in {REDDEST_K}…{BLUEST_K} K")
    t = 1e3 / kelvin
    if kelvin < DAYLIGHT_K:
        x = -0.2661239 * t**3 - 0.2343589 * t**2 + 0.8776956 * t + 0.179910
        if kelvin < 2222:
            return x, -1.1063814 * x**3 - 1.34811020 * x**2 + 2.18555832 * x - 0.20219683
        return x, -0.9549476 * x**3 - 1.37418593 * x**2 + 2.09137015 * x - 0.16748867
    if kelvin <= 7000:
        x = -4.6070 * t**3 + 2.9678 * t**2 + 0.09911 * t + 0.244063
    else:
        x = -2.0064 * t**3 + 1.9018 * t**2 + 0.24748 * t + 0.237040
    return x, -3.000 * x**2 + 2.870 * x - 0.275


def _xyz(x: float, y: float) -> NDArray[np.float64]:
    return np.array([x / y, 1.0, (1 - x - y) / y])


def _srgb_matrix() -> NDArray[np.float64]:
    """XYZ to linear sRGB from the primaries and white of IEC 61966-2-1."""
    primaries = np.stack([_xyz(0.64, 0.33), _xyz(0.30, 0.60), _xyz(0.15, 0.06)], axis=1)
    strength = np.linalg.solve(primaries, _xyz(0.3127, 0.3290))
    return np.asarray(np.linalg.inv(primaries * strength), dtype=np.float64)


def _luminance_one(rgb: NDArray[np.float64]) -> Rgb:
    """Clipped to the gamut, which saturated illuminants leave, at luminance 1."""
    rgb = np.maximum(rgb, 0.0)
    r, g, b = (float(v) for v in rgb / (rgb @ LUMINANCE))
    return r, g, b


@cache
def _computed() -> dict[str, Rgb]:
    """All of `CIE`, for the CIE 1931 observer."""
    import colour

    matrix = colour.RGB_COLOURSPACES["sRGB"].matrix_XYZ_to_RGB
    chromaticities = colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"]
    return {
        name: _luminance_one(np.asarray(matrix @ colour.xy_to_XYZ(chromaticities[name]), dtype=np.float64))
        for name in CIE
    }


@cache
def _kept(folder: Path) -> dict[str, Rgb]:
    """Read what this version of colour-science said, or ask it and keep the answer."""
    path = folder / f"illuminants-colour-{version('colour-science')}.json"
    try:
        stored = json.loads(path.read_text())
        return {name: (float(r), float(g), float(b)) for name, (r, g, b) in stored.items()}
    except (OSError, ValueError, TypeError, AttributeError):  # none yet, or cut short
        colours = _computed()
    aside = path.with_name(f"{path.name}.{os.getpid()}.partial")
    with suppress(OSError):  # a cache that cannot be written costs time, not results
        folder.mkdir(parents=True, exist_ok=True)
        aside.write_text(json.dumps(colours, indent=1))
        aside.replace(path)
    return colours
