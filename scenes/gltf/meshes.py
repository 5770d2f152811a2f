"""glTF primitives as surfaces: placed in the world, as triangles that are seen from their front."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from scenes.gltf.document import Document
from scenes.gltf.materials import Cutout, Look, Looks
from scenes.gltf.nodes import Node
from scenes.model import FloatArray, IntArray, Surface
from scenes.solid import backed

FLAT = 0.9999
"""Cosine: a mesh whose vertex normals are this close to its triangles' is flat."""

_TRIANGLES, _STRIP, _FAN = 4, 5, 6


def surfaces(document: Document, nodes: list[Node], looks: Looks) -> list[Surface]:
    """A surface for each primitive of each node's mesh, named by its node.

    Where a node has several, the material's name follows, and a number where a name stands twice. Points and
    lines are left out, and so is what is transparent.

    Raises
    ------
    SceneError
        If a primitive cannot be read.
    """
    found: list[Surface] = []
    taken: set[str] = set()
    for node in nodes:
        if "mesh" not in node.content:
            continue
        mesh = document.item("meshes", node.content["mesh"], f"node {node.name!r}")
        primitives = mesh.get("primitives", [])
        for primitive in primitives:
            user = f"node {node.name!r}"
            look = looks.look(primitive.get("material"), user)
            name = node.name if len(primitives) == 1 else f"{node.name}/{look.name}"
            surface = _surface(document, node, primitive, look, _unused(name, taken))
            if surface is not None:
                taken.add(surface.name)
                found.append(backed(surface) if look.double_sided else surface)
    return found


def _unused(name: str, taken: set[str]) -> str:
    return next(n for n in _numbered(name) if n not in taken)


def _numbered(name: str) -> Iterator[str]:
    yield name
    count = 1
    while True:
        count += 1
        yield f"{name}#{count}"


def _surface(
    document: Document, node: Node, primitive: dict[str, Any], look: Look, name: str
) -> Surface | None:
    user, attributes = f"node {node.name!r}", primitive.get("attributes", {})
    mode = primitive.get("mode", _TRIANGLES)
    if mode not in (_TRIANGLES, _STRIP, _FAN) or "POSITION" not in attributes:
        return None
    local = document.accessor(attributes["POSITION"], user).astype(np.float64)
    vertices = local @ node.T_world_node[:3, :3].T + node.T_world_node[:3, 3]
    corners = np.arange(len(vertices))
    if "indices" in primitive:
        corners = document.accessor(primitive["indices"], user).astype(np.int64)
    if len(corners) and corners.max() >= len(vertices):
        raise document.error(f"{user}: an index points beyond its {len(vertices)} vertices")
    triangles = _triangles(corners, mode)
    if len(triangles) and not np.isfinite(vertices[triangles]).all():
        raise document.error(f"{user}: a vertex is not finite")
    if np.linalg.det(node.T_world_node[:3, :3]) < 0:  # mirrored: what was the front turns with it (3.7.2.1)
        triangles = triangles[:, ::-1]
    uv = None
    if f"TEXCOORD_{look.uv_set}" in attributes:
        raw = document.accessor(attributes[f"TEXCOORD_{look.uv_set}"], user).astype(np.float64)
        uv = (np.column_stack([raw, np.ones(len(raw))]) @ look.uv_transform.T)[:, :2]
    triangles = triangles[_area(vertices, triangles) > 0]
    if look.cutout is not None:
        triangles = triangles[_opaque(look.cutout, triangles, uv)]
    if not len(triangles):
        return None
    normals = None
    if "NORMAL" in attributes:
        normals = _normals(document.accessor(attributes["NORMAL"], user), node, vertices, triangles)
    textures = look.textures if uv is not None else None
    return Surface(name, vertices, np.ascontiguousarray(triangles), look.material, normals, uv, textures)


def _triangles(corners: IntArray, mode: int) -> IntArray:
    """(m, 3) corners of a list, strip or fan (3.7.2.1)."""
    if mode == _TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if mode == _STRIP:
        k = np.arange(max(len(corners) - 2, 0))
        return np.stack([corners[k], corners[k + 1 + k % 2], corners[k + 2 - k % 2]], axis=-1)
    k = np.arange(1, max(len(corners) - 1, 1))
    return np.stack([corners[k], corners[k + 1], np.full(len(k), corners[0] if len(corners) else 0)], axis=-1)


def _face_normals(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def _area(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    return np.asarray(0.5 * np.linalg.norm(_face_normals(vertices, triangles), axis=1))


def _normals(stored: Any, node: Node, vertices: FloatArray, triangles: IntArray) -> FloatArray | None:
    """Unit vertex normals in the world, None for a mesh that is flat anyway."""
    cofactors = np.linalg.inv(node.T_world_node[:3, :3]).T
    normals = np.asarray(stored, dtype=np.float64) @ cofactors.T
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    face = _face_normals(vertices, triangles)
    face /= np.linalg.norm(face, axis=1, keepdims=True)
    normals = np.where(length > 0, normals / np.maximum(length, 1e-300), 0.0)
    broken = ~(length[:, 0] > 0) | ~np.isfinite(normals).all(axis=1)
    if broken.any():
        normals[triangles[:, 0]] = np.where(broken[triangles[:, :1]], face, normals[triangles[:, 0]])
        normals[~(np.linalg.norm(normals, axis=1) > 0.5)] = (0.0, 0.0, 1.0)
    cosine = np.einsum("mkj,mj->mk", normals[triangles], face)
    return None if (cosine > FLAT).all() else normals


def _opaque(cutout: Cutout, triangles: IntArray, uv: FloatArray | None) -> Any:
    """(m,) bool: whether a triangle's mean opacity, of points spread over it, reaches the cutoff."""
    if cutout.picture is None or uv is None:
        return np.full(len(triangles), cutout.factor >= cutout.cutoff)
    height, width = cutout.picture.shape
    steps = np.array([(i, j, 6 - i - j) for i in range(7) for j in range(7 - i)], dtype=np.float64) / 6
    at = np.einsum("kc,mcd->mkd", steps, uv[triangles]) % 1.0
    column, row = (at[..., 0] * width).astype(int) % width, (at[..., 1] * height).astype(int) % height
    mean = cutout.picture[row, column].mean(axis=1) / 255
    return cutout.factor * mean >= cutout.cutoff
