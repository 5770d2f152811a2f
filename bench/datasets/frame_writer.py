"""From a frame of a tour to its files on disk: the work of one process."""

from __future__ import annotations

import functools
import pickle
from dataclasses import dataclass
from pathlib import Path

from bench.datasets.files import store
from bench.datasets.layout import Layout, Picture, Track, layouts
from bench.datasets.model import LayoutRow, Row
from bench.illumination_grid import Illumination
from bench.sequences.rendered import RenderedSequence, SequenceSetup


@dataclass(frozen=True)
class Job:
    """What a process needs to write any frame of a place.

    Attributes
    ----------
    place : str
        Name of the place's folder.
    root : Path
        Of the data set.
    """

    setup: SequenceSetup
    place: str
    illuminations: tuple[Illumination, ...]
    layouts: tuple[str, ...]
    root: Path


class FrameWriter:
    """Renders a frame once and writes it under every illumination in every layout."""

    def __init__(self, job: Job) -> None:
        self._job, self._sequence = job, RenderedSequence(job.setup)
        self._layouts: dict[str, Layout] = {name: layouts()[name] for name in job.layouts}
        self._tracks = [Track(self._sequence, light, job.setup.engine) for light in job.illuminations]

    def write(self, frame: int) -> list[Row]:
        """Write a frame's files; OSError if there is no room for them.

        Returns
        -------
        list of Row
            One per illumination, in their order.
        """
        basis = self._sequence.basis(frame)
        pictures = (
            Picture(track, frame, basis, self._sequence.record(basis, track.illumination, frame))
            for track in self._tracks
        )
        return [self._write(picture) for picture in pictures]

    def close(self) -> None:
        """Give back what the engine holds."""
        self._sequence.renderer.close()

    def _write(self, picture: Picture) -> Row:
        sequence = f"{self._job.place}/{picture.track.illumination.name}"
        rows = {}
        for name, layout in self._layouts.items():
            made = layout.files(picture)
            files = tuple(
                store(self._job.root, f"{name}/{sequence}/{path}", [content])
                for path, content in made.content.items()
            )
            rows[name] = LayoutRow(files, made.error, made.facts)
        recording = picture.recording
        return Row(
            sequence=sequence,
            frame=picture.frame,
            stamp_s=picture.stamp_s,
            pose=tuple(self._sequence.scene.tour.poses[picture.frame].tolist()),
            exposure_s=float(recording.exposure.seconds),
            gain_db=float(recording.exposure.gain_db),
            white_balance=tuple(float(gain) for gain in recording.exposure.white_balance),
            highlight_share=float(recording.highlight.mean()),
            saturated_share=float(recording.saturated.mean()),
            layouts=rows,
        )


@functools.lru_cache(maxsize=1)
def _writer(pickled_job: bytes) -> FrameWriter:
    """The writer of the process it is called in; made once for each place."""
    return FrameWriter(pickle.loads(pickled_job))


def write_frame(task: tuple[bytes, int]) -> list[Row]:
    """Write one frame of a pickled `Job`."""
    pickled_job, frame = task
    return _writer(pickled_job).write(frame)
