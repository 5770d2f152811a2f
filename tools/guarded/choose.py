"""Choose when `guarded` touches a pixel: on pictures of `validation`, with the filter's own code."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from tools.guarded.pictures import Pictures
from tools.guarded.samples import matt
from tools.guarded.train import TAU
from vslam.filters.stages.light_guard import Guard, certain_regions, highlight_chance
from vslam.filters.stages.light_network import LightNetwork

LIKELY = (0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
CERTAIN = (0.9, 0.98, 0.99, 0.993, 0.995, 0.997, 0.998, 0.999)
LEAST = (4, 16, 48)
MASKED_WITHOUT_LIGHT = 0.001
"""Of the pixels of pictures free of highlights: half of what is allowed on scenes never seen."""


@dataclass(frozen=True)
class Choice:
    """The chosen numbers by name, and what they reach on `validation`."""

    numbers: dict[str, float]
    scores: dict[str, float]


def choose(weights: bytes, pictures: list[Pictures]) -> Choice:
    """The guard with the largest mean IoU among those that leave pictures free of highlights alone.

    Where none does, the one that masks least there: first of all do no harm.

    Parameters
    ----------
    weights : bytes
        ONNX.
    pictures : list of Pictures
        Of half the size, as the network takes them. Each is also tried without its specular light.
    """
    network, seen = LightNetwork(weights), []
    for scene in pictures:
        for image, full, diffuse in zip(scene.image, scene.full, scene.diffuse, strict=True):
            size = (image.shape[0], image.shape[1])
            true = (full.astype(np.int16) - diffuse).max(axis=2) >= TAU
            if true.any():
                seen.append((highlight_chance(network(image), *size), true))
            without = matt(image, full, diffuse)
            seen.append((highlight_chance(network(without), *size), np.zeros(size, dtype=np.bool_)))
    scored = []
    for likely, certain, least in product(LIKELY, CERTAIN, LEAST):
        if certain >= likely:
            scored.append(_scored(Guard(likely, certain, least), seen))
    allowed = [c for c in scored if c.scores["masked share without light"] <= MASKED_WITHOUT_LIGHT]
    if not allowed:
        return min(scored, key=lambda choice: choice.scores["masked share without light"])
    return max(allowed, key=lambda choice: choice.scores["mean IoU"])


def _scored(guard: Guard, seen: list[tuple[NDArray[np.float32], NDArray[np.bool_]]]) -> Choice:
    overlaps, alarms = [], []
    for chance, true in seen:
        mask = certain_regions(chance, guard)
        if true.any():
            overlaps.append((mask & true).sum() / (mask | true).sum())
        else:
            alarms.append(mask.mean())
    scores = {"mean IoU": float(np.mean(overlaps)), "masked share without light": float(np.mean(alarms))}
    return Choice({"likely": guard.likely, "certain": guard.certain, "least": guard.least}, scores)
