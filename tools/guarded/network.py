"""The network of `guarded` in PyTorch: a small encoder and decoder with skips (Ronneberger 2015, "U-Net").

Half of the work is done at half resolution, in few channels; the last step gives each half-resolution cell
its 2 × 2 pixels (sub-pixel convolution, Shi 2016), so the answer has the picture's own resolution.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from vslam.filters.stages.light_network import LEAST_SPREAD

WIDTHS = (10, 20, 40, 64, 96)
"""Channels at 1/2 … 1/32 of the resolution."""

LAST = 14
"""Channels from which the answer is read."""

OUTPUTS = 4
"""The mask's logit, and for each channel the logit of the share of the recorded code that light added."""


def _conv(inputs: int, outputs: int, stride: int = 1, size: int = 3) -> nn.Sequential:
    """Convolution, batch normalisation (Ioffe & Szegedy 2015; folded in afterwards), ReLU."""
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, size, stride, 1, bias=False), nn.BatchNorm2d(outputs), nn.ReLU()
    )


class _Residual(nn.Module):
    """Two convolutions whose answer is added to what they were given (He 2016)."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.first = _conv(channels, channels)
        self.second = nn.Sequential(
            nn.Conv2d(channels, channels, 3, 1, 1, bias=False), nn.BatchNorm2d(channels)
        )

    def forward(self, x: Tensor) -> Tensor:
        return functional.relu(x + self.second(self.first(x)))


class GuardedNetwork(nn.Module):
    """From (N, 3, H, W) standardised codes to (N, 16, H/2, W/2) logits: four of each pixel of a cell.

    Most weights lie where a cell sees much of the room and costs little: at 1/8 of the resolution and below.
    """

    def __init__(self, widths: tuple[int, ...] = WIDTHS) -> None:
        super().__init__()
        a, b, c, d, e = widths
        self.enter = _conv(3, a, 2, 4)
        self.quarter = _conv(a, b, 2)
        self.eighth = nn.Sequential(_conv(b, c, 2), _Residual(c))
        self.sixteenth = nn.Sequential(_conv(c, d, 2), _Residual(d))
        self.bottom = nn.Sequential(_conv(d, e, 2), _Residual(e), _Residual(e))
        self.to_sixteenth = nn.Conv2d(e, d, 1)
        self.at_sixteenth = nn.Sequential(_conv(2 * d, d), _conv(d, d))
        self.to_eighth, self.at_eighth = nn.Conv2d(d, c // 2, 1), _conv(c // 2 + c, c)
        self.to_quarter, self.at_quarter = nn.Conv2d(c, b // 2, 1), _conv(b // 2 + b, b)
        self.to_half, self.at_half = nn.Conv2d(b, a, 1), _conv(2 * a, LAST)
        self.logits = nn.Conv2d(LAST, 4 * OUTPUTS, 1)

    def forward(self, picture: Tensor) -> Tensor:
        """Logits by cell, as the shipped file computes them."""
        half = self.enter(picture)
        quarter = self.quarter(half)
        eighth = self.eighth(quarter)
        sixteenth = self.sixteenth(eighth)
        x = self.bottom(sixteenth)
        x = self.at_sixteenth(torch.cat([_twice(self.to_sixteenth(x)), sixteenth], 1))
        x = self.at_eighth(torch.cat([_twice(self.to_eighth(x)), eighth], 1))
        x = self.at_quarter(torch.cat([_twice(self.to_quarter(x)), quarter], 1))
        x = self.at_half(torch.cat([_twice(self.to_half(x)), half], 1))
        return self.logits(x)


def standardised(codes: Tensor) -> Tensor:
    """Less the picture's mean, over its standard deviation: exposure and contrast then matter little."""
    mean, spread = codes.mean((1, 2, 3), keepdim=True), codes.std((1, 2, 3), keepdim=True, correction=0)
    return (codes - mean) / (spread + LEAST_SPREAD)


def _twice(x: Tensor) -> Tensor:
    return functional.interpolate(x, scale_factor=2.0, mode="nearest")
