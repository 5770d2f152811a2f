"""Picture strips for the report: raw, true mask, predicted mask, repaired, true diffuse."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.perception import make_filter
from bench.pictures import write_png
from bench.sequences.rendered import RenderedSequence
from bench.study_model import Illumination

Row = dict[str, object]
RANKS = ("best", "median", "worst")
PICTURES = ("raw", "true_mask", "predicted_mask", "repaired", "true_diffuse")


@dataclass(frozen=True)
class Choice:
    """A frame worth showing of a filter."""

    rank: str
    row: Row


def choose(rows: Sequence[Row]) -> list[Choice]:
    """Of each filter the frames with the best, the median and the worst change of PSNR.

    The change is against doing nothing to the same picture, so that a dim picture, which any filter leaves
    close to its target, does not pass for a good repair.
    """
    untouched = {(r["illumination"], r["frame"]): r["psnr_db"] for r in rows if r["filter"] == "none"}
    choices = []
    for label in dict.fromkeys(r["filter"] for r in rows if r["filter"] != "none"):
        own = [r for r in rows if r["filter"] == label]
        change = np.array([float(r["psnr_db"]) - float(untouched[r["illumination"], r["frame"]]) for r in own])  # type: ignore[arg-type]
        finite = np.flatnonzero(np.isfinite(change))
        if len(finite) == 0:
            continue
        order = finite[np.argsort(change[finite], kind="stable")]
        for rank, place in zip(RANKS, (order[-1], order[len(order) // 2], order[0]), strict=True):
            choices.append(Choice(rank, own[place]))
    return choices


def write(folder: Path, choices: Sequence[Choice], sequence: RenderedSequence) -> None:
    """Render the chosen frames again and write ``strips/*.png`` and ``strips.csv`` into ``folder``."""
    (folder / "strips").mkdir(exist_ok=True)
    filters = {choice.label: make_filter(choice) for choice in sequence.study.filters}
    illuminations: dict[object, Illumination] = {i.name: i for i in sequence.study.illuminations.grid()}
    table = []
    for choice in choices:
        row = choice.row
        frame = int(str(row["frame"]))
        recording = sequence.record(sequence.basis(frame), illuminations[row["illumination"]], frame)
        filtered = filters[str(row["filter"])](recording.image)
        pictures = (
            recording.image,
            recording.highlight,
            filtered.mask,
            filtered.image,
            recording.diffuse,
        )
        labels = {k: row[k] for k in ("scene", "illumination", "filter", "frame")}
        stem = "--".join(str(v) for v in labels.values()) + f"--{choice.rank}"
        names = {kind: f"{stem}-{kind.replace('_', '-')}.png" for kind in PICTURES}
        for kind, picture in zip(PICTURES, pictures, strict=True):
            write_png(folder / "strips" / names[kind], picture)
        table.append({**labels, "rank": choice.rank, "iou": row["iou"], "psnr_db": row["psnr_db"], **names})
    (folder / "strips.csv").write_text(_csv(table), encoding="utf-8")


def _csv(table: Sequence[Row]) -> str:
    head = ("scene", "illumination", "filter", "frame", "rank", "iou", "psnr_db", *PICTURES)
    text = io.StringIO()
    writer = csv.DictWriter(text, head, lineterminator="\n")
    writer.writeheader()
    writer.writerows(table)
    return text.getvalue()
