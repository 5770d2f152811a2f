"""Is there room for what a job will write?"""

from __future__ import annotations

import shutil
from pathlib import Path

from bench.errors import BenchError


def require_free(folder: Path, needed_bytes: int, remedy: str) -> None:
    """Refuse a folder without room, before hours of work and not after.

    Parameters
    ----------
    folder : Path
        Exists.
    needed_bytes : int
        Estimate of what will be written.
    remedy : str
        What the user can do besides making room.

    Raises
    ------
    BenchError
        If less is free.
    """
    free = shutil.disk_usage(folder).free
    if free < needed_bytes:
        raise BenchError(
            f"{folder}: {free / 1e6:.0f} MB free, about {needed_bytes / 1e6:.0f} MB needed; "
            f"make room or {remedy}"
        )
