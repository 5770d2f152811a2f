"""Occupancy grids as nav2's ``map_server`` has them: a PGM picture and a YAML file beside it.

Conventions
-----------
- Mode ``trinary``: black (0) occupied, near white (254) free, grey (205) unknown; thresholds are
  ROS's own 0.65 and 0.196. (With nav2's newer 0.25 for free, the grey of its own maps reads as free.)
- The picture's first row is the map's last: y points up in the map, down in the picture.
- ``origin`` is the lower left corner of the lower left cell, metres; a turned map is refused.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from bench.errors import BenchError
from vslam.occupancy import HIGHEST, LOWEST, OccupancyGrid

OCCUPIED, FREE, UNKNOWN = 0, 254, 205
OCCUPIED_THRESHOLD, FREE_THRESHOLD = 0.65, 0.196

Probability = Annotated[float, Field(ge=0, le=1)]


class MapFile(BaseModel):
    """The keys of the YAML file; what other tools add is passed over."""

    model_config = ConfigDict(extra="ignore")

    image: str
    mode: Literal["trinary", "scale"] = "trinary"
    resolution: float = Field(gt=0, allow_inf_nan=False)
    origin: tuple[float, float, float]
    negate: bool = False
    occupied_thresh: Probability = OCCUPIED_THRESHOLD
    free_thresh: Probability = FREE_THRESHOLD


def files(grid: OccupancyGrid, stem: str) -> dict[str, bytes]:
    """The two files of a map by name: ``<stem>.yaml`` and ``<stem>.pgm``.

    Parameters
    ----------
    grid : OccupancyGrid
        Cells more likely occupied than free are occupied; log odds of 0 are unknown.
    stem : str
        File name without suffix.
    """
    rows, cols = grid.log_odds.shape
    levels = np.select([grid.occupied, grid.free], [OCCUPIED, FREE], UNKNOWN).astype(np.uint8)
    x, y = (float(value) for value in grid.origin)
    description = MapFile(image=f"{stem}.pgm", resolution=grid.resolution, origin=(x, y, 0.0))
    text = yaml.safe_dump(_as_nav2_writes(description), sort_keys=False)
    picture = f"P5\n{cols} {rows}\n255\n".encode() + np.flipud(levels).tobytes()
    return {f"{stem}.yaml": text.encode(), f"{stem}.pgm": picture}


def read(path: Path) -> OccupancyGrid:
    """Read a map from its YAML file.

    Returns
    -------
    OccupancyGrid
        Occupied and free cells at the highest and lowest log odds that the grid holds, unknown ones at 0.

    Raises
    ------
    BenchError
        In one line: a file that is missing or not readable, keys that do not fit, a turned map.
    """
    description = _description(path)
    if abs(description.origin[2]) > 1e-9:
        raise BenchError(
            f"map {path}: it is turned by {description.origin[2]:g} rad; give one whose origin has yaw 0"
        )
    occupied_share = _occupied_share(path.parent / description.image, path, description.negate)
    log_odds = np.zeros(occupied_share.shape, dtype=np.float32)
    log_odds[occupied_share > description.occupied_thresh] = HIGHEST
    log_odds[occupied_share < description.free_thresh] = LOWEST
    return OccupancyGrid(np.array(description.origin[:2]), description.resolution, log_odds)


def _as_nav2_writes(description: MapFile) -> dict[str, Any]:
    keys = description.model_dump()
    return keys | {"origin": list(keys["origin"]), "negate": int(keys["negate"])}


def _description(path: Path) -> MapFile:
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        return MapFile.model_validate(content)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise BenchError(f"map {path}: cannot be read: {' '.join(str(error).split())}") from None
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"]) or "the file"
        raise BenchError(f"map {path}: {key}: {first['msg']}") from None


def _occupied_share(image: Path, path: Path, negate: bool) -> NDArray[np.float64]:
    """(rows, cols) float64, 0…1: row = y, up."""
    grey = cv2.imread(str(image), cv2.IMREAD_GRAYSCALE) if image.is_file() else None
    if grey is None:
        raise BenchError(f"map {path}: its picture {image} is missing or no picture")
    share = grey.astype(np.float64) / 255.0
    return np.flipud(share if negate else 1.0 - share)
