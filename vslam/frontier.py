"""Frontiers of a map: where what is known to be free meets the unknown (Yamauchi 1997).

Yamauchi, *A frontier-based approach for autonomous exploration*, CIRA 1997: the robot drives to the nearest
reachable frontier, looks, and goes on until none is left.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

_BESIDE = ndimage.generate_binary_structure(2, 1)
_AROUND = ndimage.generate_binary_structure(2, 2)


def frontier_cells(free: BoolArray, unknown: BoolArray) -> BoolArray:
    """(rows, cols) bool: free cells that share a side with an unknown one."""
    cells: BoolArray = free & ndimage.binary_dilation(unknown, _BESIDE)
    return cells


def frontiers(free: BoolArray, unknown: BoolArray, min_cells: int = 1) -> list[IntArray]:
    """The frontiers: frontier cells that touch, by side or corner, in groups.

    Parameters
    ----------
    free, unknown : (rows, cols) bool
    min_cells : int
        Smaller groups are left out (Yamauchi: those smaller than the robot).

    Returns
    -------
    list of (k, 2) int64
        Row and column of the cells of each group, in the order of their first cells.
    """
    labels, count = ndimage.label(frontier_cells(free, unknown), _AROUND)
    rows, cols = np.nonzero(labels)
    order = np.argsort(labels[rows, cols], kind="stable")
    cells = np.stack([rows[order], cols[order]], axis=1).astype(np.int64)
    sizes = np.bincount(labels[rows, cols], minlength=count + 1)[1:]
    return [group for group in np.split(cells, np.cumsum(sizes)[:-1]) if len(group) >= max(min_cells, 1)]
