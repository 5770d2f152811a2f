"""Splits: scenes to choose on, and others to be judged on.

A scene's geometry follows from its builder's seed alone, and each component draws from a stream keyed by that
seed (`stream`). The splits share out the seeds by their remainder, so that no scene of one split ever draws
from a stream of another's.
"""

from __future__ import annotations

import numpy as np

from scenes.errors import SceneError

SPLITS = ("train", "test", "validation")
"""Builder's seeds 0, 3, 6 … are for training, 1, 4, 7 … for tests, 2, 5, 8 … for validation. So the corridor
that filters and detector were first looked at on (0) and the one the default study reports (7) lie apart."""


def seed_of(split: str, number: int) -> int:
    """The builder's seed of a split's scene ``number`` (0, 1, 2 …).

    Raises
    ------
    SceneError
        If there is no such split, or the number is negative.
    """
    if split not in SPLITS:
        raise SceneError(f"unknown split {split!r}; known: {', '.join(SPLITS)}")
    if number < 0:
        raise SceneError(f"split {split!r}: its scenes are numbered from 0, not {number}")
    return len(SPLITS) * number + SPLITS.index(split)


def split_of(seed: int) -> str:
    """The split that a builder's seed belongs to."""
    return SPLITS[seed % len(SPLITS)]


def stream(seed: int, scene: str, component: str) -> np.random.Generator:
    """A component's own random numbers: another draw of one moves nothing of the others."""
    return np.random.default_rng([seed, *f"{scene} {component}".encode()])
