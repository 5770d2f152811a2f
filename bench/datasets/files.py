"""Files that are whole or not there, and their digests."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from bench.datasets.model import StoredFile


def store(root: Path, path: str, pieces: Iterable[bytes]) -> StoredFile:
    """Write a file aside and rename it; a file that is there is replaced.

    Parameters
    ----------
    path : str
        From ``root``, with slashes; its folder is made where missing.
    pieces : iterable of bytes
        Written one after the other, so that a long file needs no memory.

    Raises
    ------
    OSError
        With the file's name, if it cannot be written; nothing is left of it then.
    """
    target = root / path
    aside = target.with_name(f".{target.name}.partial")
    digest, size = hashlib.sha256(), 0
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with aside.open("wb") as file:
            for piece in pieces:
                file.write(piece)
                digest.update(piece)
                size += len(piece)
        os.replace(aside, target)
    except OSError as error:
        aside.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, str(target)) from None
    return StoredFile(path, size, digest.hexdigest())


def store_text(root: Path, path: str, pieces: Iterable[str]) -> StoredFile:
    """The same for text, UTF-8."""
    return store(root, path, (piece.encode() for piece in pieces))


def as_json(value: object) -> str:
    """JSON with two spaces of indent and a last newline."""
    return json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def is_whole(root: Path, file: StoredFile) -> bool:
    """Whether a file is there with its size and digest."""
    path = root / file.path
    try:
        if path.stat().st_size != file.bytes:
            return False
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest() == file.sha256
    except OSError:
        return False


def read_json(path: Path) -> Any:
    """Read a JSON file; OSError or ValueError if that cannot be done."""
    return json.loads(path.read_text(encoding="utf-8"))
