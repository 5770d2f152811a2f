"""A rectangular room whose walls and ceiling have openings with the depth of the wall.

Each inner face is one plane that meets its neighbours in common edges, and an opening's reveal joins it
without a gap, so that light enters through the openings alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from scenes.geometry import MAX_EDGE_M, rectangle
from scenes.model import FloatArray
from scenes.shapes import Piece

REVEAL_EDGE_M = 1.5
"""Reveals are narrow; longer cells do."""


@dataclass(frozen=True)
class Opening:
    """A rectangle in a wall, as seen from inside: metres from the wall's left end and from the floor.

    In a ceiling ``left`` and ``right`` count along y from the south, ``low`` and ``high`` along x.

    Attributes
    ----------
    depth : float
        Of the reveal behind it, metres; 0 where a flush panel (`Room.panel`) fills it.
    """

    left: float
    right: float
    low: float
    high: float
    depth: float = 0.25


@dataclass(frozen=True)
class Room:
    """A room with its south-west corner at the origin; metres."""

    width: float
    depth: float
    height: float

    def floor(self, max_edge_m: float = MAX_EDGE_M) -> Piece:
        """The floor, z = 0."""
        return rectangle((0, 0, 0), (self.width, 0, 0), (0, self.depth, 0), max_edge_m)

    def wall(
        self, side: str, openings: Sequence[Opening] = (), max_edge_m: float = MAX_EDGE_M
    ) -> list[Piece]:
        """The inner face of a wall or of the ceiling, and the reveals of its openings.

        Parameters
        ----------
        side : {"south", "east", "north", "west", "ceiling"}
        openings : sequence of Opening
            Apart from each other.
        """
        return _pierced(*self._plane(side), openings, max_edge_m)

    def walls(self, openings: Mapping[str, Sequence[Opening]], max_edge_m: float = MAX_EDGE_M) -> list[Piece]:
        """All four walls, with the openings of each."""
        sides = ("south", "east", "north", "west")
        return [piece for side in sides for piece in self.wall(side, openings.get(side, ()), max_edge_m)]

    def panel(self, side: str, opening: Opening, max_edge_m: float = MAX_EDGE_M) -> Piece:
        """What fills an opening without depth, flush with the wall: a door's leaf, a picture.

        Let in, it leaves no hidden strip of wall behind it whose darkness would show about its edges.
        """
        corner, along, up = self._plane(side)
        u, v = along / np.linalg.norm(along), up / np.linalg.norm(up)
        start = corner + opening.left * u + opening.low * v
        return _face(start, (opening.right - opening.left) * u, (opening.high - opening.low) * v, max_edge_m)

    def _plane(self, side: str) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Lower left corner, and the edges along and up; they face inwards."""
        w, d, h = self.width, self.depth, self.height
        plane = {
            "south": ((w, 0, 0), (-w, 0, 0), (0, 0, h)),
            "east": ((w, d, 0), (0, -d, 0), (0, 0, h)),
            "north": ((0, d, 0), (w, 0, 0), (0, 0, h)),
            "west": ((0, 0, 0), (0, d, 0), (0, 0, h)),
            "ceiling": ((0, 0, h), (0, d, 0), (w, 0, 0)),
        }[side]
        corner, along, up = np.array(plane, dtype=np.float64)
        return corner, along, up


def _face(start: FloatArray, one: FloatArray, other: FloatArray, edge: float) -> Piece:
    return rectangle(tuple(start), tuple(one), tuple(other), edge)  # type: ignore[arg-type]


def _pierced(
    corner: FloatArray,
    along: FloatArray,
    up: FloatArray,
    openings: Sequence[Opening],
    max_edge_m: float = MAX_EDGE_M,
) -> list[Piece]:
    """A rectangle that faces ``along × up`` with openings whose reveals reach behind it."""
    long, high = float(np.linalg.norm(along)), float(np.linalg.norm(up))
    u, v = along / long, up / high

    def at(left: float, low: float) -> FloatArray:
        return corner + left * u + low * v

    pieces = []
    levels = sorted({0.0, high, *(o.low for o in openings), *(o.high for o in openings)})
    for bottom, top in pairwise(levels):
        row = sorted((o for o in openings if o.low < top and o.high > bottom), key=lambda o: o.left)
        ends = [0.0, *(x for o in row for x in (o.left, o.right)), long]
        for left, right in zip(ends[::2], ends[1::2], strict=True):
            if right > left:
                pieces.append(_face(at(left, bottom), (right - left) * u, (top - bottom) * v, max_edge_m))
    for o in (o for o in openings if o.depth > 0):
        behind = -o.depth * np.cross(u, v)
        across, upwards, edge = (o.right - o.left) * u, (o.high - o.low) * v, REVEAL_EDGE_M
        sill, lintel = at(o.left, o.low) + behind, at(o.left, o.high) + behind
        pieces += [
            _face(sill, -behind, across, edge),
            _face(lintel, across, -behind, edge),
            _face(sill, upwards, -behind, edge),
            _face(at(o.right, o.low) + behind, -behind, upwards, edge),
        ]
    return pieces


def windows(
    length: float, count: int, width: float, low: float, high: float, depth: float = 0.25
) -> list[Opening]:
    """Equal openings at equal distances along a wall."""
    middle = (np.arange(count) + 0.5) * length / count
    return [Opening(float(m - width / 2), float(m + width / 2), low, high, depth) for m in middle]


def panes(opening: Opening, columns: int, rows: int, bar: float) -> list[Opening]:
    """An opening as panes between bars of the wall's depth."""

    def split(low: float, high: float, count: int) -> list[tuple[float, float]]:
        size = (high - low - (count - 1) * bar) / count
        return [(low + k * (size + bar), low + k * (size + bar) + size) for k in range(count)]

    return [
        Opening(left, right, low, high, opening.depth)
        for left, right in split(opening.left, opening.right, columns)
        for low, high in split(opening.low, opening.high, rows)
    ]


def ground() -> Piece:
    """Open land about the house, a step below its floor."""
    return rectangle((-240, -250, -0.3), (500, 0, 0), (0, 500, 0), max_edge_m=60.0)
