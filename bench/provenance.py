"""Where a result comes from: versions, commit, engine, machine, seed, command, time. No host or user name."""

from __future__ import annotations

import os
import platform
import shlex
import subprocess
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = (
    "numpy",
    "scipy",
    "numba",
    "opencv-python-headless",
    "open3d",
    "pyrender2",
    "colour-science",
    "pandas",
    "pyarrow",
    "pydantic",
)


def collect(
    *,
    seed: int,
    engine: str,
    command: Sequence[str] = (),
    seconds: Mapping[str, float] | None = None,
    files: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """Gather everything, ready for JSON.

    Parameters
    ----------
    seed : int
        The study's seed.
    engine : str
        The engine that rendered, not the one asked for; "none" for a replay.
    command : sequence of str
        The command line as typed; the home folder in it becomes ``~``.
    seconds : mapping of str to float
        Wall-clock seconds per stage.
    files : mapping of str to str
        SHA-256 of the user's files by path (`bench.named_files`).
    """
    return {
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": _without_home(shlex.join(command)),
        "seed": seed,
        "engine": engine,
        "seconds": {stage: round(value, 3) for stage, value in (seconds or {}).items()},
        "files_sha256": {_without_home(path): digest for path, digest in (files or {}).items()},
        "glarebench": version("glarebench"),
        "git": commit(),
        "python": platform.python_version(),
        "packages": {name: version(name) for name in PACKAGES},
        "machine": machine(),
    }


def version(package: str) -> str:
    """The installed version, or "not installed"."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def commit(root: Path = ROOT) -> dict[str, Any] | None:
    """The checkout's commit, and whether tracked files differ from it; None outside a checkout."""
    if not (root / ".git").exists():  # installed packages may lie inside some other project's checkout
        return None
    try:
        head = _git(root, "rev-parse", "HEAD")
        return {"commit": head, "dirty": bool(_git(root, "status", "--porcelain", "--untracked-files=no"))}
    except (OSError, subprocess.CalledProcessError):
        return None


def machine() -> dict[str, Any]:
    """Cores this process may use, memory in GB, system and processor."""
    return {
        "cores": cores(),
        "memory_gb": round(memory_bytes() / 1e9, 1),
        "system": f"{platform.system()} {platform.release()}",
        "processor": _processor(),
    }


def cores() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def memory_bytes() -> int:
    """Physical memory."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _git(root: Path, *arguments: str) -> str:
    command = ["git", "-C", str(root), *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.machine()
    return next(
        (line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine()
    )


def _without_home(text: str) -> str:
    home = str(Path.home())
    return text.replace(home, "~") if len(home) > 1 else text
