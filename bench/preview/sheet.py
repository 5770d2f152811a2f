"""The contact sheet: views below each other, lights side by side, each with its ground truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 100
GAP, LABEL, LARGE_GAP = 4, 22, 18
"""Pixels between a view's pictures, for a line of text, and between views or lights."""

SHOWN_WIDTH = 320
"""Pixels that a picture takes; larger ones are reduced."""


@dataclass(frozen=True, eq=False)
class Cell:
    """A view under one light.

    Attributes
    ----------
    recorded, diffuse, specular : (H, W, 3) uint8, sRGB
    mask : (H, W) bool
        The true highlights.
    """

    recorded: NDArray[np.uint8]
    diffuse: NDArray[np.uint8]
    specular: NDArray[np.uint8]
    mask: NDArray[np.bool_]


def draw(rows: Sequence[Sequence[Cell]], views: Sequence[str], lights: Sequence[str]) -> Figure:
    """One 2 × 2 block for each view (row) and light (column): recorded, diffuse; specular, mask."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    page = compose(rows)
    height, width = page.shape[:2]
    figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    figure.figimage(page, 0, 0, origin="upper")
    block_height, block_width = _block(rows[0][0]).shape[:2]
    for r, view in enumerate(views):
        for c, light in enumerate(lights):
            x = LARGE_GAP + c * (block_width + LARGE_GAP)
            y = r * (block_height + LABEL + LARGE_GAP) + LARGE_GAP + LABEL - 6
            text = f"{light}  ·  {view}" if c == 0 else light
            figure.text(x / width, 1 - y / height, text, fontsize=9, va="baseline")
    names = "each block: recorded, diffuse light alone / specular light alone, true highlight mask"
    figure.text(LARGE_GAP / width, 6 / height, names, fontsize=8, color="#6a7178", va="baseline")
    return figure


def compose(rows: Sequence[Sequence[Cell]]) -> NDArray[np.uint8]:
    """(H, W, 3) uint8: the sheet's pictures on white, with room for its labels."""
    blocks = [[_block(cell) for cell in row] for row in rows]
    height, width = blocks[0][0].shape[:2]
    step_y, step_x = height + LABEL + LARGE_GAP, width + LARGE_GAP
    shape = (len(blocks) * step_y + LARGE_GAP + LABEL, len(blocks[0]) * step_x + LARGE_GAP, 3)
    page = np.full(shape, 255, dtype=np.uint8)
    for r, row in enumerate(blocks):
        for c, block in enumerate(row):
            y, x = r * step_y + LARGE_GAP + LABEL, c * step_x + LARGE_GAP
            page[y : y + height, x : x + width] = block
    return page


def _block(cell: Cell) -> NDArray[np.uint8]:
    import cv2

    height, width = cell.mask.shape
    size = (min(width, SHOWN_WIDTH), round(height * min(1.0, SHOWN_WIDTH / width)))
    pictures = [getattr(cell, f.name) for f in fields(cell)]
    pictures[-1] = np.repeat(cell.mask[..., None] * np.uint8(255), 3, axis=-1)
    recorded, diffuse, specular, mask = (
        np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA)) for picture in pictures
    )
    side = np.full((size[1], GAP, 3), 255, dtype=np.uint8)
    above = np.hstack([recorded, side, diffuse])
    line = np.full((GAP, above.shape[1], 3), 255, dtype=np.uint8)
    return np.vstack([above, line, np.hstack([specular, side, mask])])
