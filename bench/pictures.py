"""Pictures on disk as PNG, 8 or 16 bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.errors import BenchError


def encode_png(picture: NDArray[Any]) -> bytes:
    """The bytes of a PNG file.

    Parameters
    ----------
    picture : (H, W, 3) RGB or (H, W), uint8, uint16 or bool
        A mask becomes 0 and 255.

    Raises
    ------
    BenchError
        If PNG has no such picture.
    """
    if picture.dtype == np.bool_:
        picture = picture.astype(np.uint8) * np.uint8(255)
    stored: NDArray[Any] = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)
    done, data = cv2.imencode(".png", stored)
    if not done:
        raise BenchError(f"a picture of {picture.dtype}, {picture.shape}, cannot be encoded as PNG")
    return data.tobytes()


def reduced(picture: NDArray[Any], side: int) -> NDArray[Any]:
    """A picture or mask whose longer side has ``side`` pixels at most; a mask stays bool."""
    scale = min(1.0, side / max(picture.shape[:2]))
    size = tuple(max(1, round(scale * length)) for length in picture.shape[1::-1])
    if picture.dtype == np.bool_:
        return cv2.resize(picture.view(np.uint8), size, interpolation=cv2.INTER_NEAREST).astype(np.bool_)
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)


def write_png(path: Path, picture: NDArray[Any]) -> None:
    """Write a picture; see `encode_png`.

    Raises
    ------
    BenchError
        If the file cannot be written.
    """
    try:
        path.write_bytes(encode_png(picture))
    except OSError as error:
        raise BenchError(f"{path}: cannot be written ({error}); make room or choose another folder") from None


def read_png(path: Path) -> NDArray[Any]:
    """Read a picture, (H, W, 3) RGB or (H, W), uint8 or uint16 as stored.

    Raises
    ------
    BenchError
        If there is none, or it is damaged.
    """
    try:
        data = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    except OSError as error:
        raise BenchError(f"{path}: cannot be read ({error.strerror})") from None
    picture = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if len(data) else None
    if picture is None:
        raise BenchError(f"{path}: not a whole picture; bench generate --verify names all damaged files")
    return picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)
