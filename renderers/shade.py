"""The one BRDF: Lambert under a GGX layer, as glTF 2.0 defines metallic-roughness (appendix B).

Where the appendix (which binds nobody) shows Smith's separable shadowing, this is the height-correlated form.

dielectric = mix(diffuse, specular, F)   with F0 = 0.04 · specular, F90 = specular (KHR_materials_specular)
metal      = specular with F0 = base colour
material   = mix(dielectric, metal, metallic)
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.gbuffer import F32
from renderers.lights import tangents
from renderers.lobe_albedo import SMALLEST_ALPHA, directional_albedo

POINT_LIGHT = 0.0025
"""Squared radius of a disc, over the lobe's squared width, below which it counts as a point (to 0.5 %)."""


def _disc(*rings: tuple[float, int, float]) -> NDArray[np.float64]:
    """Points on the unit disc as x, y, weight; each ring by its radius, count and total weight."""
    points = []
    for k, (radius, count, weight) in enumerate(rings):
        angle = (np.arange(count) + 0.5 * k) / count * 2 * np.pi
        points += [[radius * np.cos(a), radius * np.sin(a), weight / count] for a in angle]
    return np.array(points)


DISC_7 = _disc((0.0, 1, 0.25), (np.sqrt(2 / 3), 6, 0.75))
"""Exact for polynomials of degree 5 (Abramowitz & Stegun 1964, 25.4.61)."""
DISC_37 = _disc((0.0, 1, 1 / 49), (2 / 7, 6, 8 / 49), (4 / 7, 12, 16 / 49), (6 / 7, 18, 24 / 49))
"""A centre and three rings, each weighted by its area."""

AT_ONCE = 64
"""Pixels of which all layers are written before the next ones: what they read stays in the fastest cache."""

DIELECTRIC_F0 = 0.04
"""Reflectance of a dielectric of refractive index 1.5 at normal incidence (glTF 2.0, B.2.1)."""

NARROW = 1e-3
"""Squared width of a lobe, about where it is looked at, below which float32 does not tell its height."""

ONE, F0, PER_PI = np.float32(1), np.float32(DIELECTRIC_F0), np.float32(1 / np.pi)


@njit(cache=True, nogil=True)
def shade_light(
    normal: F32,
    to_eye: F32,
    to_light: F32,
    irradiance: F32,
    spread: F32,
    base_color: F32,
    roughness: F32,
    metallic: F32,
    specular: F32,
    out_diffuse: F32,
    out_specular: F32,
) -> None:
    """Add one light's reflected radiance to the diffuse and specular layers.

    Parameters
    ----------
    normal, to_eye, to_light : (n, 3) float32, unit vectors
    irradiance : (n,) float32
        Illuminance on a plane that faces the light, lux, shadows included; the cosine is applied here.
    spread : (n,) float32
        Radius of the light's disc over its distance; 0 for a point. It gives the highlight its shape.
    base_color : (n, 3) float32
    roughness, metallic, specular : (n,) float32
    out_diffuse, out_specular : (n, 3) float32
        Luminance per channel, cd/m²; added to in place.
    """
    n, cosines = len(irradiance), np.empty((3, AT_ONCE), dtype=np.float32)
    terms = np.empty((4, AT_ONCE), dtype=np.float32)
    for start in range(0, n, AT_ONCE):
        part = slice(start, min(start + AT_ONCE, n))
        if not irradiance[part].any():
            continue
        _cosines(normal[part], to_eye[part], to_light[part], cosines)
        _of_point_light(cosines, roughness[part], terms)
        for i in range(part.start, part.stop):
            m = i - start
            nl, lobe, grazing, sine2 = terms[0, m], terms[1, m], terms[2, m], terms[3, m]
            if irradiance[i] <= 0.0 or nl <= 0.0:
                continue
            lobe_grazing = lobe * grazing
            alpha = max(roughness[i] * roughness[i], np.float32(SMALLEST_ALPHA))
            width2 = sine2 + alpha * alpha
            if 0.25 * spread[i] * spread[i] > POINT_LIGHT * width2 or width2 < NARROW:
                lobe, lobe_grazing = _lobe_of_disc(normal, to_eye, to_light, i, spread[i], alpha)
            fresnel = specular[i] * (F0 + (ONE - F0) * grazing)
            scattered = (ONE - metallic[i]) * (ONE - fresnel) * irradiance[i] * nl * PER_PI
            layer = (ONE - metallic[i]) * specular[i]
            f90 = irradiance[i] * (layer + metallic[i]) * lobe_grazing
            plain = irradiance[i] * (lobe - lobe_grazing)
            for c in range(3):
                out_diffuse[i, c] += scattered * base_color[i, c]
                out_specular[i, c] += plain * (layer * F0 + metallic[i] * base_color[i, c]) + f90


