"""How the codes of a picture stand for light when eq. 3-5 is computed: as sRGB says, or in proportion."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vslam.filters.stages import srgb


@dataclass(frozen=True, eq=False)
class Transfer:
    """The tables of a transfer function, as the kernels take them.

    Attributes
    ----------
    decoded : (256,) float32
        Light 0…1 of each code.
    code_at_bin : (4097,) uint8
        The code at the lower end of each bin of light.
    next_in_bin : (4097,) float32
        Light at which the code after that one begins.
    boundaries : (257,) float64
        Light at which each code begins.
    """

    decoded: NDArray[np.float32]
    code_at_bin: NDArray[np.uint8]
    next_in_bin: NDArray[np.float32]
    boundaries: NDArray[np.float64]

    def decode(self, image: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Light 0…1 of a picture of codes, C-contiguous."""
        return np.asarray(cv2.LUT(image, self.decoded), dtype=np.float32)


def _proportional() -> Transfer:
    boundaries = np.concatenate([[-np.inf], (np.arange(1, 256) - 0.5) / 255.0, [np.inf]])
    decoded = (np.arange(256) / 255.0).astype(np.float32)
    return Transfer(decoded, *srgb.encoding_tables(boundaries), boundaries)


SRGB = Transfer(srgb.DECODED, srgb.CODE_AT_BIN, srgb.NEXT_IN_BIN, srgb.BOUNDARIES)
"""IEC 61966-2-1: codes are linearised."""
PROPORTIONAL = _proportional()
"""Codes taken for light as they are: what a program does that forgets to linearise."""
