"""Where landmark discs lie: beside the robot's way, on free floor, apart from each other."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from scenes.clearance import clearance
from scenes.model import FloatArray, Landmark, Surface
from scenes.tour import loop_length

RADIUS_M = (0.10, 0.20)
"""What the detector knows, and the size of the discs of the DLR log."""

WHITE_SHARE = 0.6
APART_M = 0.15
MARGIN_M = 0.03


def beside(
    way: FloatArray,
    rng: np.random.Generator,
    furniture: Iterable[Surface],
    spacing_m: float = 1.5,
    offset_m: tuple[float, float] = (0.5, 0.9),
) -> tuple[Landmark, ...]:
    """Discs on both sides of a closed way, about ``spacing_m`` apart along it.

    Parameters
    ----------
    way : (n, 2) float64
        Closed polyline, evenly sampled, metres.
    furniture : surfaces
        What discs keep clear of; the floor itself does not count.
    offset_m : (nearest, farthest)
        From the way to a disc's centre, metres, drawn evenly.
    """
    count = int(loop_length(way) / spacing_m)
    centres, radii, white = [], [], []
    for side in (-1.0, 1.0):
        at = (np.arange(count) + rng.uniform(-0.3, 0.3, count)) / count * len(way)
        for k in at.astype(int) % len(way):
            ahead = way[(k + 5) % len(way)] - way[k]
            left = np.array([-ahead[1], ahead[0]]) / np.linalg.norm(ahead)
            centres.append(way[k] + side * rng.uniform(*offset_m) * left)
            radii.append(rng.uniform(*RADIUS_M))
            white.append(rng.random() < WHITE_SHARE)
    return accepted(np.array(centres), np.array(radii), white, furniture)


def accepted(
    centres: FloatArray, radii: FloatArray, white: list[bool], furniture: Iterable[Surface]
) -> tuple[Landmark, ...]:
    """The discs, in their order, that touch neither furniture nor an earlier one."""
    free = clearance(centres, furniture) > radii + MARGIN_M
    marks: list[Landmark] = []
    for centre, radius, is_white in zip(centres[free], radii[free], np.array(white)[free], strict=True):
        if all(np.hypot(*(centre - m.position)) > radius + m.radius + APART_M for m in marks):
            x, y = centre.tolist()
            marks.append(Landmark(len(marks), (x, y), float(radius), bool(is_white)))
    return tuple(marks)
