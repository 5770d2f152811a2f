"""Resolve pyproject.toml into lock files with hashes and without any index address."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
HEADER = (
    "# Locked by `make lock` from pyproject.toml, for every platform; installed with pip --require-hashes.\n"
)
LOCKS = {
    "requirements-run.lock": ["--group", "build"],
    "requirements-dev.lock": ["--group", "build", "--group", "dev", "--constraint", "requirements-run.lock"],
}


def compile_lock(name: str, options: list[str]) -> None:
    """Write one lock file; refuse any line that would bind it to one machine or one index."""
    command = [
        sys.executable,
        "-m",
        "uv",
        "pip",
        "compile",
        "pyproject.toml",
        *options,
        "--universal",
        "--generate-hashes",
    ]
    command += ["--no-config", "--no-header", "--no-annotate", "--no-emit-index-url", "--no-emit-find-links"]
    command += ["--python-version", "3.11", "--quiet"]
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PIP_", "UV_"))}
    text = subprocess.run(
        command, cwd=ROOT, env=environment, check=True, capture_output=True, text=True
    ).stdout
    for line in text.splitlines():
        if "://" in line or line.startswith("-") or " @ " in line:
            sys.exit(f"error: {name} would carry an address: {line}")
    (ROOT / name).write_text(HEADER + text, encoding="utf-8")


def main() -> None:
    """Compile both; the second keeps to the versions of the first."""
    for name, options in LOCKS.items():
        compile_lock(name, options)


if __name__ == "__main__":
    main()
