"""Choose when `guarded` touches a pixel: on pictures of `validation`, with the filter's own code."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from tools.guarded.pictures import Pictures
from tools.guarded.train import TAU
from vslam.filters.stages.light_guard import Guard, certain_regions, highlight_chance
from vslam.filters.stages.light_network import LightNetwork

LIKELY = (0.3, 0.4, 0.5, 0.6, 0.7)
CERTAIN = (0.5, 0.7, 0.8, 0.9, 0.95)
LEAST = (1, 6, 12, 24)
MASKED_WITHOUT_LIGHT = 0.001
"""Of the pixels of pictures free of highlights: half of what is allowed on scenes never seen."""


@dataclass(frozen=True)
class Choice:
    """The chosen numbers by name, and what they reach on `validation`."""

    numbers: dict[str, float]
    scores: dict[str, float]


def choose(weights: bytes, pictures: list[Pictures]) -> Choice:
    """The guard with the largest mean IoU among those that leave pictures free of highlights alone."""
    network, seen = LightNetwork(weights), []
    for scene in pictures:
        for image, full, diffuse in zip(scene.image, scene.full, scene.diffuse, strict=True):
            true = (full.astype(np.int16) - diffuse).max(axis=2) >= TAU
            seen.append(
                (highlight_chance(network(image), *image.shape[:2]), true, not (full != diffuse).any())
            )
    scored = []
    for likely, certain, least in product(LIKELY, CERTAIN, LEAST):
        if certain >= likely:
            scored.append(_scored(Guard(likely, certain, least), seen))
    allowed = [c for c in scored if c.scores["masked share without light"] <= MASKED_WITHOUT_LIGHT]
    return max(allowed or scored, key=lambda choice: choice.scores["mean IoU"])


def _scored(guard: Guard, seen: list[tuple[NDArray[np.float32], NDArray[np.bool_], bool]]) -> Choice:
    overlaps, alarms = [], []
    for chance, true, matt in seen:
        mask = certain_regions(chance, guard)
        if matt:
            alarms.append(mask.mean())
        elif true.any():
            overlaps.append((mask & true).sum() / (mask | true).sum())
    scores = {"mean IoU": float(np.mean(overlaps)), "masked share without light": float(np.mean(alarms))}
    return Choice({"likely": guard.likely, "certain": guard.certain, "least": guard.least}, scores)
