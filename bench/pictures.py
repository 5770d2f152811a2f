"""Pictures on disk as PNG, 8 or 16 bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.errors import BenchError


def write_png(path: Path, picture: NDArray[Any]) -> None:
    """Write a picture.

    Parameters
    ----------
    picture : (H, W, 3) RGB or (H, W), uint8, uint16 or bool
        A mask becomes 0 and 255.

    Raises
    ------
    BenchError
        If the file cannot be written.
    """
    if picture.dtype == np.bool_:
        picture = picture.astype(np.uint8) * np.uint8(255)
    stored: NDArray[Any] = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)
    done, data = cv2.imencode(".png", stored)
    try:
        if not done:
            raise OSError("the picture cannot be encoded")
        path.write_bytes(data.tobytes())
    except OSError as error:
        raise BenchError(f"{path}: cannot be written ({error}); make room or choose another folder") from None
