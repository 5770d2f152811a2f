"""Walls around driven space, with doors along corridors, windows in rooms, and gates to the outdoors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from scenes.driven_space import DrivenSpace
from scenes.model import FloatArray
from scenes.wall import OUTSIDE_EDGE_M, Opening, Piece, Wall

HEIGHT_M, THICK_M = 2.7, 0.3
OVERLAP_M = 0.05
"""Walls' crowns rise so far above the ceiling, so that no ray slips through where their edges meet."""

WINDOW_M, NARROW_M, WINDOW_SPACING_M = 1.5, 0.6, 1.8
SILL_M, LINTEL_M = 0.9, 2.2
DOOR_M, DOOR_HIGH_M, DOOR_SPACING_M, PROUD_M = 0.86, 1.985, 3.8, 0.03
"""Leaf of 0.86 m × 1.985 m (DIN 18101)."""
GATE_M, GATE_HIGH_M, JAMB_M = 1.1, 2.2, 0.35
"""A gate is narrower than its wall by two jambs, where that leaves it wide enough."""
CORNER_M = 0.35
"""No opening nearer to a wall's end."""

ALONG = 0.7
"""Cosine of 45°, between a wall and the robot's way past it: beside the robot, or ahead of it."""
GLAZED_BESIDE, GLAZED_AHEAD = 0.3, 0.8
"""Share of outer walls with windows: corridors have doors on both sides, rooms windows at their far end."""
COURT_M = 6.0
"""A wall with so much unbuilt ground behind it is an outer wall."""


@dataclass(frozen=True, eq=False)
class BuiltWall:
    """A wall and what is in it.

    Attributes
    ----------
    windows, doors : list of Opening
        Doors are closed leaves, no holes.
    gate : bool
        Open to the outdoors, but for a lintel.
    outer : tuple of float, or None
        By how much the outer face is longer than the inner one at start and stop, shorter where the wall
        turns away from the free space; None for no outer face.
    """

    wall: Wall
    windows: list[Opening]
    doors: list[Opening]
    gate: bool
    outer: tuple[float, float] | None

    @cached_property
    def holes(self) -> list[Opening]:
        """Openings of both faces."""
        if not self.gate:
            return self.windows
        jamb = min(max(0.5 * (self.wall.length - GATE_M), 0.0), JAMB_M)
        return [Opening(jamb, self.wall.length - jamb, 0.0, GATE_HIGH_M)]

    def inner_face(self, max_edge_m: float) -> list[Piece]:
        """What is seen from inside, reveals included, and the crown."""
        reveals = [piece for hole in self.holes for piece in self.wall.reveals(hole, THICK_M)]
        return [*self.wall.face(self.holes, 0.0, max_edge_m), self.wall.crown(OVERLAP_M), *reveals]

    def outer_face(self) -> list[Piece]:
        """What is seen from outside; nothing where no one can be."""
        if self.outer is None:
            return []
        before, after = self.outer
        if self.wall.length + before + after < OVERLAP_M:
            return []
        longer = Wall(
            self.wall.start - before * self.wall.along,
            self.wall.stop + after * self.wall.along,
            self.wall.height + OVERLAP_M,
        )
        moved = [Opening(h.near + before, h.far + before, h.low, h.high) for h in self.holes]
        return longer.face(moved, THICK_M, OUTSIDE_EDGE_M)

    def leaves(self) -> list[Piece]:
        """Door leaves, flush but for `PROUD_M`."""
        return [piece for door in self.doors for piece in self.wall.leaf(door, PROUD_M)]


def build_walls(space: DrivenSpace, poses: FloatArray, rng: np.random.Generator) -> list[BuiltWall]:
    """A wall along each side of the indoor outlines.

    Parameters
    ----------
    poses : (n, 3) float64
        Of the drive: which way it went past a wall says what kind of wall that is.
    """
    built = []
    for ring in space.rings(space.indoor):
        count = len(ring)
        for k in range(count):
            before, start, stop, after = (ring[(k + j) % count] for j in (-1, 0, 1, 2))
            wall = Wall(start, stop, HEIGHT_M)
            ends = (THICK_M * _turn(before, start, stop), THICK_M * _turn(start, stop, after))
            built.append(_furnished(space, poses, wall, ends, rng))
    return built


def _furnished(
    space: DrivenSpace, poses: FloatArray, wall: Wall, ends: tuple[float, float], rng: np.random.Generator
) -> BuiltWall:
    middle = 0.5 * (wall.start + wall.stop)
    draws = rng.random(2)  # drawn for every wall: what one has changes nothing of the next
    gate = bool(space.holds(space.outdoor, middle - 0.4 * wall.inward))
    outer = gate or _is_outer(space, wall)
    nearest = poses[np.hypot(*(poses[:, :2] - middle).T).argmin()]
    beside = abs(wall.along @ (np.cos(nearest[2]), np.sin(nearest[2]))) > ALONG
    windows: list[Opening] = []
    doors: list[Opening] = []
    if outer and not gate and draws[1] < (GLAZED_BESIDE if beside else GLAZED_AHEAD):
        width = min(max(wall.length - 2 * CORNER_M, NARROW_M), WINDOW_M)
        windows = _row(wall.length, width, WINDOW_SPACING_M, SILL_M, LINTEL_M, 0.5)
    elif beside and not gate:
        doors = _row(wall.length, DOOR_M, DOOR_SPACING_M, 0.0, DOOR_HIGH_M, float(draws[0]))
    return BuiltWall(wall, windows, doors, gate, ends if outer else None)


def _is_outer(space: DrivenSpace, wall: Wall) -> bool:
    """Whether no indoor space lies behind any part of a wall within `COURT_M`."""
    along = np.linspace(0.1, 0.9, 9)[:, None, None] * (wall.stop - wall.start)
    behind = np.arange(2 * THICK_M, COURT_M, 0.2)[None, :, None] * wall.inward
    return not space.holds(space.indoor, wall.start + along - behind).any()


def _turn(a: FloatArray, b: FloatArray, c: FloatArray) -> float:
    """1 where the way a, b, c turns to the left, −1 where to the right."""
    (ux, uy), (vx, vy) = b - a, c - b
    return float(np.sign(ux * vy - uy * vx))


def _row(length: float, width: float, spacing: float, low: float, high: float, at: float) -> list[Opening]:
    """Equal openings at equal distances; ``at`` 0…1 shifts the row within what the wall leaves."""
    room = length - 2 * CORNER_M
    count = max(int(room // spacing), int(room >= width))
    first = CORNER_M + at * (room - (count - 1) * spacing - width)
    return [Opening(first + k * spacing, first + k * spacing + width, low, high) for k in range(count)]
