"""How large a data set becomes and how long it takes, from one frame that is made and thrown away."""

from __future__ import annotations

import shutil
import time
from dataclasses import dataclass, replace

from bench.datasets.frame_writer import FrameWriter, Job
from bench.disk import require_free

MARGIN = 1.1
"""Frames differ in size; so much more than estimated must be free."""


@dataclass(frozen=True)
class Estimate:
    """Of what is still to be made."""

    pictures: int
    bytes: float
    seconds: float

    def __str__(self) -> str:
        return (
            f"{self.pictures:,} pictures, about {_size(self.bytes)}, "
            f"about {_duration(self.seconds)} (measured on one frame)"
        )


def estimate(job: Job, frames: list[int], others: int, processes: int) -> Estimate:
    """Measure the middle one of a place's frames.

    Parameters
    ----------
    frames : list of int
        Still to be made, at least one.
    others : int
        Frames of further places, taken to be like these.

    Raises
    ------
    BenchError
        If the disk has no room for what is to come.
    """
    total = len(frames) + others
    aside = job.root / ".sample"
    try:
        start = time.perf_counter()
        writer = FrameWriter(replace(job, root=aside))
        writer.write(frames[0])  # loads and compiles, as each process will
        ready = time.perf_counter()
        rows = writer.write(frames[len(frames) // 2])
        loading, seconds = ready - start, time.perf_counter() - ready
        writer.close()
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    size = sum(file.bytes for row in rows for layout in row.layouts.values() for file in layout.files)
    each = seconds * total / min(processes, total)
    found = Estimate(total * len(rows), float(size * total), each + (loading if processes > 1 else 0))
    require_free(job.root, int(MARGIN * found.bytes), "take fewer with --frames or --illumination")
    return found


def _size(count: float) -> str:
    return f"{count / 1e9:.1f} GB" if count >= 1e9 else f"{count / 1e6:.1f} MB"


def _duration(seconds: float) -> str:
    if seconds >= 5400:
        return f"{seconds / 3600:.1f} h"
    return f"{seconds / 60:.1f} min" if seconds >= 90 else f"{seconds:.0f} s"
