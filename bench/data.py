"""Where data folders are found: --data DIR, then $BENCH_DATA, then the user's cache."""

from __future__ import annotations

import os
from pathlib import Path

from bench.errors import BenchError

LOG_NAME = "map.circles"
TRUTH_NAME = "truth.txt"


def cache_folder() -> Path:
    """The user's cache of this program, where `fetch` puts data."""
    import platformdirs

    return platformdirs.user_cache_path("glarebench")


def dlr_folder(explicit: Path | None = None) -> Path:
    """Find the folder of the DLR building log.

    Parameters
    ----------
    explicit : Path or None
        From ``--data``: the folder itself, or one that holds it as ``dlr``. Nothing else is searched then.

    Returns
    -------
    Path
        A folder that holds ``map.circles`` and ``truth.txt``.

    Raises
    ------
    BenchError
        If there is none; names every place that was searched.
    """
    if explicit is not None:
        places: dict[str, Path | None] = {
            f"--data {explicit}": explicit,
            f"--data {explicit}/dlr": explicit / "dlr",
        }
    else:
        base = os.environ.get("BENCH_DATA")
        places = {"--data DIR (not given)": None}
        places[f"$BENCH_DATA/dlr ({base + '/dlr' if base else 'not set'})"] = (
            Path(base, "dlr") if base else None
        )
        places[f"the cache {cache_folder() / 'dlr'}"] = cache_folder() / "dlr"
    for folder in places.values():
        if folder and all((folder / name).is_file() for name in (LOG_NAME, TRUTH_NAME)):
            return folder
    raise BenchError(
        f"DLR log: no folder with {LOG_NAME} and {TRUTH_NAME}; searched {', '.join(places)}; "
        "get it with: python -m bench fetch dlr"
    )
