"""Counting drives: intervals against SciPy's, pairs by hand."""

from __future__ import annotations

import pandas as pd
import pytest
from scipy.stats import binomtest

from reports.closed_loop import Drives, discordant, outcomes, wilson


@pytest.mark.parametrize(("successes", "trials"), [(0, 6), (5, 6), (6, 6), (17, 40)])
def test_wilson_is_scipys(successes: int, trials: int) -> None:
    ours, theirs = wilson(successes, trials), binomtest(successes, trials).proportion_ci(method="wilson")
    assert (ours.low, ours.high) == pytest.approx((theirs.low, theirs.high), abs=1e-12)
    assert ours.value == successes / trials


def test_no_drive_has_no_share() -> None:
    assert not wilson(0, 0).has_interval


def test_pairs_by_hand() -> None:
    rows = [
        ("none", 0, 1, "arrived"),
        ("none", 1, 1, "arrived"),
        ("none", 2, 0, "lost"),
        ("seed", 0, 0, "collision"),
        ("seed", 1, 1, "arrived"),
        ("seed", 2, 0, "lost"),
    ]
    table = pd.DataFrame(rows, columns=["filter", "episode", "success", "outcome"])
    own = Drives(table.assign(illumination="dim", task="goal"), ("none", "seed"), ())
    assert discordant(own, "seed", "goal") == (0, 1, 1.0)  # one discordant pair: p = 2 · ½
    assert outcomes(own.of("goal", "seed")) == "1 collision, 1 lost"
    assert outcomes(own.of("goal", "seed", "bright")) == "none"
