"""Downloads the DLR building log (Kurlbaum & Frese 2009) from its public sources into the user's cache.

What is pinned: both repositories by commit, and every file by SHA-256. The digests were taken from a copy of
the data set. For log and track, that copy and the public files were compared in size and in parts; the
pictures were not, beyond their number. One digest covers them all: the SHA-256 of the lines
``<sha256>  <name>`` of all pictures in order of name. Should a public file differ after all, `fetch_dlr` says
so and refuses it; it keeps nothing that it could not verify. The least-squares solution and the fitted camera
that some copies of the data set hold have no public source and are not fetched.

The data are research data "by courtesy of Udo Frese, DLR / Universität Bremen" without a stated licence: they
are never part of this package.
"""

from __future__ import annotations

import logging
import os
import shutil
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from bench.data import LOG_NAME, TRUTH_NAME
from bench.errors import BenchError
from bench.progress import Progress

BASE_URL = "https://raw.githubusercontent.com"
BASE_URL_VARIABLE = "BENCH_FETCH_URL"  # a mirror with the same paths
_TRACK_SOURCE = "sunzuolei/ccdc15/a5bbcab491d6e914096af5537771d53a864f5a84/Data/DLR"


@dataclass(frozen=True)
class RemoteFile:
    """A file to be: its name here, its path below the base address, its SHA-256 ("" in a pinned set)."""

    name: str
    path: str
    sha256: str = ""


@dataclass(frozen=True)
class PictureSet:
    """The pictures of the log: their number, names, source folder and common digest."""

    count: int
    folder: str
    sha256: str

    def files(self) -> list[RemoteFile]:
        """All pictures in order."""
        names = [f"dlr-spatial_cognition-e.{k:04d}.jpg" for k in range(self.count)]
        return [RemoteFile(name, f"{self.folder}/{name}") for name in names]


DLR_FILES = (
    RemoteFile(
        LOG_NAME,
        "OpenSLAM-org/openslam_slom/845680db7d4faa52a3e6e69393c1887416595204/example/dlr/map.circles",
        "a6a849755dc13768bb31233964ccbd0b8cfd48f5ffc42c6cf73f7ab2a9851563",
    ),
    RemoteFile(
        TRUTH_NAME,
        f"{_TRACK_SOURCE}/truth.txt",
        "3cd9268b81116aec5f5d4af2e98ecf7dc1071ae5e12b16d6697ba13a3f76868d",
    ),
)
DLR_PICTURES = PictureSet(
    3297, f"{_TRACK_SOURCE}/Images", "db785622c839297ae33b5ce115f9297695884a1bfe08d0e4b681f2257d14a7b5"
)


def fetch_dlr(
    folder: Path,
    progress: Progress,
    pictures: PictureSet | None = None,
    files: tuple[RemoteFile, ...] = DLR_FILES,
    base_url: str | None = None,
) -> Path:
    """Download what is missing, verify it, and only then give it its name.

    Parameters
    ----------
    folder : Path
        Where the files go; created where missing.
    progress : Progress
        Shows the stages.
    pictures : PictureSet or None
        `DLR_PICTURES` for the pictures too (101 MB), which go into ``images``. An interrupted download of
        them goes on where it stopped.
    files : tuple of RemoteFile
        What to fetch besides.
    base_url : str, optional
        By default $BENCH_FETCH_URL, else GitHub's raw files.

    Returns
    -------
    Path
        ``folder``.

    Raises
    ------
    BenchError
        If the folder cannot be written, the network fails, or a file is not the one pinned.
    """
    base = base_url or os.environ.get(BASE_URL_VARIABLE) or BASE_URL
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with progress.stage("log", total=len(files)) as advance:
            for file in files:
                _download(file, folder, base)
                advance(1)
        if pictures and not (folder / "images").is_dir():
            _fetch_pictures(pictures, folder, base, progress)
    except OSError as error:
        raise BenchError(
            f"fetch into {folder}: {error.strerror or error}; choose another with --to DIR"
        ) from None
    return folder


def _fetch_pictures(pictures: PictureSet, folder: Path, base: str, progress: Progress) -> None:
    aside = folder / ".images.partial"
    aside.mkdir(exist_ok=True)
    files = pictures.files()
    with progress.stage("pictures", total=len(files)) as advance, ThreadPoolExecutor(8) as threads:
        jobs = [threads.submit(_download, file, aside, base) for file in files]
        try:
            for job in jobs:
                job.result()
                advance(1)
        except BaseException:
            threads.shutdown(cancel_futures=True)
            raise
    if _set_digest(aside, files) != pictures.sha256:
        shutil.rmtree(aside)
        raise BenchError(
            f"fetch: the pictures at {base}/{pictures.folder} are not those pinned; nothing was kept"
        )
    os.replace(aside, folder / "images")


def _set_digest(folder: Path, files: list[RemoteFile]) -> str:
    """SHA-256 of what ``sha256sum *`` prints in the folder."""
    digest = sha256()
    for file in files:
        digest.update(f"{sha256((folder / file.name).read_bytes()).hexdigest()}  {file.name}\n".encode())
    return digest.hexdigest()


def _download(file: RemoteFile, folder: Path, base: str) -> None:
    """Fetch one file; pooch writes aside and renames after the digest is right."""
    import pooch

    pooch.get_logger().setLevel(logging.ERROR)  # the progress bar says it already
    if not file.sha256 and (folder / file.name).is_file():
        return  # a picture of an interrupted download; the whole set is verified in the end
    url = f"{base.rstrip('/')}/{file.path}"
    with _network_errors(url):
        known = f"sha256:{file.sha256}" if file.sha256 else None
        pooch.retrieve(url, known, fname=file.name, path=folder, downloader=pooch.HTTPDownloader(timeout=60))


@contextmanager
def _network_errors(url: str) -> Iterator[None]:
    """One line for whatever requests or pooch raise."""
    import requests

    try:
        yield
    except requests.HTTPError as error:
        answer = error.response.status_code if error.response is not None else "with an error"
        raise BenchError(f"fetch {url}: the server answered {answer}") from None
    except requests.RequestException as error:
        reason = "no connection" if isinstance(error, requests.ConnectionError) else type(error).__name__
        raise BenchError(
            f"fetch {url}: {reason}; check the network, then run the same command again"
        ) from None
    except ValueError as error:
        if "hash" not in str(error):
            raise
        raise BenchError(
            f"fetch {url}: the file is not the one pinned (SHA-256 differs); nothing was kept"
        ) from None
