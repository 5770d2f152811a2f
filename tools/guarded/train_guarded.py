"""Make the weights of `guarded`: from pictures of `train`, numbers chosen on `validation`.

    python -m tools.guarded.train_guarded --cache DIR [--out vslam/filters/weights]

Needs PyTorch (2.13 was used) and onnx, which the filter itself does not. Pictures and trained stages are kept
in ``--cache``. The same seed, versions and kind of processor give the same files. Splits share no scene
(`scenes.splits`), but they do share the families: a room of `test` is new, its kind is not.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path

import cv2
import torch

from tools.guarded.choose import Choice, choose
from tools.guarded.export import onnx_bytes
from tools.guarded.floors import floors
from tools.guarded.network import GuardedNetwork
from tools.guarded.pictures import FAMILIES, Amount, Pictures, split_pictures
from tools.guarded.samples import Variation, halved
from tools.guarded.train import Stage, train

SEED = 1
TRAIN, VALIDATION = Amount(scenes=4, poses=10, lights=5), Amount(scenes=2, poses=6, lights=5)
STAGES = (
    Stage(scenes=3, floors=0, epochs=30, rate=4e-3, light_weight=4.0, variation=Variation()),
    Stage(
        scenes=4,
        floors=150,
        epochs=16,
        rate=3e-3,
        light_weight=2.0,
        variation=Variation(scales=(0.65, 1.5), scaled=0.6, matt=0.25, permuted=0.5),
    ),
)
"""First highlights, each weighed four times, so that the network does not settle for finding none; then,
on more scenes and more varied pictures, what is none."""


def main(arguments: list[str] | None = None) -> int:
    """Render, train, choose, write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cache", type=Path, required=True, help="keeps pictures and trained stages")
    parser.add_argument("--out", type=Path, default=Path("vslam/filters/weights"))
    parser.add_argument("--weights", type=Path, help="trained before: choose and write alone")
    chosen = parser.parse_args(arguments)
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    validation = [halved(scene) for scene in _pictures("validation", VALIDATION, chosen.cache)]
    network = _trained(chosen.cache, chosen.weights)
    weights = onnx_bytes(network)
    choice = choose(weights, validation)
    chosen.out.mkdir(parents=True, exist_ok=True)
    (chosen.out / "guarded.onnx").write_bytes(weights)
    (chosen.out / "guarded.json").write_text(_provenance(choice), encoding="utf-8")
    return 0


def _trained(cache: Path, weights: Path | None) -> GuardedNetwork:
    torch.manual_seed(SEED)
    network = GuardedNetwork()
    if weights is not None:
        network.load_state_dict(torch.load(weights))
        return network.eval()
    pictures = [halved(scene) for scene in _pictures("train", TRAIN, cache)]
    for k, stage in enumerate(STAGES):
        kept = cache / f"stage{k}.pt"
        if kept.exists():
            network.load_state_dict(torch.load(kept))
            continue
        seen = pictures[: stage.scenes * len(FAMILIES)]
        seen += [floors("train", stage.floors, SEED)] if stage.floors else []
        train(network, seen, stage, SEED, _report)
        torch.save(network.state_dict(), kept)
    return network.eval()


def _pictures(split: str, amount: Amount, cache: Path) -> list[Pictures]:
    scenes = []
    for name, pictures in split_pictures(split, amount, SEED, cache):
        _say(name)
        scenes.append(pictures)
    return scenes


def _report(epoch: int, loss: float) -> None:
    _say(f"epoch {epoch}: loss {loss:.4f}")


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _provenance(choice: Choice) -> str:
    """What was chosen, on what, and what came out there."""

    def counts(amount: Amount) -> dict[str, object]:
        pictures = len(FAMILIES) * amount.scenes * amount.poses * amount.lights
        return {"scenes of each family": amount.scenes, "pictures": pictures}

    facts = {
        "made by": "python -m tools.guarded.train_guarded",
        "seed": SEED,
        "families": FAMILIES,
        "weights from": {
            "split": "train",
            **counts(TRAIN),
            "stages": [asdict(stage) for stage in STAGES],
        },
        "numbers from": {"split": "validation", **counts(VALIDATION)},
        "versions": {"torch": torch.__version__, "opencv": cv2.__version__},
        "chosen": choice.numbers,
        "on validation": choice.scores,
    }
    return json.dumps(facts, indent=1) + "\n"


if __name__ == "__main__":
    sys.exit(main())
