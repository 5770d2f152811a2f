"""The summary fits a terminal of 100 columns and holds the numbers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas as pd
from rich.console import Console

from reports.terminal import summary


def printed(folder: Path, width: int = 100) -> str:
    console = Console(width=width, record=True, file=open("/dev/null", "w"))  # noqa: SIM115
    console.print(summary(folder))
    return console.export_text()


def test_rendered_summary(rendered_run: Path) -> None:
    text = printed(rendered_run)
    assert max(map(len, text.splitlines())) <= 100
    for word in (
        "all-negative mask",
        "do nothing",
        "seed",
        "seed_per_pixel",
        "RMSE, m",
        "did harm",
        "0 of 48",
    ):
        assert word in text
    assert "▼" in text


def test_more_filters_than_columns(rendered: Callable[..., Path]) -> None:
    names = ("none", *(f"filter_number_{k}" for k in range(7)))
    text = printed(rendered(filters=names, sun=(0.0,), strips=False, tracks=False))
    assert max(map(len, text.splitlines())) <= 100
    assert all(name in text for name in names[1:])


def test_dlr_summary_puts_the_dissertation_beside(dlr_run: Path) -> None:
    text = printed(dlr_run)
    assert max(map(len, text.splitlines())) <= 100
    for word in ("1.473", "0.828", "576 of 576", "170", "53.6", "0.978 / 0.960"):
        assert word in text
    for word in ("0.13", "0.19", "0.15", "0.168", "0.494", "60 % (332)", "Cramér"):
        assert word in text


def test_dlr_failure_is_shown(dlr_run: Path) -> None:
    path = dlr_run / "runs.parquet"
    runs = pd.read_parquet(path)
    runs.loc[3, "status"] = "failed: diverged at step 2550"
    runs.to_parquet(path)
    assert "diverged at step 2550" in printed(dlr_run)
