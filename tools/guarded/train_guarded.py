"""Make the weights of `guarded`: from pictures of `train`, numbers chosen on `validation`.

    python -m tools.guarded.train_guarded --cache DIR [--out vslam/filters/weights]

Needs PyTorch (2.13 was used) and onnx, which the filter itself does not. Pictures and trained stages are kept
in ``--cache``. The same seed, versions and kind of processor give the same files. Splits share no scene
(`scenes.splits`), but they do share the families: a room of `test` is new, its kind is not.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from collections.abc import Iterator
from dataclasses import asdict
from itertools import product
from pathlib import Path

import cv2
import torch

from bench.sequences.rendered import calibration
from tools.guarded.choose import Case, Choice, choose
from tools.guarded.export import onnx_bytes
from tools.guarded.floors import floors
from tools.guarded.network import GuardedNetwork
from tools.guarded.pictures import BAKE, FAMILIES, Amount, Pictures, split_pictures
from tools.guarded.samples import Variation
from tools.guarded.train import Stage, train
from tools.guarded.trials import study_of, trials
from vslam.detect import DetectorSettings, DiscDetector

SEED = 1
TRAIN = Amount(scenes=40, poses=6, lights=5)
VALIDATION_SCENES, VALIDATION_POSES = 4, 3
"""Of each family, of each scene; nine lights each."""

STAGES = (
    Stage(
        scenes=14,
        floors=300,
        epochs=8,
        rate=4e-3,
        light_weight=3.0,
        variation=Variation(scales=(0.75, 1.35), scaled=0.4, matt=0.1, permuted=0.3),
    ),
    Stage(
        scenes=40,
        floors=300,
        epochs=16,
        rate=3e-3,
        light_weight=1.5,
        variation=Variation(scales=(0.7, 1.4), scaled=0.5, matt=0.2, permuted=0.3),
    ),
    Stage(
        scenes=40,
        floors=300,
        epochs=10,
        rate=2e-3,
        light_weight=1.0,
        variation=Variation(scales=(0.8, 1.25), scaled=0.4, matt=0.2, permuted=0.2),
    ),
    Stage(
        scenes=40,
        floors=300,
        epochs=14,
        rate=2.5e-3,
        light_weight=1.0,
        variation=Variation(scales=(0.8, 1.25), scaled=0.4, matt=0.2, permuted=0.2),
    ),
)
"""First highlights, each weighed three times, so that the network does not settle for finding none; then,
on more scenes and more varied pictures, what is none; last, chances as they are."""


def main(arguments: list[str] | None = None) -> int:
    """Render, train, choose, write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cache", type=Path, required=True, help="keeps pictures and trained stages")
    parser.add_argument("--out", type=Path, default=Path("vslam/filters/weights"))
    chosen = parser.parse_args(arguments)
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    network = _trained(chosen.cache)
    weights = onnx_bytes(network)
    choice = choose(weights, list(_validation(chosen.cache)))
    chosen.out.mkdir(parents=True, exist_ok=True)
    (chosen.out / "guarded.onnx").write_bytes(weights)
    (chosen.out / "guarded.json").write_text(_provenance(choice), encoding="utf-8")
    return 0


def _trained(cache: Path) -> GuardedNetwork:
    torch.manual_seed(SEED)
    network = GuardedNetwork()
    pictures = _pictures(cache)
    for k, stage in enumerate(STAGES):
        recipe = hashlib.sha256(repr((SEED, TRAIN, STAGES[: k + 1])).encode()).hexdigest()
        kept = cache / f"stage{k}-{recipe[:12]}.pt"
        if kept.exists():
            network.load_state_dict(torch.load(kept))
            continue
        seen = pictures[: stage.scenes * len(FAMILIES)]
        seen += [floors("train", stage.floors, SEED)] if stage.floors else []
        train(network, seen, stage, SEED, _report)
        torch.save(network.state_dict(), kept)
    return network.eval()


def _pictures(cache: Path) -> list[Pictures]:
    scenes = []
    for name, pictures in split_pictures("train", TRAIN, SEED, cache):
        _say(name)
        scenes.append(pictures)
    return scenes


def _validation(cache: Path) -> Iterator[Case]:
    """Pictures as the default study takes them, of scenes that no weight was trained on."""
    for number, family in product(range(VALIDATION_SCENES), FAMILIES):
        study = study_of(family, "validation", number)
        settings = DetectorSettings(study.discs.min_radius_m, study.discs.max_radius_m)
        detect = DiscDetector(calibration(study), settings)
        _say(f"validation-{family}-{number}")
        for trial in trials(family, "validation", number, VALIDATION_POSES, cache, BAKE):
            yield Case(trial, detect)


def _report(epoch: int, loss: float) -> None:
    _say(f"epoch {epoch}: loss {loss:.4f}")


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _provenance(choice: Choice) -> str:
    """What was chosen, on what, and what came out there."""
    facts = {
        "made by": "python -m tools.guarded.train_guarded",
        "seed": SEED,
        "families": FAMILIES,
        "weights from": {
            "split": "train",
            "scenes of each family": TRAIN.scenes,
            "poses of each scene": TRAIN.poses,
            "lights of each pose": TRAIN.lights,
            "stages": [asdict(stage) for stage in STAGES],
        },
        "numbers from": {
            "split": "validation",
            "scenes of each family": VALIDATION_SCENES,
            "poses of each scene": VALIDATION_POSES,
        },
        "versions": {"torch": torch.__version__, "opencv": cv2.__version__},
        "chosen": choice.numbers,
        "on validation": choice.scores,
    }
    return json.dumps(facts, indent=1) + "\n"


if __name__ == "__main__":
    sys.exit(main())
