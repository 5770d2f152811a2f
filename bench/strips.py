"""Picture strips for the report: raw, true mask, predicted mask, repaired, true diffuse."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.perception import make_filter
from bench.pictures import write_png
from bench.sequences.rendered import RenderedSequence
from vslam.filters.apply import apply

Row = dict[str, Any]
RANKS = ("best", "median", "worst")
PICTURES = ("raw", "true_mask", "predicted_mask", "repaired", "true_diffuse")


@dataclass(frozen=True)
class Choice:
    """A frame worth showing of a filter."""

    rank: str
    row: Row


@dataclass(frozen=True, eq=False)
class Strip:
    """The pictures of a choice by kind: (H, W, 3) uint8, or (H, W) bool for a mask."""

    choice: Choice
    pictures: dict[str, NDArray[np.uint8] | NDArray[np.bool_]]


def choose(rows: Sequence[Row]) -> list[Choice]:
    """Of each filter the frames with the best, the median and the worst change of PSNR.

    The change is against doing nothing to the same picture, so that a dim picture, which any filter leaves
    close to its target, does not pass for a good repair.
    """
    untouched = {_picture(r): r["psnr_db"] for r in rows if r["filter"] == "none"}
    choices = []
    for label in dict.fromkeys(r["filter"] for r in rows if r["filter"] != "none"):
        own = [r for r in rows if r["filter"] == label]
        change = np.array([r["psnr_db"] - untouched[_picture(r)] for r in own])
        finite = np.flatnonzero(np.isfinite(change))
        if len(finite) == 0:
            continue
        order = finite[np.argsort(change[finite], kind="stable")]
        for rank, place in zip(RANKS, (order[-1], order[len(order) // 2], order[0]), strict=True):
            choices.append(Choice(rank, own[place]))
    return choices


def _picture(row: Row) -> tuple[Any, ...]:
    """Which picture a filter was given."""
    return row["scene"], row["illumination"], row["frame"]


def render(choice: Choice, sequence: RenderedSequence) -> Strip:
    """Render a chosen frame again and filter it.

    Raises
    ------
    FilterFailureError
        When the filter fails on the picture that it has filtered before.
    """
    study, row = sequence.study, choice.row
    illumination = next(i for i in study.illuminations.grid() if i.name == row["illumination"])
    light_filter = next(make_filter(f) for f in study.filters if f.label == row["filter"])
    frame = row["frame"]
    recording = sequence.record(sequence.basis(frame), illumination, frame)
    filtered = apply(light_filter, recording.image)
    pictures = (recording.image, recording.highlight, filtered.mask, filtered.image, recording.diffuse)
    return Strip(choice, dict(zip(PICTURES, pictures, strict=True)))


def write(folder: Path, shown: Sequence[Strip]) -> None:
    """Write ``strips/*.png`` and ``strips.csv`` into ``folder``."""
    (folder / "strips").mkdir(exist_ok=True)
    table = []
    for strip in shown:
        row, rank = strip.choice.row, strip.choice.rank
        labels = {k: row[k] for k in ("scene", "illumination", "filter", "frame")}
        stem = "--".join([*(str(v) for v in labels.values()), rank])
        names = {kind: f"{stem}-{kind.replace('_', '-')}.png" for kind in PICTURES}
        for kind, picture in strip.pictures.items():
            write_png(folder / "strips" / names[kind], picture)
        table.append({**labels, "rank": rank, "iou": row["iou"], "psnr_db": row["psnr_db"], **names})
    (folder / "strips.csv").write_text(_csv(table), encoding="utf-8")


def _csv(table: Sequence[Row]) -> str:
    head = ("scene", "illumination", "filter", "frame", "rank", "iou", "psnr_db", *PICTURES)
    text = io.StringIO()
    writer = csv.DictWriter(text, head, lineterminator="\n")
    writer.writeheader()
    writer.writerows(table)
    return text.getvalue()
