"""The colour of a CIE illuminant as light, from colour-science."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from renderers.errors import RendererError


@cache
def linear_srgb(name: str) -> NDArray[np.float64]:
    """The linear sRGB colour of an illuminant, luminance-normalised, so that lux stay lux.

    Parameters
    ----------
    name : str
        As colour-science names it: "A", "D55", "D65", "FL2", "LED-B3", …

    Returns
    -------
    (3,) float64
        With luminance 0.2126 r + 0.7152 g + 0.0722 b = 1. D65 gives (1, 1, 1).

    Raises
    ------
    RendererError
        If there is no such illuminant; the nearest names are suggested.
    """
    import colour

    observer = "CIE 1931 2 Degree Standard Observer"
    known = colour.CCS_ILLUMINANTS[observer]
    if name not in known:
        from difflib import get_close_matches

        near = get_close_matches(name, list(known), n=3, cutoff=0.3)
        raise RendererError(f"unknown illuminant {name!r}; did you mean {', '.join(near) or 'D65'}?")
    xyz = colour.xy_to_XYZ(known[name])
    rgb = colour.RGB_COLOURSPACES["sRGB"].matrix_XYZ_to_RGB @ (xyz / xyz[1])
    rgb = np.maximum(np.asarray(rgb, dtype=np.float64), 0.0)  # saturated illuminants leave the gamut
    return rgb / (rgb @ np.array([0.2126, 0.7152, 0.0722]))
