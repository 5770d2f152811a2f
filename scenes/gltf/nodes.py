"""The glTF scene graph, flattened: what stands where, in the world's axes (z up, metres)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenes.gltf.document import Document
from scenes.model import FloatArray

WORLD_FROM_GLTF = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=np.float64)
"""glTF has y up and +z towards the viewer (3.4); here z is up, and glTF's −z is north."""


@dataclass(frozen=True, eq=False)
class Node:
    """A node of the graph at its place.

    Attributes
    ----------
    name : str
    content : dict
        The node's JSON.
    T_world_node : (4, 4) float64
        From the node's own axes (glTF's) to the world's.
    """

    name: str
    content: dict[str, Any]
    T_world_node: FloatArray

    @property
    def position(self) -> FloatArray:
        """(3,) metres."""
        return self.T_world_node[:3, 3]


def flatten(document: Document) -> list[Node]:
    """All nodes of the file's scene, parents first.

    Raises
    ------
    SceneError
        If a node does not exist, is its own ancestor, or is not at a finite place.
    """
    nodes = document.items("nodes")
    scenes = document.items("scenes")
    if scenes:
        roots = document.item("scenes", document.content.get("scene", 0), "the file").get("nodes", [])
    else:
        children = {child for node in nodes for child in node.get("children", [])}
        roots = [k for k in range(len(nodes)) if k not in children]
    return list(_walk(document, roots))


def _walk(document: Document, roots: list[int]) -> Iterator[Node]:
    pending = [(root, WORLD_FROM_GLTF, frozenset[int]()) for root in reversed(roots)]
    while pending:
        index, parent, ancestors = pending.pop()
        content = document.item("nodes", index, "the scene graph")
        name = str(content.get("name", f"node {index}"))
        if index in ancestors:
            raise document.error(f"node {name!r} is its own ancestor")
        T = parent @ _local(content)
        if not np.isfinite(T).all():
            raise document.error(f"node {name!r}: its transform is not finite")
        yield Node(name, content, T)
        below = ancestors | {index}
        pending += [(child, T, below) for child in reversed(content.get("children", []))]


def _local(node: dict[str, Any]) -> FloatArray:
    """A node's transform to its parent: a matrix, by columns, or translation · rotation · scale (3.5.3)."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    T = np.eye(4)
    T[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    T[:3, :3] *= np.asarray(node.get("scale", (1.0, 1.0, 1.0)), dtype=np.float64)
    T[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return T
