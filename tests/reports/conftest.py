"""Small run folders with numbers like those of a real run, written the way the runner writes them."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from PIL import Image

from bench.schema import FRAME_COLUMNS, RUN_COLUMNS

SUN = (0.0, 1000.0, 97_000.0)
BULB = (200.0, 3200.0)
FILTERS = ("none", "seed", "seed_per_pixel")
VERSIONS = {"glarebench": "0.1.0", "numpy": "2.4.0", "scipy": "1.17.1"}


@dataclass
class Recipe:
    """What a synthetic rendered run looks like.

    ``recall`` and ``rmse`` are what each filter adds to the baseline.
    """

    frames: int = 60
    seeds: int = 8
    sun: tuple[float, ...] = SUN
    bulb: tuple[float, ...] = BULB
    filters: tuple[str, ...] = FILTERS
    recall: dict[str, float] = field(default_factory=lambda: {"seed": -0.18, "seed_per_pixel": 0.0})
    rmse: dict[str, float] = field(default_factory=lambda: {"seed": 0.20, "seed_per_pixel": 0.0})
    failed: tuple[tuple[str, int], ...] = ()
    strips: bool = True
    tracks: bool = True


def frame_rows(recipe: Recipe, rng: np.random.Generator) -> pd.DataFrame:
    rows: list[dict[str, Any]] = []
    visible = 6 + np.round(3 * np.sin(np.arange(recipe.frames) / 5)).astype(int)
    for sun in recipe.sun:
        for bulb in recipe.bulb:
            light = np.log10(1 + sun) / 5
            for k in range(recipe.frames):
                true = float(np.clip(0.01 + 0.05 * light + 0.01 * rng.normal(), 0.001, 0.4))
                base_recall = 0.9 - 0.35 * light
                for name in recipe.filters:
                    on = name != "none"
                    chance = float(np.clip(base_recall + recipe.recall.get(name, 0.0), 0, 1))
                    hits = int(rng.binomial(visible[k], chance))
                    iou = float(np.clip(0.10 + 0.2 * light + 0.05 * rng.normal(), 0.0, 1.0)) if on else 0.0
                    masked = 0.32 + 0.03 * rng.normal() if on else 0.0
                    rows.append(
                        dict(
                            scene="corridor",
                            illumination=f"sun{sun:g}-bulb{bulb:g}",
                            time="",
                            sun_lux=sun,
                            bulb_lm=bulb,
                            lamps="all",
                            exposure_ev=0.0,
                            frame=k,
                            filter=name,
                            engine="pyrender",
                            iou=iou,
                            f1=2 * iou / (1 + iou),
                            precision=iou if on else np.nan,
                            recall=0.6 if on else 0.0,
                            ber=0.45 if on else 0.5,
                            ap=0.2 if on else true,
                            psnr_db=27.0 - 4 * light + rng.normal() - 3 * on,
                            ssim=0.9,
                            psnr_in_mask_db=14.0 + rng.normal() + 2.0 * on,
                            masked_share=masked,
                            true_share=true,
                            landmarks_visible=int(visible[k]),
                            landmarks_detected=hits + k % 2,
                            detections_true=hits,
                            filter_ms=2.5 + 0.1 * rng.normal() if on else 0.01,
                            status="ok",
                        )
                    )
    return pd.DataFrame(rows)[list(FRAME_COLUMNS)].astype({k: v for k, v in FRAME_COLUMNS.items()})


def run_rows(recipe: Recipe, rng: np.random.Generator) -> pd.DataFrame:
    rows: list[dict[str, Any]] = []
    for sun in recipe.sun:
        for bulb in recipe.bulb:
            for seed in range(recipe.seeds):
                base = 0.4 + 0.1 * np.log10(1 + sun) / 5 + 0.05 * rng.normal()
                for name in recipe.filters:
                    failed = (name, seed) in recipe.failed
                    rmse = base + recipe.rmse.get(name, 0.0) + 0.02 * rng.normal() * (name != "none")
                    row = dict(
                        scene="corridor",
                        illumination=f"sun{sun:g}-bulb{bulb:g}",
                        time="",
                        sun_lux=sun,
                        bulb_lm=bulb,
                        lamps="all",
                        exposure_ev=0.0,
                        filter=name,
                        backend="ekf",
                        association="gated",
                        observation="cartesian",
                        seed=seed,
                        steps=recipe.frames,
                        rmse_m=rmse,
                        rmse_aligned_m=0.6 * rmse,
                        rmse_x_m=0.7 * rmse,
                        rmse_y_m=0.7 * rmse,
                        sq_err_x_max=rmse**2,
                        sq_err_y_max=1.5 * rmse**2,
                        landmarks_total=80,
                        landmarks_mapped=int(60 - 10 * rmse),
                        landmarks_duplicated=4,
                        landmark_rmse_m=0.3,
                        nees=4.2,
                        association_precision=0.98,
                        association_recall=0.95,
                        nav_success=float(np.clip(0.9 - 0.3 * rmse, 0, 1)),
                        nav_cost_ratio=1.05 + 0.1 * rmse,
                        rpe_m=0.02,
                        rpe_deg=0.1,
                        bound_m=np.nan,
                        step_ms=np.nan,
                        memory_mb=np.nan,
                        status="ok",
                    )
                    if failed:
                        measured = [
                            c
                            for c, kind in RUN_COLUMNS.items()
                            if kind == "float64" and c not in ("sun_lux", "bulb_lm", "exposure_ev")
                        ]
                        row |= {c: np.nan for c in measured}
                        row["status"] = "failed: the covariance lost positive definiteness at step 31"
                    rows.append(row)
    return pd.DataFrame(rows)[list(RUN_COLUMNS)].astype({k: v for k, v in RUN_COLUMNS.items()})


def stem(row: Any) -> str:
    parts = (row.scene, row.illumination, row.filter, row.backend, row.association, row.observation)
    return "--".join([*parts, f"s{row.seed}"])


def write_tum(path: Path, stamps: np.ndarray, poses: np.ndarray) -> None:
    half = poses[:, 2] / 2
    rows = np.column_stack([stamps, poses[:, :2], np.zeros((len(poses), 3)), np.sin(half), np.cos(half)])
    np.savetxt(path, rows, fmt="%.6f")


def ring(n: int, width: float = 17.5, height: float = 11.5, laps: float = 1.25) -> np.ndarray:
    """(n, 3): a drive round a rectangle, starting at the origin."""
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height], [0, 0]], dtype=float)
    along = np.r_[0, np.cumsum(np.hypot(*np.diff(corners, axis=0).T))]
    at = np.linspace(0, laps * along[-1], n) % along[-1]
    x, y = (np.interp(at, along, corners[:, i]) for i in (0, 1))
    return np.column_stack([x, y, np.zeros(n)])


def write_tracks(
    folder: Path, runs: pd.DataFrame, truth: np.ndarray, discs: np.ndarray, rng: np.random.Generator
) -> None:
    (folder / "trajectories").mkdir()
    stamps = np.arange(len(truth)) * 0.5
    for scene in runs["scene"].unique():
        write_tum(folder / "trajectories" / f"truth--{scene}.tum", stamps, truth)
    for row in runs.itertuples():
        if row.status != "ok":
            continue
        drift = np.cumsum(rng.normal(size=truth.shape) * row.rmse_m / np.sqrt(len(truth)), axis=0)
        write_tum(folder / "trajectories" / f"{stem(row)}.tum", stamps, truth + drift)
        estimate = discs + rng.normal(size=discs.shape) * row.rmse_m / 2
        estimate[row.landmarks_mapped :] = np.nan
        table = pd.DataFrame(
            {
                "id": np.arange(len(discs)),
                "x_true_m": discs[:, 0],
                "y_true_m": discs[:, 1],
                "x_est_m": estimate[:, 0],
                "y_est_m": estimate[:, 1],
            }
        )
        again = table.iloc[: row.landmarks_duplicated].assign(x_est_m=lambda t: t.x_est_m + 0.8)
        pd.concat([table, again]).to_csv(folder / "figures" / f"landmarks--{stem(row)}.csv", index=False)


def write_strips(folder: Path, recipe: Recipe) -> None:
    (folder / "figures" / "strips").mkdir()
    y, x = np.mgrid[0:48, 0:64]
    rows = []
    for name in recipe.filters:
        for i, rank in enumerate(("best", "median", "worst")):
            glare = np.exp(-((x - 16 - 16 * i) ** 2 + (y - 30) ** 2) / 90.0)
            diffuse = np.stack([90 + 2 * x, 60 + 3 * y, 80 + x + y], axis=-1).astype(float)
            raw = np.clip(diffuse + 200 * glare[..., None], 0, 255)
            predicted = (raw.min(axis=-1) > 140) if name != "none" else np.zeros((48, 64), bool)
            repaired = np.where(predicted[..., None], diffuse * 0.7, raw)
            pictures = {
                "raw": raw,
                "true_mask": (glare > 0.1) * 255.0,
                "predicted_mask": predicted * 255.0,
                "repaired": repaired,
                "true_diffuse": diffuse,
            }
            row = dict(
                scene="corridor",
                illumination=f"sun{recipe.sun[-1]:g}-bulb{recipe.bulb[-1]:g}",
                filter=name,
                frame=7 * i,
                rank=rank,
                iou=0.3 - 0.1 * i if name != "none" else 0.0,
                psnr_db=24.5 - i,
            )
            for kind, picture in pictures.items():
                row[kind] = f"{name}-{rank}-{kind}.png"
                Image.fromarray(picture.astype(np.uint8)).save(folder / "figures" / "strips" / str(row[kind]))
            rows.append(row)
    pd.DataFrame(rows).to_csv(folder / "figures" / "strips.csv", index=False)


def write_common(folder: Path, study: dict[str, Any]) -> None:
    (folder / "study.yaml").write_text(yaml.safe_dump(study, sort_keys=False), encoding="utf-8")
    provenance = {
        "study": study["name"],
        "command": f"python -m bench run --study {study['name']}",
        "started": "2026-03-01T12:00:00+00:00",
        "versions": VERSIONS,
        "commit": "0123456789abcdef",
        "dirty": False,
        "engine": "pyrender",
        "engine_notice": "",
        "machine": {"cores": 2, "system": "Linux"},
        "seed": 1,
        "seconds": {"render": 21.5, "slam": 30.25},
    }
    (folder / "provenance.json").write_text(json.dumps(provenance), encoding="utf-8")


def write_rendered(folder: Path, recipe: Recipe) -> Path:
    rng = np.random.default_rng(5)
    (folder / "figures").mkdir(parents=True)
    write_common(
        folder,
        {
            "name": "quick",
            "title": "A glossy corridor under sun and bulbs",
            "sequence": "rendered",
            "filters": list(recipe.filters),
            "illuminations": {"sun_lux": list(recipe.sun), "bulb_lm": list(recipe.bulb)},
            "seed": 1,
        },
    )
    frame_rows(recipe, rng).to_parquet(folder / "frames.parquet")
    runs = run_rows(recipe, rng)
    runs.to_parquet(folder / "runs.parquet")
    discs = np.repeat(ring(40, laps=0.98)[:, :2], 2, axis=0) + np.tile([[0.9, 0.5], [-0.9, -0.5]], (40, 1))
    if recipe.tracks:
        write_tracks(folder, runs, ring(recipe.frames), discs, rng)
    blocked = np.zeros((170, 230), dtype=bool)
    blocked[:5] = blocked[-5:] = blocked[:, :5] = blocked[:, -5:] = blocked[40:130, 40:190] = True
    np.savez(
        folder / "figures" / "occupancy--corridor.npz",
        blocked=blocked,
        origin=np.array([-2.75, -2.75]),
        resolution=np.array(0.1),
    )
    if recipe.strips:
        write_strips(folder, recipe)
    return folder


def write_dlr(folder: Path, steps: int = 300, landmarks: int = 576) -> Path:
    rng = np.random.default_rng(6)
    (folder / "figures").mkdir(parents=True)
    write_common(
        folder, {"name": "dlr", "title": "The DLR building log", "sequence": "dlr", "filters": ["none"]}
    )
    known = dict(
        rmse_m=1.473,
        rmse_aligned_m=0.828,
        landmarks_mapped=landmarks,
        landmarks_duplicated=0,
        association_precision=1.0,
        association_recall=1.0,
    )
    own = dict(
        rmse_m=4.1,
        rmse_aligned_m=2.2,
        landmarks_mapped=560,
        landmarks_duplicated=170,
        association_precision=0.978,
        association_recall=0.96,
    )
    rows = []
    for association, values in (("annotated", known), ("gated", own)):
        for observation, worse in (("cartesian", 1.0), ("range_bearing", 2.4)):
            row = dict(
                scene="dlr",
                illumination="as_recorded",
                time="",
                sun_lux=np.nan,
                bulb_lm=np.nan,
                lamps="",
                exposure_ev=np.nan,
                filter="none",
                backend="ekf",
                association=association,
                observation=observation,
                seed=0,
                steps=steps,
                rmse_x_m=1.0,
                rmse_y_m=1.08,
                sq_err_x_max=6.1,
                sq_err_y_max=8.4,
                landmarks_total=landmarks,
                landmark_rmse_m=1.2,
                nees=53.6,
                nav_success=np.nan,
                nav_cost_ratio=np.nan,
                rpe_m=0.02,
                rpe_deg=0.9,
                bound_m=0.962,
                step_ms=0.4,
                memory_mb=10.7,
                status="ok",
                **values,
            )
            row["rmse_m"] *= worse
            rows.append(row)
    runs = pd.DataFrame(rows)[list(RUN_COLUMNS)].astype({k: v for k, v in RUN_COLUMNS.items()})
    runs.to_parquet(folder / "runs.parquet")
    discs = np.column_stack([rng.uniform(-5, 55, landmarks), rng.uniform(-10, 35, landmarks)])
    write_tracks(folder, runs, ring(steps, 45, 30, 3.0), discs, rng)
    return folder


@pytest.fixture
def rendered(tmp_path: Path) -> Callable[..., Path]:
    """Writes a rendered run folder; keywords as in ``Recipe``."""
    return lambda **recipe: write_rendered(tmp_path / "run", Recipe(**recipe))


@pytest.fixture
def dlr_run(tmp_path: Path) -> Path:
    """A folder as the DLR study leaves it."""
    return write_dlr(tmp_path / "dlr")


@pytest.fixture(scope="session")
def rendered_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One default rendered run, shared by tests that only read it."""
    return write_rendered(tmp_path_factory.mktemp("rendered") / "run", Recipe())
