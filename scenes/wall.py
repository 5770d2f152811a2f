"""A straight wall between two points of the plan: its inner face with openings, and its outer face behind.

The free space lies to the left of the way from its start to its stop.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scenes.geometry import MAX_EDGE_M, rectangle
from scenes.model import FloatArray, IntArray

Piece = tuple[FloatArray, IntArray]

OUTSIDE_EDGE_M = 2.0
"""Cells of outer faces and reveals: nobody looks at them from nearby."""


@dataclass(frozen=True)
class Opening:
    """A rectangular hole: metres along the wall from its start, and above the floor."""

    near: float
    far: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Wall:
    """A wall's foot, (2,) float64 each, and its height, metres."""

    start: FloatArray
    stop: FloatArray
    height: float

    @property
    def length(self) -> float:
        """Metres."""
        return float(np.hypot(*(self.stop - self.start)))

    @property
    def along(self) -> FloatArray:
        """(2,) unit vector from start to stop."""
        return np.asarray((self.stop - self.start) / self.length)

    @property
    def inward(self) -> FloatArray:
        """(2,) unit vector into the free space."""
        return np.array([-self.along[1], self.along[0]])

    def face(
        self, openings: list[Opening], behind_m: float = 0.0, max_edge_m: float = MAX_EDGE_M
    ) -> list[Piece]:
        """The face towards the free space, or, from ``behind_m`` > 0, the outer one that far behind it.

        Parameters
        ----------
        openings : list of Opening
            In order along the wall, apart from each other.
        """
        panels, at = [], 0.0
        for hole in openings:
            panels.append((at, hole.near, 0.0, self.height))
            panels.append((hole.near, hole.far, 0.0, hole.low))
            panels.append((hole.near, hole.far, hole.high, self.height))
            at = hole.far
        panels.append((at, self.length, 0.0, self.height))
        real = [p for p in panels if p[1] - p[0] > 1e-6 and p[3] - p[2] > 1e-6]
        return [self._panel(p, behind_m, max_edge_m) for p in real]

    def crown(self, rise_m: float) -> Piece:
        """A strip on top of the inner face that closes the joint with a ceiling at the wall's height.

        It faces away from the free space and shares no vertex with the face, so that light which is baked at
        vertices is not interpolated between the sky above the ceiling and the room below.
        """
        across, up = self.length * np.append(self.along, 0.0), np.array([0.0, 0.0, rise_m])
        return rectangle(tuple(self._point(0.0, self.height)), tuple(across), tuple(up), OUTSIDE_EDGE_M)

    def reveals(self, hole: Opening, thickness_m: float) -> list[Piece]:
        """The sides of a hole through a wall of a thickness; no sill where it reaches the floor."""
        across, up, deep = hole.far - hole.near, hole.high - hole.low, thickness_m
        d, inwards = np.append(self.along, 0.0), np.append(self.inward, 0.0)
        corner = self._point(hole.near, hole.low) - deep * inwards
        far, top = corner + across * d, corner + np.array([0.0, 0.0, up])
        upwards, across_, through = np.array([0.0, 0.0, up]), across * d, deep * inwards
        sides = [(corner, through, upwards), (far, upwards, through), (top, through, across_)]
        if hole.low > 0:
            sides.append((corner, across_, through))
        return [rectangle(tuple(c), tuple(u), tuple(v), OUTSIDE_EDGE_M) for c, u, v in sides]

    def leaf(self, hole: Opening, proud_m: float) -> list[Piece]:
        """A flat board before the wall, such as a door leaf: its face and its rim."""
        lifted = proud_m * self.inward
        board = Wall(self.start + lifted, self.stop + lifted, self.height)
        front = board._panel((hole.near, hole.far, hole.low, hole.high), 0.0, OUTSIDE_EDGE_M)
        d, inwards = np.append(self.along, 0.0), np.append(self.inward, 0.0)
        corner, up = self._point(hole.near, hole.low), np.array([0.0, 0.0, hole.high - hole.low])
        across, out = (hole.far - hole.near) * d, proud_m * inwards
        rim = [(corner, up, out), (corner + across, out, up), (corner + up, across, out)]
        return [front, *(rectangle(tuple(c), tuple(u), tuple(v), OUTSIDE_EDGE_M) for c, u, v in rim)]

    def _panel(self, panel: tuple[float, float, float, float], behind_m: float, max_edge_m: float) -> Piece:
        near, far, low, high = panel
        across, up = (far - near) * np.append(self.along, 0.0), np.array([0.0, 0.0, high - low])
        corner = self._point(near, low) - behind_m * np.append(self.inward, 0.0)
        u, v = (up, across) if behind_m == 0 else (across, up)
        return rectangle(tuple(corner), tuple(u), tuple(v), max_edge_m)

    def _point(self, along: float, height: float) -> FloatArray:
        return np.append(self.start + along * self.along, height)