@njit(cache=True, nogil=True, error_model="numpy")
def _cosines(normal: F32, to_eye: F32, to_light: F32, out: F32) -> None:
    """N·L, N·V and V·L, (3, n): in loops without branches and calls, several pixels run at once."""
    nl, nv, vl = out[0], out[1], out[2]
    for i in range(len(normal)):
        x, y, z = normal[i, 0], normal[i, 1], normal[i, 2]
        ex, ey, ez = to_eye[i, 0], to_eye[i, 1], to_eye[i, 2]
        lx, ly, lz = to_light[i, 0], to_light[i, 1], to_light[i, 2]
        nl[i] = x * lx + y * ly + z * lz
        nv[i] = x * ex + y * ey + z * ez
        vl[i] = ex * lx + ey * ly + ez * lz


@njit(cache=True, nogil=True, error_model="numpy")
def _of_point_light(cosines: F32, roughness: F32, terms: F32) -> None:
    """N·L (0 if either side is hidden), the lobe times it, (1 − V·H)⁵ and sin²(N, H), (4, n)."""
    zero, half, two = np.float32(0), np.float32(0.5), np.float32(2)
    tiny, smallest = np.float32(1e-6), np.float32(SMALLEST_ALPHA)
    for i in range(len(roughness)):
        nl, nv = max(cosines[0, i], zero), max(cosines[1, i], zero)
        length = max(np.sqrt(max(two + two * cosines[2, i], zero)), tiny)  # of V + L; half of it is V·H
        nh, away = (nl + nv) / length, max(ONE - half * length, zero)
        alpha = max(roughness[i] * roughness[i], smallest)
        a2, sine2 = alpha * alpha, max(ONE - nh * nh, zero)
        d = a2 * nh * nh + sine2
        smith = nl * np.sqrt(nv * nv * (ONE - a2) + a2) + nv * np.sqrt(nl * nl * (ONE - a2) + a2)
        terms[0, i] = nl if nv > zero else zero
        terms[1, i] = half * PER_PI * a2 * nl / (d * d * max(smith, tiny))
        terms[2, i] = away * away * away * away * away
        terms[3, i] = sine2


@njit(cache=True)
def _dot(a: F32, b: F32, i: int) -> float:
    return a[i, 0] * b[i, 0] + a[i, 1] * b[i, 1] + a[i, 2] * b[i, 2]


@njit(cache=True)
def _lobe_of_disc(
    normal: F32, to_eye: F32, to_light: F32, i: int, spread: float, alpha: float
) -> tuple[float, float]:
    """Mean over a light's disc of the lobe times N·L, plain and weighted by Schlick's (1 − V·H)⁵.

    A disc much smaller than the lobe counts as a point: the mean differs from the centre's value by about
    2 ρ² / (θ² + α²), with ρ its radius in half vectors and θ the half vector's angle. A disc up to the lobe's
    width takes 7 points that are exact for polynomials of degree 5; a larger one, of which a smooth surface
    shows the image, takes 37, and a lobe no narrower than their distance, which keeps its energy.
    """
    x, y, z, nv = to_light[i, 0], to_light[i, 1], to_light[i, 2], _dot(normal, to_eye, i)
    lobe, grazing, sine2 = _lobe_times_cosine(normal, to_eye, i, nv, alpha, x, y, z)
    rho2 = 0.25 * spread * spread
    if rho2 <= POINT_LIGHT * (sine2 + alpha * alpha):
        return lobe, lobe * grazing
    disc = DISC_7
    if rho2 > alpha * alpha:
        disc, alpha = DISC_37, max(alpha, 0.2 * np.sqrt(rho2))
    tx, ty, tz, bx, by, bz = tangents(x, y, z)
    total = weighted = 0.0
    for k in range(len(disc)):
        u, v = spread * disc[k, 0], spread * disc[k, 1]
        px, py, pz = x + u * tx + v * bx, y + u * ty + v * by, z + u * tz + v * bz
        length = np.sqrt(px * px + py * py + pz * pz)
        lobe, grazing, _ = _lobe_times_cosine(
            normal, to_eye, i, nv, alpha, px / length, py / length, pz / length
        )
        total += disc[k, 2] * lobe
        weighted += disc[k, 2] * lobe * grazing
    return total, weighted


