"""``exr`` and ``exr-float``: linear light in layers of one OpenEXR file per picture.

Channels ``diffuse.R/G/B`` and ``specular.R/G/B`` in 16-bit half or 32-bit float, their sum as ``R``, ``G``,
``B``, which is what plain viewers show, and ``depth.Z``, metres, always 32-bit float. A value times the
standard attribute ``whiteLuminance`` is cd/m²: a power of two, so that scaling by it is exact, and large
enough for highlights of 4 million cd/m² in half; brighter ones are clipped there.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from bench.datasets.layout import Files, Layout, Picture, Track
from bench.datasets.model import Row
from bench.errors import BenchError

WHITE_LUMINANCE = 64.0
"""cd/m² of the value 1."""


class Exr:
    """The layers with light as ``dtype``."""

    suffix = ".exr"
    error_unit = "of the sum, or of the smallest normal number where the sum is below it"

    def __init__(self, dtype: DTypeLike, name: str) -> None:
        self._dtype = np.dtype(dtype)
        self.summary = f"OpenEXR: diffuse.RGB, specular.RGB and their sum as {name}, depth.Z in metres"

    def files(self, picture: Picture) -> Files:
        """One file of ten channels; see `Layout.files`."""
        diffuse, specular = picture.light
        layers = {
            "": self._stored(diffuse + specular),
            "diffuse.": self._stored(diffuse),
            "specular.": self._stored(specular),
        }
        channels = {
            f"{layer}{c}": np.ascontiguousarray(pixels[..., k])
            for layer, pixels in layers.items()
            for k, c in enumerate("RGB")
        }
        channels["depth.Z"] = picture.basis.depth
        content = {_path(picture.frame): _encode(channels)}
        return Files(content, self._error(*layers.values()))

    def lists(self, track: Track, rows: Iterable[Row]) -> Iterator[tuple[str, Iterable[str]]]:
        """None: the files speak for themselves; see `Layout.lists`."""
        yield from ()

    def load(self, folder: Path, row: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        """Luminance of full, diffuse and specular light in cd/m², and depth; see `Layout.load`."""
        import OpenEXR

        path = folder / _path(row["frame"])
        try:
            with OpenEXR.File(str(path), separate_channels=True) as file:
                pixels = {name: channel.pixels for name, channel in file.channels().items()}
                white = np.float32(file.header()["whiteLuminance"])
        except (OSError, RuntimeError, KeyError) as error:
            raise BenchError(f"{path}: cannot be read as OpenEXR ({error})") from None
        light = {
            name: white * np.stack([pixels[f"{layer}{c}"] for c in "RGB"], axis=-1).astype(np.float32)
            for name, layer in (("full", ""), ("diffuse", "diffuse."), ("specular", "specular."))
        }
        return {**light, "depth": pixels["depth.Z"].copy()}

    def _stored(self, luminance: NDArray[np.float32]) -> NDArray[np.floating[Any]]:
        largest = np.finfo(self._dtype).max
        return np.minimum(luminance / np.float32(WHITE_LUMINANCE), np.float32(largest)).astype(self._dtype)

    def _error(self, full: NDArray[Any], diffuse: NDArray[Any], specular: NDArray[Any]) -> float:
        exact = full.astype(np.float64)
        error = np.abs(exact - (diffuse.astype(np.float64) + specular.astype(np.float64)))
        return float((error / np.maximum(exact, np.finfo(self._dtype).smallest_normal)).max(initial=0.0))


def _path(frame: int) -> str:
    return f"{frame:06d}.exr"


def _encode(channels: Mapping[str, NDArray[Any]]) -> bytes:
    import OpenEXR

    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "whiteLuminance": WHITE_LUMINANCE,
    }
    stream = io.BytesIO()
    with OpenEXR.File(header, dict(channels), num_threads=0) as file:
        file.write(stream)
    return stream.getvalue()


LAYOUTS: dict[str, Layout] = {
    "exr": Exr(np.float16, "16-bit half"),
    "exr-float": Exr(np.float32, "32-bit float"),
}
