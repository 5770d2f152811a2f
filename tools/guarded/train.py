"""Train the network of `guarded`: weights from the training split alone, deterministic on one thread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from tools.guarded.network import OUTPUTS, GuardedNetwork, standardised
from tools.guarded.pictures import Pictures
from tools.guarded.samples import Sample, Variation, samples
from vslam.filters.stages.light_guard import SHARE_BIAS

TAU = 16
"""Grey levels that specular light must add for a pixel to count as highlight (the suite's default)."""

BATCH = 4
DISC_WEIGHT = 3.0
"""How much more a wrong call on a landmark's paint costs than elsewhere."""

PALE, PALE_WEIGHT = 0.6, 2.0
"""A colour whose least channel has this code looks like light: as paint, a wrong call on it costs so much."""

UNSURE = 6
"""Grey levels about τ where a pixel is neither clearly highlight nor clearly none: it counts half."""

EDGE_WEIGHT, DISC_EDGE_WEIGHT = 2.0, 4.0
"""What a false edge costs beside a false level, and how much more it does on a landmark: a disc is found by
its edge."""


@dataclass(frozen=True)
class Stage:
    """A part of the training.

    Attributes
    ----------
    scenes : int
        Of each family.
    floors : int
        Plain floors besides (`tools.guarded.floors`).
    epochs : int
        How often each picture is seen.
    rate : float
        Highest learning rate.
    light_weight : float
        How much more a missed highlight costs than a false one; one pixel in twenty is highlight.
    variation : Variation
    """

    scenes: int
    floors: int
    epochs: int
    rate: float
    light_weight: float
    variation: Variation


def train(
    network: GuardedNetwork,
    pictures: list[Pictures],
    stage: Stage,
    seed: int,
    report: Callable[[int, float], None],
) -> None:
    """Fit the network by AdamW with one cycle of learning rates (Smith & Topin 2018)."""
    epochs, rate = stage.epochs, stage.rate
    network.train()
    steps = sum(len(scene.image) for scene in pictures) // BATCH
    optimiser = torch.optim.AdamW(network.parameters(), rate, weight_decay=1e-4)
    schedule = torch.optim.lr_scheduler.OneCycleLR(
        optimiser, rate, epochs=epochs, steps_per_epoch=steps, pct_start=0.15
    )
    for epoch in range(epochs):
        stream, total = samples(pictures, np.random.default_rng([seed, epoch]), stage.variation), 0.0
        for _ in range(steps):
            loss = _loss(network, stage.light_weight, *tensors(list(islice(stream, BATCH))))
            optimiser.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
            optimiser.step()
            schedule.step()
            total += float(loss.detach())
        report(epoch, total / steps)
    network.eval()


def tensors(batch: list[Sample]) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Image and diffuse 0…1, grey levels that light added (largest channel), disc."""
    image, full, diffuse = (
        torch.from_numpy(np.stack([s[k] for s in batch])).permute(0, 3, 1, 2).float() for k in range(3)
    )
    disc = torch.from_numpy(np.stack([s[3] for s in batch]))[:, None].float()
    return image.contiguous() / 255, diffuse / 255, (full - diffuse).amax(1, keepdim=True), disc


def _loss(
    network: GuardedNetwork, light_weight: float, image: Tensor, diffuse: Tensor, added: Tensor, disc: Tensor
) -> Tensor:
    """Cross-entropy and overlap of the mask, error of the repair's levels and edges, as the metrics weigh."""
    with torch.autocast("cpu", dtype=torch.bfloat16):
        answer = network(standardised(image))
    logit, share = functional.pixel_shuffle(answer.float(), 2).split([1, OUTPUTS - 1], 1)
    true = (added >= TAU).float()
    paint = 1 + (DISC_WEIGHT - 1) * disc
    paint = torch.where(
        (diffuse.amin(1, keepdim=True) > PALE) & (added < TAU), paint.clamp(min=PALE_WEIGHT), paint
    )
    weight = (1 + (light_weight - 1) * true) * paint
    weight = weight * torch.where((added - TAU + 0.5).abs() < UNSURE, 0.5, 1.0)
    entropy = functional.binary_cross_entropy_with_logits(logit, true, weight)
    repaired = image * torch.sigmoid(-share - SHARE_BIAS)
    edges = EDGE_WEIGHT * _edge_loss(repaired - diffuse, disc)
    return entropy + _overlap_loss(logit, true) + _repair_loss(repaired, diffuse, true, paint) + edges


def _overlap_loss(logit: Tensor, true: Tensor) -> Tensor:
    """1 − soft IoU of each picture that has a highlight worth the name (Rahman & Wang 2016)."""
    chance = torch.sigmoid(logit)
    common = (chance * true).sum((1, 2, 3))
    either = (chance + true).sum((1, 2, 3)) - common
    lit = (true.sum((1, 2, 3)) >= 20).float()
    return (lit * (1 - common / (either + 1))).sum() / (lit.sum() + 1e-6)


def _repair_loss(repaired: Tensor, diffuse: Tensor, true: Tensor, paint: Tensor) -> Tensor:
    """Root of each picture's mean squared error inside the mask, and the same outside: neither drowns."""
    squared = (repaired - diffuse).square().mean(1, keepdim=True)
    size = true.sum((1, 2, 3))
    inside = (squared * true).sum((1, 2, 3)) / (size + 20)
    outside = (squared * paint * (1 - true)).sum((1, 2, 3)) / (true[0].numel() - size).clamp(min=1)
    return (inside + 1e-5).sqrt().mean() + (outside + 1e-5).sqrt().mean()


def _edge_loss(error: Tensor, disc: Tensor) -> Tensor:
    """Mean absolute difference of neighbours' errors: edges that the repair left, dulled or made."""
    near = functional.max_pool2d(disc, 5, 1, 2)
    weight = 1 + (DISC_EDGE_WEIGHT - 1) * near
    down = (error[:, :, 1:] - error[:, :, :-1]).abs() * weight[:, :, 1:]
    right = (error[..., 1:] - error[..., :-1]).abs() * weight[..., 1:]
    return down.mean() + right.mean()
