"""Sheets and solids: a sheet that is seen from both sides gets a back of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scenes.model import FloatArray, IntArray, Surface

SHEET_M = 0.002
"""Thickness of a sheet: its back lies this far behind its front, so that a ray can tell them apart."""

WELD_M = 1e-5
"""Vertices closer than this are one."""


def backed(surface: Surface) -> Surface:
    """The surface with a back side, unless it encloses a solid, whose inside nobody sees."""
    if encloses(surface.vertices, surface.triangles):
        return surface
    normals = vertex_normals(surface) if surface.normals is None else surface.normals
    behind = surface.vertices - SHEET_M * normals
    return replace(
        surface,
        vertices=np.concatenate([surface.vertices, behind]),
        triangles=np.concatenate([surface.triangles, surface.triangles[:, ::-1] + len(surface.vertices)]),
        normals=None if surface.normals is None else np.concatenate([normals, -normals]),
        uv=None if surface.uv is None else np.tile(surface.uv, (2, 1)),
    )


def encloses(vertices: FloatArray, triangles: IntArray) -> bool:
    """Whether every edge is passed once in each direction: a closed surface, all of one orientation."""
    _, welded = np.unique(np.round(vertices / WELD_M).astype(np.int64), axis=0, return_inverse=True)
    a = welded.reshape(-1)[triangles]
    edges = np.concatenate([a[:, [0, 1]], a[:, [1, 2]], a[:, [2, 0]]])
    edges = edges[edges[:, 0] != edges[:, 1]]
    sign = np.where(edges[:, 0] < edges[:, 1], 1, -1)
    key = edges.min(axis=1) * (welded.max() + 1) + edges.max(axis=1)
    _, which, count = np.unique(key, return_inverse=True, return_counts=True)
    return bool((np.bincount(which, weights=sign) == 0).all() and (count % 2 == 0).all())


def vertex_normals(surface: Surface) -> FloatArray:
    """(n, 3) unit mean of the normals of each vertex' triangles, weighted by their area."""
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    total = np.zeros_like(surface.vertices)
    for k in range(3):
        np.add.at(total, surface.triangles[:, k], face)
    return np.asarray(total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-300))