@njit(cache=True)
def _lobe_times_cosine(
    normal: F32, to_eye: F32, i: int, nv: float, alpha: float, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """GGX lobe times N·L, (1 − V·H)⁵ and the half vector's squared sine, for light from (x, y, z)."""
    nl = normal[i, 0] * x + normal[i, 1] * y + normal[i, 2] * z
    if nl <= 0.0:
        return 0.0, 0.0, 1.0
    hx, hy, hz = x + to_eye[i, 0], y + to_eye[i, 1], z + to_eye[i, 2]
    length = max(np.sqrt(hx * hx + hy * hy + hz * hz), 1e-6)
    nh = (normal[i, 0] * hx + normal[i, 1] * hy + normal[i, 2] * hz) / length
    vh = (to_eye[i, 0] * hx + to_eye[i, 1] * hy + to_eye[i, 2] * hz) / length
    lobe = _distribution(nh, alpha) * _visibility(nl, nv, alpha) * nl
    return lobe, (1.0 - min(max(vh, 0.0), 1.0)) ** 5, max(1.0 - nh * nh, 0.0)


@njit(cache=True)
def _distribution(nh: float, alpha: float) -> float:
    """GGX normal distribution D (Walter et al. 2007, eq. 33)."""
    a2 = alpha * alpha
    d = nh * nh * (a2 - 1.0) + 1.0
    return a2 / (np.pi * d * d)


@njit(cache=True)
def _visibility(nl: float, nv: float, alpha: float) -> float:
    """Height-correlated Smith shadowing over 4 (N·L)(N·V) (Heitz 2014, eq. 99)."""
    a2 = alpha * alpha
    return 0.5 / (nl * np.sqrt(nv * nv * (1.0 - a2) + a2) + nv * np.sqrt(nl * nl * (1.0 - a2) + a2))


@njit(cache=True, nogil=True)
def shade_ambient(
    normal: F32,
    to_eye: F32,
    irradiance: F32,
    mirrored: F32,
    mirrors: NDArray[np.bool_],
    albedo: F32,
    base_color: F32,
    roughness: F32,
    metallic: F32,
    specular: F32,
    out_diffuse: F32,
    out_specular: F32,
) -> None:
    """Write light that comes from everywhere: diffuse from irradiance, specular from the mirror direction.

    Parameters
    ----------
    irradiance : (n, 3 L) float32
        Indirect and sky illuminance on the surface, lux, channels within layers.
    mirrored : (n, 3 L) float32
        Mean luminance that the specular lobe gathers, cd/m².
    mirrors : (n,) bool
        Where that is known; elsewhere it is the mean of the hemisphere, E / π.
    albedo : (33, 33, 2) float32
        `renderers.lobe_albedo.albedo_table`.
    out_diffuse, out_specular : (L, n, 3) float32
        Luminance per channel, cd/m²; overwritten.

    Other parameters as in `shade_light`.
    """
    matt, shine = np.empty((AT_ONCE, 3), dtype=np.float32), np.empty((AT_ONCE, 3), dtype=np.float32)
    for start in range(0, len(irradiance), AT_ONCE):
        n = min(AT_ONCE, len(irradiance) - start)
        for m in range(n):
            i = start + m
            nv = _dot(normal, to_eye, i)
            scale, bias = directional_albedo(albedo, nv, roughness[i])
            layer = specular[i] * (DIELECTRIC_F0 * scale + bias)
            for c in range(3):
                metal = base_color[i, c] * scale + bias
                matt[m, c] = (1.0 - metallic[i]) * (1.0 - layer) * base_color[i, c] / np.pi
                shine[m, c] = (1.0 - metallic[i]) * layer + metallic[i] * metal
                if not mirrors[i]:
                    shine[m, c] /= np.pi
        for k in range(len(out_diffuse)):  # layer by layer, as each lies elsewhere in memory
            for m in range(n):
                for c in range(3):
                    out_diffuse[k, start + m, c] = irradiance[start + m, 3 * k + c] * matt[m, c]
            for m in range(n):
                gathered = mirrored if mirrors[start + m] else irradiance
                for c in range(3):
                    out_specular[k, start + m, c] = gathered[start + m, 3 * k + c] * shine[m, c]
