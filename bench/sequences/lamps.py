"""What a scene's lamps are, which of them burn under an illumination, and no more layers than that needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import unknown_name
from bench.illumination_grid import Illumination
from bench.rng import generator
from bench.scene_choice import LampChoice
from scenes.model import Scene
from scenes.photometry import Photometry
from scenes.photometry_ies import read_ies

Lamps = NDArray[np.bool_]


def names(scene: Scene) -> tuple[str, ...]:
    """``lamp-0``, ``lamp-1``, … in the order of the scene's bulbs."""
    return tuple(f"lamp-{k}" for k in range(len(scene.bulbs)))


def burning(scene: Scene, illumination: Illumination, seed: int) -> Lamps:
    """Which bulbs of a scene (as its builder made it) burn, (n,) bool.

    Raises
    ------
    BenchError
        For a lamp or group that the scene does not have, with near names.
    """
    on = _chosen(scene, illumination.only) if illumination.only else np.ones(len(scene.bulbs), dtype=bool)
    on &= ~_chosen(scene, illumination.without)
    if illumination.broken:
        order = generator(seed, "broken lamps", illumination.lamps).permutation(len(scene.bulbs))
        on[order[: round(illumination.broken * len(scene.bulbs))]] = False
    return on


def _chosen(scene: Scene, lamps: Sequence[str]) -> Lamps:
    chosen, known = np.zeros(len(scene.bulbs), dtype=bool), names(scene)
    for lamp in lamps:
        matches = [lamp in (name, bulb.group) for name, bulb in zip(known, scene.bulbs, strict=True)]
        if not any(matches):
            raise unknown_name("lamp", lamp, {*known, *(bulb.group for bulb in scene.bulbs)})
        chosen |= np.array(matches)
    return chosen


def split(scene: Scene, states: Sequence[Lamps]) -> Scene:
    """The scene with bulbs that do not always burn together in groups, so in layers, of their own.

    Bulbs of a group that share their state throughout keep one layer: a study that switches nothing gets the
    scene as it is.

    Parameters
    ----------
    states : sequence of (n,) bool
        `burning` of each illumination.
    """
    patterns = [tuple(bool(state[k]) for state in states) for k in range(len(scene.bulbs))]
    groups: dict[str, list[tuple[bool, ...]]] = {}
    bulbs = []
    for bulb, pattern in zip(scene.bulbs, patterns, strict=True):
        known = groups.setdefault(bulb.group, [])
        if pattern not in known:
            known.append(pattern)
        number = known.index(pattern)
        bulbs.append(replace(bulb, group=f"{bulb.group}/{number}") if number else bulb)
    return replace(scene, bulbs=tuple(bulbs))


def middle_lumen(scene: Scene) -> float:
    """Of the middle lamp of a scene as it is built; 1 for a scene without any."""
    return float(np.median([bulb.lumen for bulb in scene.bulbs])) if scene.bulbs else 1.0


def fitted(scene: Scene, choice: LampChoice) -> Scene:
    """The scene with every lamp as the study has it.

    Raises
    ------
    SceneError
        For an IES file that cannot be read, with its line, or an impossible spot.
    """
    changes: dict[str, Any] = {}
    if choice.ies is not None:
        changes["photometry"] = read_ies(Path(choice.ies))
    if choice.spot is not None:
        changes["photometry"] = Photometry.spot(choice.spot.inner_deg, choice.spot.outer_deg)
    if choice.radius_m is not None:
        changes["radius"] = choice.radius_m
    if choice.illuminant is not None:
        changes["illuminant"] = choice.illuminant
    return replace(scene, bulbs=tuple(replace(bulb, **changes) for bulb in scene.bulbs)) if changes else scene


def flicker(illumination: Illumination, stamp_s: float) -> float:
    """The lamps' flux at a moment over their mean flux: 1 + m cos(2π f t)."""
    phase = 2 * np.pi * illumination.flicker_hz * stamp_s
    return float(1 + illumination.flicker_depth * np.cos(phase))
