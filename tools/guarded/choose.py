"""Choose the guard of `guarded` on pictures of `validation`.

Of all guards that leave pictures free of highlights alone, the one whose mask overlaps the true one best;
with the greatest strength of repair that costs the detector no landmark.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from bench.metrics import detection
from tools.guarded.trials import Trial
from vslam.detect import DiscDetector
from vslam.filters.stages.light_guard import Guard, certain_regions, guarded, highlight_chance, shrunk
from vslam.filters.stages.light_network import LightNetwork, shrink_factor

LIKELY = (0.4, 0.5, 0.6, 0.7, 0.8)
CERTAIN = (0.7, 0.75, 0.8, 0.82, 0.84, 0.86, 0.88, 0.9, 0.92, 0.94)
LEAST = (4, 16, 48)
STRENGTHS = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5)

MASKED_WITHOUT_LIGHT = 0.001
"""Of the pixels of pictures free of highlights: half of what is allowed on scenes never seen."""


@dataclass(frozen=True)
class Choice:
    """The chosen numbers by name, and what they reach on `validation`."""

    numbers: dict[str, float]
    scores: dict[str, float]


@dataclass(frozen=True, eq=False)
class Case:
    """A trial with the detector of its camera."""

    trial: Trial
    detect: DiscDetector

    def found(self, image: NDArray[np.uint8]) -> int:
        """Visible landmarks that the detector finds."""
        discs = self.trial.discs
        return detection.evaluate(self.detect(image).points, discs[self.trial.visible], discs).true

    def colourless_error(self, image: NDArray[np.uint8]) -> float:
        """Summed squared error on white and grey objects."""
        at = self.trial.colourless
        error = image[at].astype(np.float64) - self.trial.recording.diffuse[at]
        return float((error**2).sum())


def choose(weights: bytes, cases: Sequence[Case]) -> Choice:
    """The guard with the largest mean IoU among those that leave pictures free of highlights alone.

    Its strength is the greatest that loses no landmark, over all pictures; where each loses some, the least.

    Parameters
    ----------
    weights : bytes
        ONNX.

    Raises
    ------
    ValueError
        When no guard does: the network is of no use.
    """
    network = LightNetwork(weights)
    seen = [_chance(network, case.trial.recording.image) for case in cases]
    guard, scores = max(_tried(cases, seen), key=lambda tried: tried[1]["mean IoU"])
    for strength in STRENGTHS:
        guard = replace(guard, strength=strength)
        harm = _harm(network, guard, cases)
        if harm["recall change"] >= 0:
            break
    return Choice(vars(guard), scores | harm)


def _chance(network: LightNetwork, image: NDArray[np.uint8]) -> NDArray[np.float32]:
    small = shrunk(image, shrink_factor(*image.shape[:2]))
    return highlight_chance(network(small), *small.shape[:2])


def _tried(
    cases: Sequence[Case], seen: Sequence[NDArray[np.float32]]
) -> Iterator[tuple[Guard, dict[str, float]]]:
    """Guards that leave pictures free of highlights alone, with what they find elsewhere."""
    for likely, certain, least in product(LIKELY, CERTAIN, LEAST):
        if certain < likely:
            continue
        guard, overlaps, alarms = Guard(likely, certain, least), [], []
        for case, chance in zip(cases, seen, strict=True):
            mask = certain_regions(chance, guard)
            true = case.trial.recording.highlight
            true = true[:: true.shape[0] // mask.shape[0], :: true.shape[1] // mask.shape[1]]
            if case.trial.matt:
                alarms.append(mask.mean())
            elif true.any():
                overlaps.append((mask & true).sum() / (mask | true).sum())
        if np.mean(alarms) <= MASKED_WITHOUT_LIGHT:
            yield (
                guard,
                {
                    "mean IoU": float(np.mean(overlaps)),
                    "masked share without light": float(np.mean(alarms)),
                },
            )


def _harm(network: LightNetwork, guard: Guard, cases: Sequence[Case]) -> dict[str, float]:
    """Change of recall over all pictures, and of PSNR on white and grey objects under the worst light."""
    visible, found, errors = 0, np.zeros(2), {}
    for case in cases:
        image = case.trial.recording.image
        pair = (image, guarded(image, network, guard).image)
        visible += int(case.trial.visible.sum())
        found += [case.found(p) for p in pair]
        if case.trial.colourless.any() and not case.trial.matt:
            total = errors.setdefault(case.trial.light, np.zeros(2))
            total += [case.colourless_error(p) for p in pair]
    worst = min(10 * np.log10(before / after) for before, after in errors.values())
    return {
        "recall change": float((found[1] - found[0]) / visible),
        "white and grey objects, dB": float(worst),
    }
