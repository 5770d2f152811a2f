"""Score `guarded` beside the field's methods on a split of the rendered scenes.

    python -m tools.guarded.evaluate --split test --scenes 2 --poses 4 --out results/guarded

Writes ``rows.csv`` (a row per picture and filter) and ``report.md``. Intervals are percentile bootstraps over
the poses, each drawn with all its lights; every comparison is paired.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import cv2
import pandas as pd

from bench.metrics import detection, mask, restoration
from bench.sequences.rendered import calibration
from tools.guarded.pictures import BAKE, FAMILIES
from tools.guarded.summary import report
from tools.guarded.trials import Trial, study_of, trials
from vslam.detect import DetectorSettings, DiscDetector
from vslam.filters import create
from vslam.filters.apply import apply
from vslam.filters.base import Filtered, LightFilter

FIELD = (
    "mean_sd", "intensity_ratio", "arnold2010", "meslouhi2011",
    "shen2009", "yang2010", "shen2013", "yamamoto2019", "tan2005",
)  # fmt: skip
OURS = ("seed", "seed_per_pixel", "guarded")
ORACLE = "oracle"
"""The true mask with the true diffuse picture inside it: what the best filter could give."""


def main(arguments: list[str] | None = None) -> int:
    """Render, filter, score, write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--split", default="test", choices=("train", "validation", "test"))
    parser.add_argument("--scenes", type=int, default=2, help="of each family")
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument("--poses", type=int, default=4, help="of each scene")
    parser.add_argument("--families", nargs="+", default=FAMILIES, choices=FAMILIES)
    parser.add_argument("--filters", nargs="+", default=(*FIELD, *OURS))
    parser.add_argument("--coarse", action="store_true", help="bake light as the training pictures do")
    parser.add_argument("--cache", type=Path, default=Path.home() / ".cache" / "glarebench-guarded")
    parser.add_argument("--out", type=Path, required=True)
    chosen = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    filters = {name: create(name) for name in ("none", *chosen.filters)}
    rows: list[dict[str, object]] = []
    quality = {"quality": BAKE} if chosen.coarse else {}
    for number in range(chosen.first, chosen.first + chosen.scenes):
        for family in chosen.families:
            study = study_of(family, chosen.split, number)
            settings = DetectorSettings(study.discs.min_radius_m, study.discs.max_radius_m)
            detect = DiscDetector(calibration(study), settings)
            for trial in trials(family, chosen.split, number, chosen.poses, chosen.cache, **quality):
                rows += _rows(trial, _tried(filters, trial.matt), detect)
            print(f"{family} {number}: {len(rows)} rows", file=sys.stderr, flush=True)
    chosen.out.mkdir(parents=True, exist_ok=True)
    table = pd.DataFrame(rows)
    table.to_csv(chosen.out / "rows.csv", index=False)
    text = report(table, chosen.split)
    (chosen.out / "report.md").write_text(text, encoding="utf-8")
    print(text)
    return 0


def _tried(filters: dict[str, LightFilter], matt: bool) -> dict[str, LightFilter]:
    """Pictures free of highlights are for our own filters, which promise to leave them alone."""
    return {name: f for name, f in filters.items() if not matt or name in ("none", *OURS)}


def _rows(trial: Trial, filters: dict[str, LightFilter], detect: DiscDetector) -> list[dict[str, object]]:
    truth = trial.recording
    target = restoration.Target(truth.diffuse)
    rows = []
    for name in (*filters, ORACLE):
        start = time.perf_counter()
        answer = apply(filters[name], truth.image) if name in filters else _oracle(trial)
        ms = 1e3 * (time.perf_counter() - start)
        masks = mask.evaluate(answer.mask, truth.highlight, answer.score)
        repaired = restoration.evaluate(answer.image, target, truth.highlight)
        found = detection.evaluate(detect(answer.image).points, trial.discs[trial.visible], trial.discs)
        rows.append(
            {
                "place": trial.place,
                "family": trial.place.split("-")[0],
                "light": trial.light,
                "frame": trial.frame,
                "matt": trial.matt,
                "filter": name,
                **vars(masks),
                **vars(repaired),
                "colourless_mse": _squared(answer, trial),
                "visible": found.visible,
                "detected": found.detected,
                "detections_true": found.true,
                "ms": ms,
            }
        )
    return rows


def _oracle(trial: Trial) -> Filtered:
    truth = trial.recording
    repaired = truth.image.copy()
    repaired[truth.highlight] = truth.diffuse[truth.highlight]
    return Filtered(repaired, truth.highlight, truth.highlight.astype("float32"))


def _squared(answer: Filtered, trial: Trial) -> float:
    """Mean squared error on white and grey objects; NaN without any."""
    at = trial.colourless
    if not at.any():
        return float("nan")
    error = answer.image[at].astype(float) - trial.recording.diffuse[at]
    return float((error**2).mean())


if __name__ == "__main__":
    sys.exit(main())
