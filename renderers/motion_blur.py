"""Motion blur: what a pixel sees while the shutter is open and the robot drives.

The shutter opens half the exposure before a frame's stamp and closes half of it after, so that pose, depth
and ids are those of the middle. To first order what a pixel shows moves straight across it, with the image
velocity of the point it shows in the middle (Longuet-Higgins & Prazdny 1980; here by exact reprojection, so
for any camera). A pixel's light is the mean along that way: linear light, before the sensor. The exposure is
metered before, on light that stands still.

Diffuse light moves with the surface. Specular light moves with what is mirrored, whose image lies as far
behind the surface as the thing before it. Left out: where something near passes before something far, each
side of the edge keeps to its own velocity; a shadow's edge in specular light really moves with the surface.

The lens' point spread is on the light already. Two averages over shifts commute; these do as far as the
velocity is the same over the width of the point spread.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from renderers.camera import Camera, Mount, pixel_rays
from renderers.gbuffer import F32, GBuffer
from renderers.lights import OFFSET_M
from renderers.mesh import NOTHING, RayCaster
from renderers.reflection import MIRROR_ROUGHNESS
from renderers.surfaces import Surfaces

F64 = NDArray[np.float64]

LEAST_PX = 0.25
"""Shorter ways, along columns and rows, are left out: they would take 0.3 % from each neighbour."""

INSTANT_S = 1e-3
"""Half of the time over which image velocity is the mean; nothing accelerates within it."""


def image_velocity(camera: Camera, mount: Mount, twist: F64, depth: F32) -> F32:
    """How fast what each pixel shows moves over the picture.

    Parameters
    ----------
    twist : (3,) float64
        The robot's velocity in its own frame: forward and left, m/s, and counter-clockwise, rad/s
        (`scenes.tour.body_twist`).
    depth : (H, W) float32
        z in the camera frame, metres; 0 or inf for the sky. There, and beyond 87° from the axis where z says
        next to nothing about distance, the turn alone counts.

    Returns
    -------
    (H, W, 2) float32
        Of columns and rows, pixels per second; 0 where the point has no image.
    """
    if not np.any(twist):
        return np.zeros((*depth.shape, 2), dtype=np.float32)
    rays, T = pixel_rays(camera), mount.T_robot_camera
    known = (depth > 0) & (rays[..., 2] > 0.05)
    nearness = np.where(known, rays[..., 2] / np.where(known, depth, 1.0), 0.0)[..., None]
    places = []
    for seconds in (INSTANT_S, -INSTANT_S):
        M = (
            np.linalg.inv(T) @ _after(twist, seconds) @ T
        )  # the camera at that time, seen from where it is now
        places.append(camera.project((rays - nearness * M[:3, 3]) @ M[:3, :3])[0])
    velocity = (places[0] - places[1]) / (2 * INSTANT_S)
    return np.nan_to_num(velocity, nan=0.0).astype(np.float32)


def mirror_depth(gbuffer: GBuffer, surfaces: Surfaces, caster: RayCaster) -> F32:
    """(H, W) metres; see `renderers.basis.LightBasis`. The lobe's middle stands for the lobe."""
    depth = gbuffer.depth.copy()
    flat, at = depth.reshape(-1), surfaces
    glossy = np.flatnonzero((at.roughness <= MIRROR_ROUGHNESS) & (at.surface != NOTHING))
    normal, eye = at.normal[glossy], at.to_eye[glossy]
    away = 2 * np.einsum("nk,nk->n", normal, eye)[:, None] * normal - eye
    rays = np.concatenate([at.points[glossy] + np.float32(OFFSET_M) * normal, away], axis=1)
    beyond = caster.first_hit(np.ascontiguousarray(rays, dtype=np.float32))[1]
    flat[glossy] *= 1 + beyond / gbuffer.distance.reshape(-1)[glossy]
    return np.nan_to_num(depth, nan=0.0, posinf=np.inf)


def motion_blurred(light: F32, velocity: F32, seconds: float) -> F32:
    """(H, W, 3) linear light as an exposure of so many seconds collects it; linear in the light.

    Parameters
    ----------
    velocity : (H, W, 2) float32
        `image_velocity`, pixels per second. Beyond its border the picture goes on as it ends.
    """
    way = velocity * np.float32(seconds)
    if np.abs(way).max() < LEAST_PX:
        return light
    blurred = np.empty_like(light)
    _average_along(light, way, blurred)
    return blurred


def _after(twist: F64, seconds: float) -> F64:
    """(4, 4): the pose after driving at a constant twist, in the frame before: the exponential of SE(2)."""
    vx, vy, turning = twist
    angle = turning * seconds
    s, c = np.sinc(angle / np.pi) * seconds, (1 - np.cos(angle)) / turning if turning else 0.0
    T = np.eye(4)
    T[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    T[:2, 3] = [s * vx - c * vy, c * vx + s * vy]
    return T


@njit(cache=True)
def _average_along(light: F32, way: F32, out: F32) -> None:
    """Mean along each pixel's way, centred on the pixel.

    One sample for each column that the way crosses (or row, if it crosses more of these), interpolated across
    it alone: what moves along an edge stays as sharp as it is. The outermost two weigh so much that the
    samples' variance is the way's, L² / 12.
    """
    height, width, _ = light.shape
    for r in range(height):
        for c in range(width):
            du, dv = way[r, c, 0], way[r, c, 1]
            longer = max(abs(du), abs(dv))
            if longer < LEAST_PX:
                out[r, c] = light[r, c]
                continue
            variance = longer * longer / 12.0
            last = 1
            while last * (last + 1) / 3.0 < variance:
                last += 1
            inner, moment = 2 * last - 1, (last - 1) * last * (2 * last - 1) / 3.0
            end = 0.5 * (variance * inner - moment) / (last * last - variance)
            red = green = blue = 0.0
            for k in range(-last, last + 1):
                weight = end if abs(k) == last else 1.0
                x, y = (
                    min(max(c + k * du / longer, 0.0), width - 1.0),
                    min(max(r + k * dv / longer, 0.0), height - 1.0),
                )
                i, j = int(y), int(x)
                below, right = min(i + 1, height - 1), min(j + 1, width - 1)
                s = weight * (y - i if abs(du) >= abs(dv) else x - j)
                if abs(du) >= abs(dv):
                    right = j
                else:
                    below = i
                red += (weight - s) * light[i, j, 0] + s * light[below, right, 0]
                green += (weight - s) * light[i, j, 1] + s * light[below, right, 1]
                blue += (weight - s) * light[i, j, 2] + s * light[below, right, 2]
            total = inner + 2 * end
            out[r, c, 0], out[r, c, 1], out[r, c, 2] = red / total, green / total, blue / total
