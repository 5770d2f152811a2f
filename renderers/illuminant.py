"""The colour of a CIE illuminant as light, from colour-science.

Importing colour-science takes seconds (it brings pandas and matplotlib with it), its answers never change: so
they may be kept in a folder between runs, under the version that gave them.
"""

from __future__ import annotations

import json
import os
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

Rgb = tuple[float, float, float]


def linear_srgb(name: str, folder: Path | None = None) -> NDArray[np.float64]:
    """The linear sRGB colour of an illuminant, luminance-normalised, so that lux stay lux.

    Parameters
    ----------
    name : str
        As colour-science names it: "A", "D55", "D65", "FL2", "LED-B3", …
    folder : Path, optional
        Where colour-science's answers are kept between runs; without one it is imported, which takes seconds.

    Returns
    -------
    (3,) float64
        With luminance 0.2126 r + 0.7152 g + 0.0722 b = 1. D65 gives (1, 1, 1).

    Raises
    ------
    RendererError
        If there is no such illuminant; the nearest names are suggested.
    """
    known = _computed() if folder is None else _kept(folder)
    if name not in known:
        near = get_close_matches(name, list(known), n=3, cutoff=0.3)
        raise RendererError(f"unknown illuminant {name!r}; did you mean {', '.join(near) or 'D65'}?")
    return np.array(known[name], dtype=np.float64)


@cache
def _computed() -> dict[str, Rgb]:
    """All illuminants of the CIE 1931 observer."""
    import colour

    matrix = colour.RGB_COLOURSPACES["sRGB"].matrix_XYZ_to_RGB
    colours = {}
    for name, xy in colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"].items():
        rgb = np.asarray(matrix @ colour.xy_to_XYZ(xy), dtype=np.float64)
        rgb = np.maximum(rgb, 0.0)  # saturated illuminants leave the gamut
        r, g, b = (float(v) for v in rgb / (rgb @ LUMINANCE))
        colours[name] = (r, g, b)
    return colours


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
