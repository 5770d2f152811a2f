"""Which frames a report shows."""

from __future__ import annotations

import numpy as np

from bench.strips import choose


def _row(filter: str, frame: int, psnr: float, scene: str = "hall") -> dict[str, object]:
    return {"scene": scene, "illumination": "night", "filter": filter, "frame": frame, "psnr_db": psnr}


def test_best_median_and_worst_are_ranked_by_the_change_against_doing_nothing() -> None:
    untouched = [20.0, 40.0, 30.0, 25.0, 10.0]
    change = [-3.0, -1.0, 2.0, 0.0, -9.0]
    rows = [_row("none", k, p) for k, p in enumerate(untouched)]
    rows += [_row("f", k, p + c) for k, (p, c) in enumerate(zip(untouched, change, strict=True))]
    assert [(c.rank, c.row["frame"]) for c in choose(rows)] == [("best", 2), ("median", 1), ("worst", 4)]


def test_a_frame_without_a_finite_change_is_not_shown() -> None:
    rows = [_row("none", 0, np.inf), _row("none", 1, 20.0), _row("f", 0, 5.0), _row("f", 1, 21.0)]
    assert {c.row["frame"] for c in choose(rows)} == {1}


def test_a_picture_is_held_against_doing_nothing_in_its_own_scene() -> None:
    rows = [_row("none", 0, 10.0, "dim"), _row("none", 0, 40.0, "bright")]
    rows += [_row("f", 0, 12.0, "dim"), _row("f", 0, 39.0, "bright")]
    best, _, worst = choose(rows)
    assert (best.row["scene"], worst.row["scene"]) == ("dim", "bright")


def test_doing_nothing_is_not_shown() -> None:
    assert choose([_row("none", 0, 20.0)]) == []
