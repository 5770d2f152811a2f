"""Is every file of a data set there, and are its bytes those that were written?"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from bench.datasets.files import is_whole, read_json
from bench.datasets.journal import Journal
from bench.datasets.model import MANIFEST, REQUEST, Request, StoredFile
from bench.errors import BenchError
from bench.progress import Progress


@dataclass(frozen=True)
class Verdict:
    """What `verify` found: how many files were looked at, and a line for each that is not as it should be."""

    files: int
    problems: tuple[str, ...]


def read_request(root: Path) -> Request:
    """What a data set was asked to hold.

    Raises
    ------
    BenchError
        If the folder holds none, or it cannot be read.
    """
    path = root / REQUEST
    try:
        return Request.from_json(read_json(path))
    except FileNotFoundError:
        raise BenchError(f"{root}: not a data set (no {REQUEST}); make one with --out {root}") from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BenchError(f"{path}: cannot be read ({error}); make the data set anew with --out") from None


def verify(root: Path, progress: Progress) -> Verdict:
    """Compare every file with its size and SHA-256.

    A data set that is not finished is compared as far as it got, and said to be unfinished.

    Raises
    ------
    BenchError
        If the folder is no data set.
    """
    request = read_request(root)
    problems: list[str] = []
    try:
        listed = read_json(root / MANIFEST)["files"]
        files = [StoredFile(path, f["bytes"], f["sha256"]) for path, f in listed.items()]
    except FileNotFoundError:
        files, problems = _so_far(root, request)
    except (OSError, ValueError, KeyError, TypeError):
        files, problems = _so_far(root, request)
        problems = [f"{MANIFEST}: damaged"]
    with progress.stage("verify", len(files)) as advance:
        for file in files:
            if not is_whole(root, file):
                there = (root / file.path).is_file()
                problems.append(f"{file.path}: {'damaged' if there else 'missing'}")
            advance(1)
    return Verdict(len(files), tuple(problems))


def _so_far(root: Path, request: Request) -> tuple[list[StoredFile], list[str]]:
    journal = Journal(root, request)
    rows = (row for sequence in request.sequences() for row in journal.rows(sequence.name))
    files = [file for row in rows for file in row.files()]
    return files, [f"{MANIFEST}: missing, as only {journal.count()} of {request.pictures} pictures are made"]
