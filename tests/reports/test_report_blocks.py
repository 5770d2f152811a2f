"""Blocks of frames: where they lie and how long they have to be."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reports import blocks
from reports import statistics as s


def correlated(rng: np.random.Generator, n: int, rho: float) -> np.ndarray:
    """A stationary AR(1) series with unit variance."""
    x = np.empty(n)
    x[0] = rng.normal()
    for k in range(1, n):
        x[k] = rho * x[k - 1] + np.sqrt(1 - rho**2) * rng.normal()
    return x


@given(st.integers(1, 200), st.integers(1, 30))
def test_blocks_are_contiguous_even_and_cover_each_frame_once(frames: int, length: int) -> None:
    table = pd.DataFrame({"scene": "a", "frame": np.arange(frames)})
    got = blocks.assign(table, length)
    assert list(got["frame"]) == list(range(frames))
    assert (np.diff(got["block"]) >= 0).all() and (np.diff(got["block"]) <= 1).all()
    sizes = got["block"].value_counts()
    assert sizes.max() - sizes.min() <= 1
    assert sizes.min() >= min(length, frames)


def test_no_block_crosses_scenes() -> None:
    table = pd.DataFrame({"scene": ["a"] * 10 + ["b"] * 10, "frame": [*range(10), *range(10)]})
    got = blocks.assign(table, 4)
    assert (got.groupby("block")["scene"].nunique() == 1).all()
    assert got["block"].nunique() == 4


def test_independent_frames_need_no_blocks_and_correlated_ones_do() -> None:
    rng = np.random.default_rng(7)
    white = [blocks.optimal_length(rng.normal(size=400)) for _ in range(30)]
    slow = [blocks.optimal_length(correlated(rng, 400, 0.9)) for _ in range(30)]
    assert np.median(white) <= 3
    assert np.median(slow) >= 10


def test_optimal_length_of_an_autoregressive_series() -> None:
    """For AR(1), Σ|k|R(k) = 2ρ/(1−ρ)², spectrum (1+ρ)/(1−ρ): b = (6ρ²/(1−ρ²)²)^⅓ n^⅓, here 20.8."""
    rho, n = 0.5, 5000
    expected = (6 * rho**2 / (1 - rho**2) ** 2) ** (1 / 3) * n ** (1 / 3)
    rng = np.random.default_rng(8)
    got = np.mean([blocks.optimal_length(correlated(rng, n, rho)) for _ in range(20)])
    assert got == pytest.approx(expected, rel=0.2)


def test_constant_or_short_series() -> None:
    assert blocks.optimal_length(np.ones(50)) == 1
    assert blocks.optimal_length(np.arange(5.0)) == 1


def test_blocks_keep_the_promise_that_single_frames_break() -> None:
    """Mean of a correlated series: by frames its interval is far too narrow, by blocks it is not."""
    rng = np.random.default_rng(9)
    held = {"frames": 0, "blocks": 0}
    for _ in range(60):
        x = correlated(rng, 240, 0.8)
        table = pd.DataFrame({"scene": "a", "frame": np.arange(240)})
        length = blocks.optimal_length(x)
        block = blocks.assign(table, length)["block"].to_numpy()
        sums = np.stack([np.bincount(block, x), np.bincount(block).astype(float)])
        for name, values in (("blocks", sums), ("frames", np.stack([x, np.ones(240)]))):
            got = s.estimate(s.ratio, values, name)
            held[name] += got.low <= 0.0 <= got.high
    assert held["frames"] < 40
    assert held["blocks"] >= 50
