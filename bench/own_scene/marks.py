"""Landmark discs on the free floor: as listed, as the file's nodes mark them, or drawn beside the way."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from bench.own_scene.ground import Ground
from bench.own_scene.way import Way
from scenes.discs import APART_M, MARGIN_M, RADIUS_M, WHITE_SHARE
from scenes.errors import SceneError
from scenes.gltf.importer import Mark
from scenes.model import Landmark
from scenes.waypoints import SPACING_M

EACH_M = 0.75
"""Of way for each disc: one on either side each 1.5 m, as in the corridor."""

BESIDE_M = (0.4, 0.9)
TRIES = 10
DEFAULT_RADIUS_M = 0.15

Disc = tuple[float, float, float, bool]
"""x, y and radius in metres, and whether it is white."""


def marked(marks: Iterable[Mark]) -> list[Disc]:
    """Discs of the nodes named ``landmark…``: 0.15 m times the node's scale, black if the name says so."""
    named = [m for m in marks if m.name.lower().startswith("landmark")]
    return [
        (m.position[0], m.position[1], DEFAULT_RADIUS_M * m.scale, "black" not in m.name.lower())
        for m in named
    ]


def placed(discs: Sequence[Disc], ground: Ground, scene: str) -> tuple[Landmark, ...]:
    """Landmarks at given places.

    Raises
    ------
    SceneError
        For a disc that reaches beyond the free floor, or into another.
    """
    marks: list[Landmark] = []
    for x, y, radius, white in discs:
        if ground.at(np.array([[x, y]]))[0] < radius - ground.resolution:
            raise SceneError(
                f"scene {scene!r}: landmark {len(marks)} at ({x:g}, {y:g}) m, radius {radius:g} m, does not "
                "lie on free floor; move it"
            )
        for other in marks:
            if np.hypot(x - other.position[0], y - other.position[1]) < radius + other.radius:
                raise SceneError(
                    f"scene {scene!r}: landmarks {other.id} and {len(marks)} at ({x:g}, {y:g}) m overlap; "
                    "move one"
                )
        marks.append(Landmark(len(marks), (x, y), radius, white))
    return tuple(marks)


def beside(way: Way, ground: Ground, rng: np.random.Generator) -> tuple[Landmark, ...]:
    """Discs on both sides of the way, where there is room for them."""
    points, marks = way.points, list[Landmark]()
    ahead = np.gradient(points, axis=0)
    left = np.stack([-ahead[:, 1], ahead[:, 0]], axis=-1)
    left /= np.maximum(np.linalg.norm(left, axis=1, keepdims=True), 1e-12)
    each = max(1, round(EACH_M / SPACING_M))
    for slot, first in enumerate(range(0, len(points), each)):
        side = 1.0 if slot % 2 else -1.0
        for _ in range(TRIES):
            k = min(first + int(rng.integers(each)), len(points) - 1)
            x, y = points[k] + side * rng.uniform(*BESIDE_M) * left[k]
            radius, white = float(rng.uniform(*RADIUS_M)), bool(rng.random() < WHITE_SHARE)
            free = ground.at(np.array([[x, y]]))[0] >= radius + MARGIN_M
            if free and all(_gap(x, y, m) > radius + APART_M for m in marks):
                marks.append(Landmark(len(marks), (float(x), float(y)), radius, white))
                break
    return tuple(marks)


def _gap(x: float, y: float, mark: Landmark) -> float:
    return float(np.hypot(x - mark.position[0], y - mark.position[1])) - mark.radius
