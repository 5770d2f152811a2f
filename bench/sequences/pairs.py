"""A folder of picture pairs: pictures with highlights, and what they are without them.

``input/`` holds the pictures, ``diffuse/`` the same scenes without specular light, under the same names
(suffixes may differ), and ``mask/``, where there is one, which pixels light affects (white, more than half).
Files are PNG, BMP, TIFF or JPEG of 8 or 16 bits, TIFF of floats, or OpenEXR; grey or RGB, of any size.
Floats are clipped to 0…1.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.errors import BenchError

INPUT, DIFFUSE, MASK = "input", "diffuse", "mask"
SUFFIXES = (".png", ".bmp", ".tif", ".tiff", ".jpg", ".jpeg", ".exr")


@dataclass(frozen=True)
class PairFiles:
    """The files of one pair; ``mask`` is None where the folder has none."""

    name: str
    input: Path
    diffuse: Path
    mask: Path | None


@dataclass(frozen=True, eq=False)
class PicturePair:
    """One pair in memory.

    Attributes
    ----------
    name : str
        File name without suffix.
    picture : (H, W) or (H, W, 3); uint8, uint16 or float32
        RGB as stored.
    diffuse : (H, W, 3) float64
        0…1, in the same encoding.
    mask : (H, W) bool or None
    """

    name: str
    picture: NDArray[Any]
    diffuse: NDArray[np.float64]
    mask: NDArray[np.bool_] | None


def find(folder: Path) -> tuple[PairFiles, ...]:
    """The pairs of a folder, by name.

    Raises
    ------
    BenchError
        When a folder is missing or empty, a picture has no partner, or a name stands twice.
    """
    pictures, diffuse = _by_name(folder / INPUT), _by_name(folder / DIFFUSE)
    masks = _by_name(folder / MASK) if (folder / MASK).is_dir() else None
    for kind, others in ((DIFFUSE, diffuse), (MASK, masks)):
        alone = sorted(set(pictures) - set(others)) if others is not None else []
        if alone:
            raise BenchError(
                f"{folder}: {INPUT}/{pictures[alone[0]].name} has no partner in {kind}/ "
                f"({len(alone)} of {len(pictures)} pictures have none); give each the same name in both"
            )
    return tuple(
        PairFiles(name, pictures[name], diffuse[name], masks[name] if masks is not None else None)
        for name in sorted(pictures)
    )


def load(files: PairFiles) -> PicturePair:
    """Read a pair.

    Raises
    ------
    BenchError
        When a file is no picture, or the sizes of the two differ.
    """
    picture, diffuse = _read(files.input), as_light(_read(files.diffuse))
    mask = None if files.mask is None else as_light(_read(files.mask)).max(axis=2) > 0.5
    for path, other in ((files.diffuse, diffuse), (files.mask, mask)):
        if other is not None and other.shape[:2] != picture.shape[:2]:
            raise BenchError(
                f"{path}: is {other.shape[1]} × {other.shape[0]} pixels, its picture {files.input.name} "
                f"{picture.shape[1]} × {picture.shape[0]}; a pair has one size"
            )
    return PicturePair(files.name, picture, diffuse, mask)


def as_light(picture: NDArray[Any]) -> NDArray[np.float64]:
    """(H, W, 3) float64 in 0…1 of a picture as stored; grey in three equal channels."""
    full = np.iinfo(picture.dtype).max if picture.dtype.kind == "u" else 1
    values = picture.astype(np.float64) / full
    return np.repeat(values[:, :, None], 3, axis=2) if values.ndim == 2 else values


def _by_name(folder: Path) -> dict[str, Path]:
    if not folder.is_dir():
        raise BenchError(f"{folder}: no such folder; picture pairs lie in DIR/{INPUT} and DIR/{DIFFUSE}")
    found: dict[str, Path] = {}
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() not in SUFFIXES:
            continue
        if path.stem in found:
            raise BenchError(f"{folder}: {found[path.stem].name} and {path.name} share a name; keep one")
        found[path.stem] = path
    if not found:
        raise BenchError(f"{folder}: holds no picture ({', '.join(SUFFIXES)})")
    return found


def _read(path: Path) -> NDArray[Any]:
    picture = (
        _read_exr(path) if path.suffix.lower() == ".exr" else cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    )
    if picture is None or picture.ndim not in (2, 3):
        raise BenchError(f"{path}: cannot be read as a picture")
    if picture.ndim == 3:
        if picture.shape[2] not in (1, 3, 4):
            raise BenchError(f"{path}: has {picture.shape[2]} channels; give grey or RGB")
        picture = picture[:, :, 0] if picture.shape[2] == 1 else picture[:, :, :3]
        if picture.ndim == 3 and path.suffix.lower() != ".exr":
            picture = picture[:, :, ::-1]  # OpenCV reads BGR
    if picture.dtype.kind == "f":
        if not np.isfinite(picture).all():
            raise BenchError(f"{path}: holds NaN or infinity")
        return np.clip(picture, 0.0, 1.0).astype(np.float32)
    if picture.dtype not in (np.uint8, np.uint16):
        raise BenchError(f"{path}: holds {picture.dtype}; give 8 or 16 bits, or floats in 0…1")
    return np.ascontiguousarray(picture)


def _read_exr(path: Path) -> NDArray[Any]:
    import OpenEXR

    try:
        with OpenEXR.File(str(path), separate_channels=True) as file:
            channels = {name: channel.pixels for name, channel in file.channels().items()}
    except (OSError, RuntimeError) as error:
        raise BenchError(f"{path}: cannot be read as OpenEXR ({' '.join(str(error).split())})") from None
    if {"R", "G", "B"} <= set(channels):
        return np.stack([channels[c] for c in "RGB"], axis=-1).astype(np.float32)
    if len(channels) == 1:
        return next(iter(channels.values())).astype(np.float32)
    raise BenchError(
        f"{path}: has the channels {', '.join(sorted(channels))}; give R, G and B, or one of grey"
    )
