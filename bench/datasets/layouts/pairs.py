"""``pairs``: each picture with its diffuse one and its mask, as the study ``pairs`` reads them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from bench.datasets.layout import Files, Layout, Picture, Track
from bench.datasets.model import Row
from bench.pictures import encode_png, read_png


class Pairs:
    """All three 8-bit: sRGB as recorded, sRGB without specular light and noise, highlights as 255."""

    summary = "picture pairs: input, diffuse and mask, each sRGB of 8 bits, for the study pairs"
    suffix = ".png"
    error_unit = ""

    def files(self, picture: Picture) -> Files:
        """Three files; see `Layout.files`."""
        recording = picture.recording
        parts = {"input": recording.image, "diffuse": recording.diffuse, "mask": recording.highlight}
        return Files({_path(part, picture.frame): encode_png(pixels) for part, pixels in parts.items()})

    def lists(self, track: Track, rows: Iterable[Row]) -> Iterator[tuple[str, Iterable[str]]]:
        """None: the names say which files belong together; see `Layout.lists`."""
        yield from ()

    def load(self, folder: Path, row: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        """Picture, diffuse picture and mask; see `Layout.load`."""
        image, diffuse, mask = (
            read_png(folder / _path(part, row["frame"])) for part in ("input", "diffuse", "mask")
        )
        return {"image": image, "diffuse": diffuse, "mask": mask > 0}


def _path(part: str, frame: int) -> str:
    return f"{part}/{frame:06d}.png"


LAYOUTS: dict[str, Layout] = {"pairs": Pairs()}
