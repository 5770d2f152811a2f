"""What a recorded drive through a real building says about the building."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError
from scenes.model import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class DriveLog:
    """Poses, discs, and which disc was seen from where.

    Attributes
    ----------
    poses : (n, 3) float64
        x, y (metres) and heading (rad, counter-clockwise from +x), in driving order.
    discs : (m, 2) float64
        Centres on the floor, metres.
    white : (m,) bool
        False for a black disc.
    light_floor : (m,) bool
        Whether the floor around a disc is light (tiles, linoleum), not dark carpet.
    sightings : (k, 2) int64
        Row of ``poses`` and row of ``discs``.
    outdoors : (first, last)
        Rows of ``poses`` under the open sky, the last excluded; equal for none.

    Raises
    ------
    SceneError
        If the arrays do not belong together.
    """

    poses: FloatArray
    discs: FloatArray
    white: NDArray[np.bool_]
    light_floor: NDArray[np.bool_]
    sightings: IntArray
    outdoors: tuple[int, int] = (0, 0)

    def __post_init__(self) -> None:
        n, m = len(self.poses), len(self.discs)
        fits = (
            self.poses.shape == (n, 3)
            and n > 1
            and self.discs.shape == (m, 2)
            and len(self.white) == len(self.light_floor) == m
            and self.sightings.shape == (len(self.sightings), 2)
            and (self.sightings >= 0).all()
            and (self.sightings < (n, m)).all()
        )
        if not fits:
            raise SceneError("drive log: poses, discs, colours and sightings do not belong together")

    def nearest_sightings(self) -> IntArray:
        """(j, 2) int64: of each disc that was seen, the sighting from nearby; rows as ``sightings``."""
        pose, disc = self.sightings.T
        apart = np.hypot(*(self.poses[pose, :2] - self.discs[disc]).T)
        order = np.lexsort((apart, disc))
        _, first = np.unique(disc[order], return_index=True)
        return self.sightings[order[first]]
