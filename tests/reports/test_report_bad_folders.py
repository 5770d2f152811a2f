"""A missing or damaged file is one line that names it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from reports.errors import ReportError
from reports.html import build
from reports.run import load

Make = Callable[..., Path]
STEM = "corridor--sun0-bulb800--none--ekf--gated--cartesian--s0"


@pytest.fixture
def small(rendered: Make) -> Path:
    return rendered(sun=(0.0,), bulb=(800.0,), frames=12, seeds=2)


def fails(folder: Path, *words: str) -> None:
    with pytest.raises(ReportError) as caught:
        build(folder)
    message = str(caught.value)
    assert "\n" not in message
    for word in words:
        assert word in message
    assert not (folder / "report.html").is_file()


def test_no_folder(tmp_path: Path) -> None:
    fails(tmp_path / "nowhere", "no run folder", "nowhere")


@pytest.mark.parametrize(
    "name",
    [
        "study.yaml",
        "provenance.json",
        "frames.parquet",
        "runs.parquet",
        "trajectories/truth--corridor.tum",
        f"trajectories/{STEM}.tum",
        f"figures/landmarks--{STEM}.csv",
        "figures/strips/seed-best-raw.png",
    ],
)
def test_missing_file(small: Path, name: str) -> None:
    (small / name).unlink()
    fails(small, Path(name).name, "missing", "run the study again")


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("study.yaml", "a: [1"),
        ("study.yaml", "just words"),
        ("provenance.json", "{"),
        ("provenance.json", "[]"),
        ("frames.parquet", "PAR1 nothing"),
        ("runs.parquet", ""),
        (f"trajectories/{STEM}.tum", "0 1 2\n"),
        (f"trajectories/{STEM}.tum", "0 nan 0 0 0 0 0 1\n"),
        (f"trajectories/{STEM}.tum", ""),
        (f"figures/landmarks--{STEM}.csv", "id,x_true_m\n1,2\n"),
        ("figures/strips.csv", "scene,frame\n"),
        ("figures/strips/seed-best-raw.png", "not a picture"),
        ("figures/strips/seed-best-raw.png", "\x89PNG\r\n\x1a\n and no more"),
        ("figures/occupancy--corridor.npz", "not a grid"),
    ],
)
def test_damaged_file(small: Path, name: str, content: str) -> None:
    (small / name).write_bytes(content.encode("latin-1"))
    fails(small, Path(name).name)


def test_bad_trajectory_row_is_named(small: Path) -> None:
    path = small / "trajectories" / f"{STEM}.tum"
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[4] = "0 1 2 three 0 0 0 1"
    path.write_text("\n".join(lines), encoding="utf-8")
    fails(small, f"{STEM}.tum, line 5")


def test_missing_columns_are_named(small: Path) -> None:
    path = small / "runs.parquet"
    pd.read_parquet(path).drop(columns=["rmse_m", "nees"]).to_parquet(path)
    fails(small, "runs.parquet", "lacks the columns rmse_m, nees")


def test_words_where_numbers_belong(small: Path) -> None:
    path = small / "frames.parquet"
    frames = pd.read_parquet(path)
    frames["iou"] = "high"
    frames.to_parquet(path)
    fails(small, "frames.parquet", "column iou")


def test_run_without_baseline(small: Path) -> None:
    for name in ("frames", "runs"):
        path = small / f"{name}.parquet"
        table = pd.read_parquet(path)
        table[table["filter"] != "none"].to_parquet(path)
    fails(small, "'none'", "study's filters")


def test_empty_frame_table(small: Path) -> None:
    path = small / "frames.parquet"
    pd.read_parquet(path).head(0).to_parquet(path)
    fails(small, "frames.parquet", "no rows")


def test_page_that_cannot_be_written(small: Path) -> None:
    (small / "report.html").mkdir()
    fails(small, "cannot write", "report.html")


def test_optional_parts_may_be_absent(small: Path) -> None:
    (small / "figures" / "occupancy--corridor.npz").unlink()
    (small / "figures" / "strips.csv").unlink()
    assert build(small).is_file()


def test_dlr_needs_no_frames(dlr_run: Path) -> None:
    assert load(dlr_run).frames.empty
