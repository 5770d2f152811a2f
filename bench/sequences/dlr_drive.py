"""The DLR log as a drive through a building, for the scene that rebuilds it."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np

from bench.sequences import dlr, dlr_paint
from scenes.drive_log import DriveLog

OUTDOORS = (2558, 2793)
"""Steps between the doors, as their pictures show it."""


@lru_cache(maxsize=1)
def drive_log(folder: Path) -> DriveLog:
    """Poses and discs of the least-squares solution (of ``truth.txt`` without one), and who saw whom.

    Pose k belongs to step k, so to picture k; disc k to the k-th of the annotated ids in rising order.

    Raises
    ------
    BenchError
        For a file that is missing or malformed.
    """
    log = dlr.load(folder)
    poses = (log.truth if log.batch_poses is None else log.batch_poses)[1:]
    seen = [observations.ids >= 0 for _, observations in log.steps]
    ids = np.concatenate([o.ids[known] for (_, o), known in zip(log.steps, seen, strict=True)])
    points = np.concatenate([o.points[known] for (_, o), known in zip(log.steps, seen, strict=True)])
    pictures = np.repeat(np.arange(len(seen)), [int(known.sum()) for known in seen])
    discs = np.searchsorted(log.landmark_ids, ids)
    count = len(log.landmark_positions)
    white, light = dlr_paint.read_paint(folder, log.image_names, pictures, discs, points, count)
    outdoors = OUTDOORS if len(poses) >= OUTDOORS[1] else (0, 0)
    sightings = np.stack([pictures, discs], axis=1)
    return DriveLog(poses, log.landmark_positions, white, light, sightings, outdoors)
