"""``generate``: pictures of a data set per second on disk, against PNG encoding and writing alone.

Ours: a task of `bench.generate` in the layout ``tum``: render the pose, then for each illumination relight,
record, encode five PNGs, digest and write them. Baseline: the same five pictures, already in memory, are
encoded and written, nothing else. Both sides work in the same processes, one for each core, on the same disk.
"""

from __future__ import annotations

import functools
import os
import pickle
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from bench.datasets.frame_writer import Job, write_frame
from bench.kinds.rendered import RenderedStudy
from bench.pictures import encode_png, read_png
from bench.sequences.lighting import light_colours
from bench.sequences.rendered import RenderedSequence, SequenceSetup
from bench.speed import stage
from bench.speed.model import Benchmark, Configuration, Sides
from bench.workers import workers
from renderers.engine import choose_engine


def job(configuration: Configuration, root: Path) -> Job:
    """The corridor through a pinhole, under a log sweep of suns."""
    study = RenderedStudy.model_validate(
        {
            "sequence": "rendered",
            "name": "speed",
            "scene": {"seed": stage.SEED, "parameters": {"laps": configuration.laps}},
            "camera": {
                "model": "pinhole",
                "width": configuration.width,
                "height": configuration.height,
                "fov_deg": stage.FOV_DEG,
            },
            "illuminations": {
                "sun_lux": {"log": [100, 100_000], "steps": configuration.illuminations},
                "bulb_lm": [800],
            },
        }
    )
    colours = light_colours(study, configuration.cache)
    setup = SequenceSetup(
        study, choose_engine("auto").name, colours, 1, configuration.cache, stage.quality(configuration)
    )
    return Job(setup, "corridor", tuple(study.illuminations.grid()), ("tum",), root)


@functools.lru_cache(maxsize=8)
def _pictures(folder: Path, frame: int) -> list[tuple[Path, NDArray[Any]]]:
    """A frame's pictures as ours wrote them, and where the baseline puts them."""
    found = sorted((folder / "tum").rglob(f"{frame:06d}.png"))
    aside = [folder / "alone" / "-".join(path.relative_to(folder).parts) for path in found]
    return [(target, read_png(path)) for target, path in zip(aside, found, strict=True)]


def _ours(task: tuple[bytes, int]) -> int:
    return len(write_frame(task))


def _baseline(task: tuple[Path, int]) -> int:
    pictures = _pictures(*task)
    for path, picture in pictures:
        path.write_bytes(encode_png(picture))
    return len(pictures) // 5


@contextmanager
def prepare(configuration: Configuration) -> Iterator[Sides]:
    """Bake into the cache and open the processes."""
    with (
        tempfile.TemporaryDirectory(dir=configuration.cache) as folder,
        workers(configuration.processes) as pool,
    ):
        root = Path(folder)
        (root / "alone").mkdir()
        work = job(configuration, root)
        baking = replace(work.setup, engine="raycast", threads=0)
        RenderedSequence(baking).renderer.close()
        pickled, frames = pickle.dumps(work), range(configuration.poses)
        disk = write_speed(root)

        def note(rate: float, _: float) -> str:
            size = sum(path.stat().st_size for path in (root / "tum").rglob("*.png"))
            each = size / (configuration.poses * len(work.illuminations))
            return (
                f"{configuration.processes} processes; {each / 1e6:.2f} MB a picture: "
                f"{rate * each / 1e6:.0f} MB/s, {100 * rate * each / disk:.0f} % of the "
                f"{disk / 1e6:.0f} MB/s that the disk takes"
            )

        yield Sides(
            lambda: sum(pool.map(_ours, [(pickled, frame) for frame in frames])),
            lambda: sum(pool.map(_baseline, [(root, frame) for frame in frames])),
            note,
        )


def write_speed(folder: Path, size: int = 64_000_000) -> float:
    """Bytes per second that the disk takes from one process, until they are on it."""
    path, block = folder / "probe", os.urandom(4_000_000)
    start = time.perf_counter()
    with path.open("wb") as file:
        for _ in range(max(size // len(block), 1)):
            file.write(block)
        file.flush()
        os.fsync(file.fileno())
    seconds = time.perf_counter() - start
    path.unlink()
    return max(size // len(block), 1) * len(block) / seconds


BENCHMARK = Benchmark(
    "generate",
    "pictures of a data set on disk, against PNG encoding and writing alone",
    "pictures/s",
    True,
    "ratio ≥ 0.4",
    prepare,
)
