"""The free space that a drive proves: what the robot swept, and where it saw discs lie.

Everything is a mask over the floor plan. Squares instead of circles grow it, as walls stand at right angles.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from scenes.drive_log import DriveLog
from scenes.model import FloatArray

Mask = NDArray[np.uint8]

CELL_M = 0.05
SWEPT_M = 0.65
"""Free on both sides of the track: half the width of a narrow corridor."""
BESIDE_M = 0.36
"""Free around a disc: discs lie along the walls, not under them."""
ROOM_M = 2.0
"""What lies between a disc and the place it was seen from is a room if they are no farther apart."""
BUMP_M, NOOK_M = 0.8, 0.8
"""Narrower dents of walls into free space are filled, narrower nooks walled up, as nobody builds them."""
STRAIGHT_M = 0.18
"""A wall is straight if it strays no farther (Douglas & Peucker 1973)."""


@dataclass(frozen=True, eq=False)
class DrivenSpace:
    """Free floor as a mask.

    Attributes
    ----------
    indoor, outdoor : (rows, cols) uint8
        255 where free; row is y, column is x.
    origin : (2,) float64
        World position of the lower left corner of cell [0, 0], metres.
    """

    indoor: Mask
    outdoor: Mask
    origin: FloatArray

    def holds(self, mask: Mask, points: FloatArray) -> NDArray[np.bool_]:
        """Whether a mask covers (..., 2) points, metres; not outside of the plan."""
        cell = np.floor((points - self.origin) / CELL_M).astype(int)
        inside = ((cell >= 0) & (cell < mask.shape[::-1])).all(axis=-1)
        cell[~inside] = 0
        return np.asarray(inside & (mask[cell[..., 1], cell[..., 0]] > 0))

    def beyond_gates(self) -> Mask:
        """The outdoor mask with a strip of the indoors, so that no gap is left between the two floors."""
        wider = np.asarray(cv2.dilate(self.outdoor, _square(STRAIGHT_M)), dtype=np.uint8)
        return wider & (self.indoor | self.outdoor)

    def rings(self, mask: Mask, straight_m: float = STRAIGHT_M) -> list[FloatArray]:
        """A mask's outlines as polygons, (n, 2) metres each, with the free space on their left."""
        contours, hierarchy = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
        rings = []
        for contour, (_, _, _, parent) in zip(
            contours, [] if hierarchy is None else hierarchy[0], strict=True
        ):
            corners = cv2.approxPolyDP(contour, straight_m / CELL_M, closed=True)[:, 0].astype(np.float64)
            if len(corners) < 3:
                continue
            x, y = corners.T
            counter_clockwise = float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) > 0
            if counter_clockwise != (parent < 0):  # holes run the other way
                corners = corners[::-1]
            rings.append(self.origin + (corners + 0.5) * CELL_M)
        return rings


def driven_space(log: DriveLog) -> DrivenSpace:
    """Free space around a drive's track and discs, split into indoors and outdoors by the nearest pose."""
    track = log.poses[:, :2]
    margin = 3.0
    low = np.minimum(track.min(axis=0), log.discs.min(axis=0, initial=np.inf)) - margin
    high = np.maximum(track.max(axis=0), log.discs.max(axis=0, initial=-np.inf)) + margin
    columns, rows = np.ceil((high - low) / CELL_M).astype(int).tolist()

    def cells(points: FloatArray) -> NDArray[np.int32]:
        return np.asarray(np.floor((points - low) / CELL_M), dtype=np.int32)

    swept, seen = np.zeros((2, rows, columns), dtype=np.uint8)
    cv2.polylines(swept, [cells(track)], isClosed=False, color=255)
    for pose, disc in log.nearest_sightings():
        a, b = cells(track[pose]).tolist(), cells(log.discs[disc]).tolist()
        near = np.hypot(*(track[pose] - log.discs[disc])) < ROOM_M
        (cv2.rectangle(seen, a, b, 255, cv2.FILLED) if near else cv2.line(seen, a, b, 255))
    known = np.maximum(cv2.dilate(swept, _square(SWEPT_M)), cv2.dilate(seen, _square(BESIDE_M)))
    filled = cv2.morphologyEx(known, cv2.MORPH_CLOSE, _square(BUMP_M / 2))
    opened = cv2.morphologyEx(filled, cv2.MORPH_OPEN, _square(NOOK_M / 2))
    free: Mask = np.asarray(np.maximum(opened, known), dtype=np.uint8)
    outdoor = _outdoors(log, free, low)
    return DrivenSpace(free & ~outdoor, outdoor, low)


def _square(half_m: float) -> Mask:
    side = 2 * round(half_m / CELL_M) + 1
    return np.ones((side, side), dtype=np.uint8)


def _outdoors(log: DriveLog, free: Mask, origin: FloatArray) -> Mask:
    from scipy.spatial import cKDTree

    outdoor = np.zeros_like(free)
    first, last = log.outdoors
    if first < last:
        row, column = np.nonzero(free)
        places = origin + (np.stack([column, row], axis=-1) + 0.5) * CELL_M
        _, nearest = cKDTree(log.poses[:, :2]).query(places)
        outdoor[row, column] = np.where((nearest >= first) & (nearest < last), 255, 0)
    return outdoor
