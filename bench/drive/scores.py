"""What a drive is worth.

SPL, success weighted by path length (Anderson et al. 2018, *On evaluation of embodied navigation agents*):
S · ℓ / max(p, ℓ), with success S, length p of the way that was truly driven and ℓ of the shortest one.
"""

from __future__ import annotations

import math

import numpy as np

from bench.drive.closed_loop import Drive
from bench.drive.episode import Episode
from bench.illumination_grid import Illumination
from bench.kinds.drive import ClosedLoopStudy
from bench.schema import DRIVE_COLUMNS

SUCCESSES = ("arrived", "explored")


def spl(success: bool, driven_m: float, optimum_m: float) -> float:
    """Success weighted by path length, 0…1; NaN without a shortest way."""
    if math.isnan(optimum_m):
        return math.nan
    return float(success) * optimum_m / max(driven_m, optimum_m) if optimum_m > 0 else float(success)


def row(
    study: ClosedLoopStudy, scene: str, illumination: Illumination, label: str, episode: Episode, drive: Drive
) -> dict[str, object]:
    """The row of a drive in the table of drives."""
    moments = drive.moments
    errors = np.array([np.hypot(*(m.true - m.believed)[:2]) for m in moments])
    success = drive.outcome in SUCCESSES
    values = {
        "scene": scene,
        **illumination.labels(),
        "filter": label,
        "backend": study.slam.backend,
        "association": study.slam.association,
        "observation": study.slam.observation,
        "task": episode.task,
        "episode": episode.number,
        "outcome": drive.outcome,
        "success": int(success),
        "collision": int(drive.outcome == "collision"),
        "spl": spl(success, drive.driven_m, episode.optimum_m),
        "path_m": drive.driven_m,
        "optimum_m": episode.optimum_m,
        "seconds": drive.seconds,
        "replans": drive.replans,
        "pictures": len(moments),
        "goal_error_m": max(drive.goal_errors_m, default=math.nan),
        "rmse_m": float(np.sqrt((errors**2).mean())) if len(errors) else math.nan,
        "error_max_m": float(errors.max()) if len(errors) else math.nan,
        "sigma_end_m": moments[-1].sigma_m if moments else math.nan,
        "explored": moments[-1].explored if moments else 0.0,
        "landmarks_mapped": drive.landmarks_mapped,
        "landmarks_visible": sum(m.visible for m in moments),
        "landmarks_detected": sum(m.detected for m in moments),
        "detections_true": sum(m.detections_true for m in moments),
        "true_share": float(np.mean([m.true_share for m in moments])) if moments else math.nan,
    }
    return {name: values[name] for name in DRIVE_COLUMNS}
