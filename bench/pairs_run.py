"""Picture pairs: every filter on every picture, scored as the literature of highlight removal does."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench import strips
from bench.errors import BenchError
from bench.filter_choice import FilterChoice
from bench.kinds.pairs import PairsStudy
from bench.metrics import mask as mask_metrics
from bench.metrics import picture_pairs
from bench.options import RunOptions
from bench.perception import make_filter
from bench.pictures import reduced
from bench.progress import Progress
from bench.run_facts import RunFacts
from bench.schema import MASK_COLUMNS, PICTURE_COLUMNS
from bench.sequences.pairs import PairFiles, PicturePair, as_light, find, load
from bench.store import RunFolder
from bench.workers import workers
from vslam.filters.apply import FilterFailureError, apply
from vslam.filters.base import Encoding, Filtered, LightFilter, PictureCalibration

Row = dict[str, Any]
GIVEN = "given mask"
SHOWN_SIDE = 320  # pixels: larger pictures are shown reduced


@dataclass(frozen=True)
class _Task:
    """All that one picture needs, for a worker process."""

    files: PairFiles
    filters: tuple[FilterChoice, ...]
    linear: bool
    thresholds: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class _Scored:
    pictures: list[Row]
    masks: list[Row]


def run(study: PairsStudy, folder: RunFolder, options: RunOptions, progress: Progress) -> RunFacts:
    """Score the pairs of ``--data`` into a run folder; the tables of frames and SLAM runs stay empty."""
    if options.data is None:
        raise BenchError(
            "picture pairs: name their folder with --data DIR (DIR/input, DIR/diffuse, DIR/mask)"
        )
    facts = RunFacts("none")
    tasks = [_Task(f, study.filters, study.linear, study.thresholds) for f in find(options.data)]
    pictures: list[Row] = []
    masks: list[Row] = []
    with facts.timed("filter"), workers(options.workers) as pool:
        with progress.stage("filter", len(tasks)) as advance:
            for scored in pool.map(_score_picture, tasks):
                pictures += scored.pictures
                masks += scored.masks
                advance(1)
        by_name = {task.files.name: task for task in tasks}
        chosen = strips.choose(_as_frames(pictures, options.data))
        shown = list(pool.map(_show, [(by_name[c.row["illumination"]], c) for c in chosen]))
    folder.write_frames([])
    folder.write_runs([])
    folder.write_table("pictures.parquet", pictures, PICTURE_COLUMNS)
    folder.write_table("masks.parquet", masks, MASK_COLUMNS)
    strips.write(folder.path / "figures", shown)
    return facts


def true_masks(pair: PicturePair, thresholds: Sequence[int]) -> dict[str, NDArray[np.bool_]]:
    """The true masks of a pair by name: where the residue exceeds τ of 255 in any channel, and the given one.

    Parameters
    ----------
    pair : PicturePair
    thresholds : ints
        τ, grey levels of 255, in the encoding of the files.
    """
    residue = (as_light(pair.picture) - pair.diffuse).max(axis=2)
    masks = {f"residue > {tau}": residue > tau / 255 for tau in thresholds}
    return masks if pair.mask is None else masks | {GIVEN: pair.mask}


def _score_picture(task: _Task) -> _Scored:
    pair = load(task.files)
    truths = true_masks(pair, task.thresholds)
    in_mask = truths.get(GIVEN, truths[f"residue > {task.thresholds[len(task.thresholds) // 2]}"])
    scored = _Scored([], [])
    for choice in task.filters:
        labels = {"picture": pair.name, "filter": choice.label}
        light_filter = make_filter(choice)
        start = time.perf_counter()
        try:
            filtered = _filtered(pair, light_filter, task.linear)
        except FilterFailureError as error:
            scored.pictures.append(_failed(pair, error.reason) | labels)
            continue
        seconds = time.perf_counter() - start
        scores = picture_pairs.evaluate(as_light(filtered.image), pair.diffuse, in_mask, task.linear)
        size = {"height": pair.picture.shape[0], "width": pair.picture.shape[1]}
        scored.pictures.append(labels | size | vars(scores) | {"filter_ms": 1e3 * seconds, "status": "ok"})
        for name, truth in truths.items():
            found = mask_metrics.evaluate(filtered.mask, truth, filtered.score)
            scored.masks.append(labels | {"truth": name} | vars(found))
    return scored


def _filtered(pair: PicturePair, light_filter: LightFilter, linear: bool) -> Filtered:
    encoding = Encoding.LINEAR if linear else Encoding.SRGB
    return apply(light_filter, pair.picture, PictureCalibration(encoding))


def _failed(pair: PicturePair, reason: str) -> Row:
    empty: Row = {name: math.nan for name, kind in PICTURE_COLUMNS.items() if kind == "float64"}
    height, width = pair.picture.shape[:2]
    return empty | {"height": height, "width": width, "status": f"failed: {reason}"}


def _as_frames(pictures: Sequence[Row], data: Path) -> list[Row]:
    """Rows as `bench.strips` chooses from: a picture stands for an illumination of its own."""
    place = {name: k for k, name in enumerate(dict.fromkeys(row["picture"] for row in pictures))}
    return [
        {
            "scene": data.resolve().name,
            "illumination": row["picture"],
            "frame": place[row["picture"]],
            "filter": row["filter"],
            "psnr_db": row["psnr_db"],
            "iou": math.nan,
        }
        for row in pictures
    ]


def _show(task: tuple[_Task, strips.Choice]) -> strips.Strip:
    told, choice = task
    pair = load(told.files)
    light_filter = next(make_filter(f) for f in told.filters if f.label == choice.row["filter"])
    filtered = _filtered(pair, light_filter, told.linear)
    truth = list(true_masks(pair, told.thresholds).values())[-1]
    pictures = (pair.picture, truth, filtered.mask, filtered.image, pair.diffuse)
    shown = [_for_show(p, told.linear) for p in pictures]
    return strips.Strip(choice, dict(zip(strips.PICTURES, shown, strict=True)))


def _for_show(picture: NDArray[Any], linear: bool) -> NDArray[Any]:
    """8-bit sRGB, or a mask, no larger than the page shows it."""
    from vslam.filters.stages.srgb import encode

    if picture.dtype == np.bool_:
        return reduced(picture, SHOWN_SIDE)
    values = reduced(as_light(picture), SHOWN_SIDE)
    return encode(values.astype(np.float32)) if linear else np.rint(255 * values).astype(np.uint8)
