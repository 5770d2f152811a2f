"""The one BRDF: Lambert under a GGX layer, as glTF 2.0 defines metallic-roughness (appendix B).

Where the appendix (which binds nobody) shows Smith's separable shadowing, this is the height-correlated form.

dielectric = mix(diffuse, specular, F)   with F0 = 0.04 · specular, F90 = specular (KHR_materials_specular)
metal      = specular with F0 = base colour
material   = mix(dielectric, metal, metallic)
"""

from __future__ import annotations

import numpy as np
from numba import njit

from renderers.gbuffer import F32
from renderers.lobe_albedo import SMALLEST_ALPHA, directional_albedo

DIELECTRIC_F0 = 0.04
"""Reflectance of a dielectric of refractive index 1.5 at normal incidence (glTF 2.0, B.2.1)."""


@njit(cache=True)
def shade_light(
    normal: F32,
    to_eye: F32,
    to_light: F32,
    irradiance: F32,
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
    base_color : (n, 3) float32
    roughness, metallic, specular : (n,) float32
    out_diffuse, out_specular : (n, 3) float32
        Luminance per channel, cd/m²; added to in place.
    """
    for i in range(len(irradiance)):
        if irradiance[i] <= 0.0:
            continue
        nl = normal[i, 0] * to_light[i, 0] + normal[i, 1] * to_light[i, 1] + normal[i, 2] * to_light[i, 2]
        nv = normal[i, 0] * to_eye[i, 0] + normal[i, 1] * to_eye[i, 1] + normal[i, 2] * to_eye[i, 2]
        if nl <= 0.0 or nv <= 0.0:
            continue
        hx = to_light[i, 0] + to_eye[i, 0]
        hy = to_light[i, 1] + to_eye[i, 1]
        hz = to_light[i, 2] + to_eye[i, 2]
        length = np.sqrt(hx * hx + hy * hy + hz * hz)
        if length < 1e-6:
            continue
        nh = (normal[i, 0] * hx + normal[i, 1] * hy + normal[i, 2] * hz) / length
        vh = (to_eye[i, 0] * hx + to_eye[i, 1] * hy + to_eye[i, 2] * hz) / length
        alpha = max(roughness[i] * roughness[i], SMALLEST_ALPHA)
        lobe = _distribution(nh, alpha) * _visibility(nl, nv, alpha)
        grazing = (1.0 - min(max(vh, 0.0), 1.0)) ** 5
        fresnel = specular[i] * (DIELECTRIC_F0 + (1.0 - DIELECTRIC_F0) * grazing)
        arriving = irradiance[i] * nl
        for c in range(3):
            metal_fresnel = base_color[i, c] + (1.0 - base_color[i, c]) * grazing
            out_diffuse[i, c] += arriving * (1.0 - metallic[i]) * (1.0 - fresnel) * base_color[i, c] / np.pi
            out_specular[i, c] += (
                arriving * lobe * ((1.0 - metallic[i]) * fresnel + metallic[i] * metal_fresnel)
            )


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


@njit(cache=True)
def shade_ambient(
    normal: F32,
    to_eye: F32,
    irradiance: F32,
    mirrored: F32,
    albedo: F32,
    base_color: F32,
    roughness: F32,
    metallic: F32,
    specular: F32,
    out_diffuse: F32,
    out_specular: F32,
) -> None:
    """Add light that comes from everywhere: diffuse from irradiance, specular from the mirror direction.

    Parameters
    ----------
    irradiance : (n, 3) float32
        Indirect and sky illuminance on the surface per channel, lux.
    mirrored : (n, 3) float32
        Luminance seen along the mirrored view ray, cd/m²; zero where the surface is too rough for an image.
    albedo : (33, 33, 2) float32
        `renderers.lobe_albedo.albedo_table`.

    Other parameters as in `shade_light`.
    """
    for i in range(len(irradiance)):
        nv = normal[i, 0] * to_eye[i, 0] + normal[i, 1] * to_eye[i, 1] + normal[i, 2] * to_eye[i, 2]
        scale, bias = directional_albedo(albedo, nv, roughness[i])
        layer = specular[i] * (DIELECTRIC_F0 * scale + bias)
        for c in range(3):
            metal = base_color[i, c] * scale + bias
            out_diffuse[i, c] += (
                irradiance[i, c] * (1.0 - metallic[i]) * (1.0 - layer) * base_color[i, c] / np.pi
            )
            out_specular[i, c] += mirrored[i, c] * ((1.0 - metallic[i]) * layer + metallic[i] * metal)
