"""Sums and differences against tables small enough to work out by hand."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from reports.comparison import compare
from reports.frame_sums import addends, right_share
from reports.run import load


def rewrite(folder: Path, table: str, change: Callable[[pd.DataFrame], pd.DataFrame]) -> None:
    path = folder / f"{table}.parquet"
    change(pd.read_parquet(path)).to_parquet(path)


def test_recall_and_precision_are_sums_over_sums(rendered_run: Path) -> None:
    run = load(rendered_run)
    got = compare(run)
    for name in run.filters:
        rows = run.frames[run.frames["filter"] == name]
        dark = rows[rows["illumination"] == "sun0-bulb200"]
        hits, bright = rows["detections_true"].sum(), dark["detections_true"].sum()
        assert got.recall(name).value == pytest.approx(hits / rows["landmarks_visible"].sum())
        assert got.precision(name).value == pytest.approx(hits / rows["landmarks_detected"].sum())
        assert got.recall(name, "sun0-bulb200").value == pytest.approx(
            bright / dark["landmarks_visible"].sum()
        )


def test_rmse_change_is_the_mean_over_pairs(rendered_run: Path) -> None:
    run = load(rendered_run)
    wide = run.runs.pivot(index=["illumination", "seed"], columns="filter", values="rmse_m")
    change = compare(run).run_change("seed", "rmse_m")
    assert change.value == pytest.approx((wide["seed"] - wide["none"]).mean())
    assert change.units == 6 and change.unit == "illuminations and seeds"  # six of these, eight of those
    one_light = compare(run).run_change("seed", "rmse_m", run.runs["illumination"].iloc[0])
    assert one_light.units == 8 and one_light.unit == "seeds"


def test_a_pair_without_its_partner_does_not_count(rendered: Callable[..., Path]) -> None:
    run = load(rendered(failed=(("none", 2), ("seed", 5)), strips=False, tracks=False))
    wide = run.runs.pivot(index=["illumination", "seed"], columns="filter", values="rmse_m")
    change = compare(run).run_change("seed", "rmse_m")
    assert change.value == pytest.approx((wide["seed"] - wide["none"]).dropna().mean())
    assert change.units == 6


def test_baseline_changes_nothing_against_itself(rendered_run: Path) -> None:
    got = compare(load(rendered_run))
    for change in (
        got.recall_change("none"),
        got.run_change("none", "rmse_m"),
        got.psnr_in_mask_change("none"),
    ):
        assert change.value == change.low == change.high == 0.0


def test_interval_finds_the_effect_that_was_put_in(rendered_run: Path) -> None:
    got = compare(load(rendered_run))
    recall, rmse = got.recall_change("seed"), got.run_change("seed", "rmse_m")
    assert recall.low <= -0.18 <= recall.high
    assert rmse.low <= 0.20 <= rmse.high
    assert not got.recall_change("seed_per_pixel").excludes_zero


def test_share_of_right_pixels_against_masks() -> None:
    rng = np.random.default_rng(0)
    truth, mask = rng.random((40, 50)) < 0.1, rng.random((40, 50)) < 0.3
    iou = (truth & mask).sum() / (truth | mask).sum()
    frames = pd.DataFrame({"masked_share": [mask.mean()], "true_share": [truth.mean()], "iou": [iou]})
    assert right_share(frames)[0] == pytest.approx((truth == mask).mean())


def test_share_of_right_pixels_without_any_light() -> None:
    frames = pd.DataFrame({"masked_share": [0.25], "true_share": [0.0], "iou": [np.nan]})
    assert right_share(frames)[0] == 0.75


def test_a_perfect_picture_counts_as_no_error(rendered_run: Path) -> None:
    frames = load(rendered_run).frames.head(3).copy()
    frames["psnr_db"] = [np.inf, 20.0, np.nan]
    table = addends(frames)
    assert list(table["error"]) == pytest.approx([0.0, 0.01, 0.0])
    assert list(table["error_frames"]) == [1.0, 1.0, 0.0]


def test_frames_that_a_filter_lacks_are_left_out_and_counted(rendered: Callable[..., Path]) -> None:
    folder = rendered(sun=(0.0,), bulb=(800.0,), strips=False, tracks=False)
    rewrite(folder, "frames", lambda t: t[~((t["filter"] == "seed") & (t["frame"] < 4))])
    run = load(folder)
    got = compare(run)
    rows = run.frames[(run.frames["filter"] == "none") & (run.frames["frame"] >= 4)]
    assert got.frames.left_out == 4
    expected = rows["detections_true"].sum() / rows["landmarks_visible"].sum()
    assert got.recall("none").value == pytest.approx(expected)


def test_the_same_blocks_serve_each_filter_and_illumination(rendered_run: Path) -> None:
    sums = compare(load(rendered_run)).frames
    frames = [
        sums.of(f, w, "frames") for f in ("none", "seed") for w in ("sun0-bulb200", "sun97000-bulb3200")
    ]
    assert all((f == frames[0]).all() for f in frames)
    assert frames[0].sum() == 60
