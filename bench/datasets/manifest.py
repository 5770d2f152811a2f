"""What closes a data set: each sequence's lists, ``frames.csv``, the index in order, ``dataset.json``."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict
from itertools import chain
from pathlib import Path
from typing import Any

from bench.datasets.croissant import croissant
from bench.datasets.files import as_json, store, store_text
from bench.datasets.journal import Journal, to_line
from bench.datasets.layout import Track, layouts
from bench.datasets.model import (
    CROISSANT,
    MANIFEST,
    PICTURES,
    REQUEST,
    TABLE,
    Request,
    Row,
    Sequence,
    StoredFile,
)
from bench.sequences.rendered import RenderedSequence, SequenceSetup

FORMAT = "glarebench data set 1"
COLUMNS = (
    *("sequence", "split", "scene", "illumination", "frame", "stamp_s", "x_m", "y_m", "heading_rad"),
    *(
        "exposure_ev",
        "exposure_s",
        "gain_db",
        "white_r",
        "white_g",
        "white_b",
        "highlight_share",
        "saturated_share",
    ),
)
"""Of ``frames.csv``; one more per layout, with the path of its picture."""


def close(root: Path, request: Request) -> None:
    """Write all that follows from the index, ``dataset.json`` last; OSError if there is no room.

    The same bytes come out in whatever order and in however many attempts the pictures were made.
    """
    journal = Journal(root, request)
    closing = [file for s in request.sequences() for file in _lists(root, request, s, journal)]
    closing.append(store_text(root, TABLE, _table(request, journal)))
    closing.append(store(root, PICTURES, (to_line(row) for row in _rows(request, journal))))
    journal = Journal(root, request)  # the lines have moved
    closing.append(store_text(root, CROISSANT, [as_json(croissant(request, closing))]))
    closing.append(store_text(root, REQUEST, [as_json(request.to_json())]))
    files = chain(sorted(closing, key=lambda f: f.path), _files(request, journal))
    store_text(root, MANIFEST, _manifest(_head(request, journal), files))


def _lists(root: Path, request: Request, sequence: Sequence, journal: Journal) -> Iterator[StoredFile]:
    setup = SequenceSetup(sequence.place.study, request.engine, {}, 0, None)
    track = Track(RenderedSequence(setup), sequence.illumination, request.engine)
    known = layouts()
    for layout in request.layouts:
        for path, pieces in known[layout].lists(track, journal.rows(sequence.name)):
            yield store_text(root, f"{layout}/{sequence.name}/{path}", pieces)


def _rows(request: Request, journal: Journal) -> Iterator[Row]:
    for sequence in request.sequences():
        yield from journal.rows(sequence.name)


def _files(request: Request, journal: Journal) -> Iterator[StoredFile]:
    for row in _rows(request, journal):
        yield from row.files()


def _table(request: Request, journal: Journal) -> Iterator[str]:
    yield ",".join([*COLUMNS, *request.layouts]) + "\n"
    for sequence in request.sequences():
        place = sequence.place
        labels = [sequence.name, place.split, place.study.scene.name, sequence.illumination.name]
        for row in journal.rows(sequence.name):
            numbers = [row.stamp_s, *row.pose, sequence.illumination.exposure_ev, row.exposure_s]
            numbers += [row.gain_db, *row.white_balance, row.highlight_share, row.saturated_share]
            paths = [row.layouts[layout].files[0].path for layout in request.layouts]
            yield ",".join([*labels, str(row.frame), *map(repr, numbers), *paths]) + "\n"


def _head(request: Request, journal: Journal) -> dict[str, Any]:
    errors: dict[str, float | None] = dict.fromkeys(request.layouts)
    for row in _rows(request, journal):
        for name, layout in row.layouts.items():
            if layout.error is not None:
                errors[name] = max(errors[name] or 0.0, layout.error)
    sequences = request.sequences()
    splits: dict[str, list[str]] = {}
    for sequence in sequences:
        splits.setdefault(sequence.place.split, []).append(sequence.name)
    return {
        "format": FORMAT,
        "glarebench": request.glarebench,
        "engine": request.engine,
        "pictures": request.pictures,
        "layouts": {name: _layout(name, error) for name, error in errors.items()},
        "splits": splits,
        "sequences": [_sequence(sequence) for sequence in sequences],
    }


def _layout(name: str, error: float | None) -> dict[str, Any]:
    layout = layouts()[name]
    if error is None:
        return {"summary": layout.summary}
    largest = {"value": error, "unit": layout.error_unit}
    return {"summary": layout.summary, "largest_error_of_full_minus_diffuse_plus_specular": largest}


def _sequence(sequence: Sequence) -> dict[str, Any]:
    place = sequence.place
    return {
        "name": sequence.name,
        "split": place.split,
        "scene": place.study.scene.model_dump(mode="json"),
        "illumination": asdict(sequence.illumination),
        "frames": place.frames,
    }


def _manifest(head: dict[str, Any], files: Iterable[StoredFile]) -> Iterator[str]:
    """JSON with a line per file, piece by piece, as there may be very many."""
    yield as_json(head).rstrip().removesuffix("}").rstrip() + ',\n  "files": {'
    separator = "\n"
    for file in files:
        facts = {"bytes": file.bytes, "sha256": file.sha256}
        yield f"{separator}    {json.dumps(file.path)}: {json.dumps(facts)}"
        separator = ",\n"
    yield "\n  }\n}\n"
