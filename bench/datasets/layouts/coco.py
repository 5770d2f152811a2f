"""``coco``: pictures with ``annotations.json`` in COCO's form (Lin et al. 2014), masks run-length encoded."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from bench.datasets import run_length
from bench.datasets.layout import Files, Layout, Picture, Track
from bench.datasets.model import Row
from bench.pictures import encode_png, read_png

CATEGORIES = ("highlight", "saturated")
"""Category ids 1 and 2, as `renderers.truth` defines the masks."""


class Coco:
    """One annotation per mask that is not empty; ``iscrowd`` is 1, as COCO has it for run lengths."""

    summary = "COCO: images and annotations.json with the masks highlight and saturated as RLE"
    suffix = ".png"
    error_unit = ""

    def files(self, picture: Picture) -> Files:
        """The picture; its annotations go to the list; see `Layout.files`."""
        recording = picture.recording
        image = {_path(picture.frame): encode_png(recording.image)}
        marks = []
        for name in CATEGORIES:
            mask = getattr(recording, name)
            if mask.any():
                counts = run_length.compress(run_length.runs(mask))
                mark = {"category": name, "counts": counts, "area": int(mask.sum())}
                marks.append(mark | {"bbox": run_length.box(mask)})
        height, width = recording.highlight.shape
        return Files(image, facts={"size": [height, width], "masks": marks})

    def lists(self, track: Track, rows: Iterable[Row]) -> Iterator[tuple[str, Iterable[str]]]:
        """``annotations.json``; see `Layout.lists`."""
        yield "annotations.json", _annotations(track, rows)

    def load(self, folder: Path, row: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        """The picture alone: pycocotools reads the masks; see `Layout.load`."""
        return {"image": read_png(folder / _path(row["frame"]))}


def _path(frame: int) -> str:
    return f"images/{frame:06d}.png"


def _annotations(track: Track, rows: Iterable[Row]) -> Iterator[str]:
    info = {"description": f"{track.sequence.scene.name} under {track.illumination.name}"}
    categories = [
        {"id": k, "name": name, "supercategory": "light"} for k, name in enumerate(CATEGORIES, start=1)
    ]
    yield f'{{"info": {json.dumps(info)},\n"categories": {json.dumps(categories)},\n"images": ['
    yield from _joined(_image(row) for row in rows)
    yield '],\n"annotations": ['
    yield from _joined(mark for row in rows for mark in _marks(row))
    yield "]}\n"


def _joined(items: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    separator = "\n"
    for item in items:
        yield separator + json.dumps(item)
        separator = ",\n"


def _image(row: Row) -> dict[str, Any]:
    height, width = row.layouts["coco"].facts["size"]
    return {"id": row.frame, "file_name": _path(row.frame), "width": width, "height": height}


def _marks(row: Row) -> Iterator[dict[str, Any]]:
    facts = row.layouts["coco"].facts
    for mark in facts["masks"]:
        category = CATEGORIES.index(mark["category"]) + 1
        yield {
            "id": row.frame * len(CATEGORIES) + category,  # from 1: pycocotools takes 0 for no match
            "image_id": row.frame,
            "category_id": category,
            "segmentation": {"size": facts["size"], "counts": mark["counts"]},
            "area": mark["area"],
            "bbox": mark["bbox"],
            "iscrowd": 1,
        }


LAYOUTS: dict[str, Layout] = {"coco": Coco()}
