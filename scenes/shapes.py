"""Curved shapes, and where shapes stand. A shape is a mesh piece, as `scenes.geometry` makes them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from scenes.geometry import join
from scenes.model import FloatArray, IntArray, Material, Surface

Piece = tuple[FloatArray, IntArray]
SECTORS = 28
"""Around a round shape: its outline leaves the circle by 0.6 % of the radius."""


def lathe(profile: list[tuple[float, float]], sectors: int = SECTORS) -> Piece:
    """A surface of revolution about z, smooth along its profile; its outside is on the right of the profile.

    Parameters
    ----------
    profile : list of (radius, z)
        At least two points, metres; a radius of 0 is a pole. Joining two pieces leaves a crease between them.

    Returns
    -------
    vertices : (n, 3) float64
    triangles : (m, 3) int64
    """
    angle = np.arange(sectors) * 2 * np.pi / sectors
    around = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    vertices: list[FloatArray] = []
    rings, count = [], 0
    for radius, z in profile:
        points = around if radius > 0 else around[:1]
        vertices.append(np.column_stack([radius * points, np.full(len(points), float(z))]))
        rings.append(count + np.arange(sectors) % len(points))
        count += len(points)
    triangles = []
    for low, high in pairwise(rings):
        right_low, right_high = np.roll(low, -1), np.roll(high, -1)
        triangles.append(np.stack([low, right_low, right_high], axis=-1))
        triangles.append(np.stack([low, right_high, high], axis=-1))
    index = np.concatenate(triangles)
    a, b, c = index.T
    return np.concatenate(vertices), index[(a != b) & (b != c) & (c != a)].astype(np.int64)


def sphere(radius: float, sectors: int = SECTORS) -> Piece:
    """A sphere that stands on z = 0."""
    theta = np.linspace(0, np.pi, sectors // 2 + 1)
    rim = radius * np.sin(theta)
    rim[[0, -1]] = 0.0
    return lathe(list(zip(rim.tolist(), (radius - radius * np.cos(theta)).tolist(), strict=True)), sectors)


def cylinder(radius: float, height: float, max_edge_m: float = np.inf, sectors: int = SECTORS) -> Piece:
    """A cylinder that stands on z = 0, open below; its side is cut into rings no higher than asked."""
    rings = np.linspace(0, height, max(1, int(np.ceil(height / max_edge_m))) + 1).tolist()
    side = lathe([(radius, z) for z in rings], sectors)
    return join([side, lathe([(radius, height), (0.0, height)], sectors)])


def cone(radius: float, height: float, sectors: int = SECTORS) -> Piece:
    """A cone that stands on z = 0, open below."""
    return lathe([(radius, 0.0), (radius / 2, height / 2), (0.0, height)], sectors)


def place(piece: Piece, at: tuple[float, float, float], yaw_deg: float = 0.0, tilt_deg: float = 0.0) -> Piece:
    """Tilt a piece about x, turn it about z (both counter-clockwise), and move its origin to ``at``."""
    vertices, triangles = piece
    (c, s), (ct, st) = ((np.cos(a), np.sin(a)) for a in np.radians([yaw_deg, tilt_deg]))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]) @ np.array([[1.0, 0, 0], [0, ct, -st], [0, st, ct]])
    return vertices @ turn.T + np.asarray(at, dtype=np.float64), triangles


def curved_surface(name: str, material: Material, *pieces: Piece) -> Surface:
    """A surface shaded as curved; vertices that pieces do not share keep their crease.

    A vertex' normal is the mean over its triangles, weighted by their angles there (Thürmer & Wüthrich 1998).
    """
    vertices, triangles = join(list(pieces))
    corner = vertices[triangles]
    face = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    face /= np.linalg.norm(face, axis=1, keepdims=True)
    normals = np.zeros_like(vertices)
    for k in range(3):
        to_next, to_last = corner[:, (k + 1) % 3] - corner[:, k], corner[:, (k + 2) % 3] - corner[:, k]
        cosine = np.einsum("nk,nk->n", to_next, to_last)
        cosine /= np.linalg.norm(to_next, axis=1) * np.linalg.norm(to_last, axis=1)
        angle = np.arccos(np.clip(cosine, -1.0, 1.0))
        np.add.at(normals, triangles[:, k], angle[:, None] * face)
    return Surface(
        name, vertices, triangles, material, normals / np.linalg.norm(normals, axis=1, keepdims=True)
    )
