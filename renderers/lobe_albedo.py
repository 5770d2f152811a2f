"""How much of uniform light the GGX lobe reflects, tabulated once by integrating the lobe itself.

Under uniform light the reflectance is F0 · a + F90 · b, with a and b functions of N·V and roughness alone.
Karis' well-known analytic fit (2014) was made for another masking term; on this one it is off by up to 0.2.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import njit

from renderers.gbuffer import F32

NODES = 32
STRATA = 48
"""Samples along each axis of the unit square for one table entry; interpolated, the table is good to 0.01."""

SMALLEST_ALPHA = 1e-3
"""Below this GGX width a point or parallel light's image is smaller than a pixel."""


@cache
def albedo_table() -> F32:
    """Factors of F0 and F90 at N·V = i / 32 and roughness = j / 32, (33, 33, 2) float32."""
    table = np.empty((NODES + 1, NODES + 1, 2), dtype=np.float32)
    _integrate(table)
    return table


@njit(cache=True)
def directional_albedo(table: F32, nv: float, roughness: float) -> tuple[float, float]:
    """Interpolate the factors of F0 and F90 bilinearly; arguments beyond 0…1 are clamped."""
    x = min(max(nv, 0.0), 1.0) * NODES
    y = min(max(roughness, 0.0), 1.0) * NODES
    i, j = min(int(x), NODES - 1), min(int(y), NODES - 1)
    s, t = x - i, y - j
    a, b = (1 - s) * (1 - t), (1 - s) * t
    c, d = s * (1 - t), s * t
    return (
        a * table[i, j, 0] + b * table[i, j + 1, 0] + c * table[i + 1, j, 0] + d * table[i + 1, j + 1, 0],
        a * table[i, j, 1] + b * table[i, j + 1, 1] + c * table[i + 1, j, 1] + d * table[i + 1, j + 1, 1],
    )


def mean_albedo(roughness: F32) -> tuple[F32, F32]:
    """Factors of F0 and F90 under uniform light in all view directions, 2 ∫ albedo N·V d(N·V), (n,) each."""
    table = albedo_table().astype(np.float64)
    nv = np.arange(NODES + 1) / NODES
    mean = np.asarray(2 * np.trapezoid(table * nv[:, None, None], nv, axis=0))
    at = np.arange(NODES + 1) / NODES
    scale, bias = (np.interp(roughness, at, mean[:, k]).astype(np.float32) for k in range(2))
    return scale, bias


@njit(cache=True)
def _integrate(table: F32) -> None:
    """Mean of G2 / G1 over visible normals (Heitz 2018), split by Schlick's (1 − V·H)⁵."""
    for i in range(NODES + 1):
        nv = max(i / NODES, 1e-3)
        vx = np.sqrt(1.0 - nv * nv)
        for j in range(NODES + 1):
            alpha = max((j / NODES) ** 2, SMALLEST_ALPHA)
            a = b = 0.0
            for k in range(STRATA):
                for m in range(STRATA):
                    hx, _, hz = visible_normal(vx, nv, alpha, (k + 0.5) / STRATA, (m + 0.5) / STRATA)
                    vh = vx * hx + nv * hz
                    nl = 2.0 * vh * hz - nv
                    if nl > 0.0 and vh > 0.0:
                        at_eye, at_light = smith_lambda(nv, alpha), smith_lambda(nl, alpha)
                        weight = (1.0 + at_eye) / (1.0 + at_eye + at_light)
                        grazing = (1.0 - min(vh, 1.0)) ** 5
                        a += weight * (1.0 - grazing)
                        b += weight * grazing
            table[i, j, 0], table[i, j, 1] = a / STRATA**2, b / STRATA**2


@njit(cache=True)
def smith_lambda(cosine: float, alpha: float) -> float:
    """Λ of GGX (Heitz 2014, eq. 72)."""
    return 0.5 * (np.sqrt(1.0 + alpha * alpha * (1.0 / (cosine * cosine) - 1.0)) - 1.0)


@njit(cache=True)
def visible_normal(vx: float, vz: float, alpha: float, u: float, w: float) -> tuple[float, float, float]:
    """A GGX normal seen from (vx, 0, vz), for (u, w) in the unit square (Heitz 2018)."""
    length = np.sqrt(alpha * alpha * vx * vx + vz * vz)
    sx, sz = alpha * vx / length, vz / length  # the view in the configuration of a hemisphere
    r, phi = np.sqrt(u), 2.0 * np.pi * w
    t1, t2 = r * np.cos(phi), r * np.sin(phi)
    s = 0.5 * (1.0 + sz)
    t2 = (1.0 - s) * np.sqrt(max(1.0 - t1 * t1, 0.0)) + s * t2
    t3 = np.sqrt(max(1.0 - t1 * t1 - t2 * t2, 0.0))
    # basis: T1 = y, T2 = view × T1 = (−sz, 0, sx)
    nx, ny, nz = alpha * (-sz * t2 + sx * t3), alpha * t1, max(sx * t2 + sz * t3, 0.0)
    norm = np.sqrt(nx * nx + ny * ny + nz * nz)
    return nx / norm, ny / norm, nz / norm
