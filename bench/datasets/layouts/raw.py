"""``raw``: the sensor's own digital numbers, 16 bits a channel."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.datasets.files import as_json
from bench.datasets.layout import Files, Layout, Picture, Track
from bench.datasets.model import Row
from bench.pictures import encode_png, read_png


class Raw:
    """A PNG of digital numbers as the ADC gave them, not scaled to 16 bits, and the sensor's sheet."""

    summary = "raw digital numbers as 16-bit PNG, before black level, white balance and encoding"
    suffix = ".png"
    error_unit = ""

    def files(self, picture: Picture) -> Files:
        """One PNG; see `Layout.files`."""
        return Files({_path(picture.frame): encode_png(picture.recording.raw)})

    def lists(self, track: Track, rows: Iterable[Row]) -> Iterator[tuple[str, Iterable[str]]]:
        """The sensor's sheet; see `Layout.lists`."""
        from renderers.colour_matrix import correction

        sensor = track.sequence.sensor
        sheet = track.sequence.study.sensor.model_dump(mode="json")
        meaning = (
            "electrons = (number − black_level_dn) / (gain_dn_per_e · 10^(gain_db / 20)); frames.csv has "
            "each picture's exposure_s and gain_db; a mosaic has one channel, by colour_filter_array"
        )
        yield (
            "sensor.json",
            [
                as_json(
                    {
                        "meaning": meaning,
                        "gain_dn_per_e": sensor.amplified(0.0).gain_dn_per_e,
                        "largest_dn": sensor.largest_dn,
                        "colour_matrix": correction(sensor.sensitivities).tolist(),
                        **sheet,
                    }
                )
            ],
        )

    def load(self, folder: Path, row: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        """The numbers as int32, which every array library knows; see `Layout.load`."""
        return {"raw": read_png(folder / _path(row["frame"])).astype(np.int32)}


def _path(frame: int) -> str:
    return f"raw/{frame:06d}.png"


LAYOUTS: dict[str, Layout] = {"raw": Raw()}
