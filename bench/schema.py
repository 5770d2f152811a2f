"""The columns of the stored tables: the contract between a run and everything that reads it."""

from __future__ import annotations

_LIGHT = {
    "scene": "string",
    "illumination": "string",
    "time": "string",
    "sun_lux": "float64",
    "bulb_lm": "float64",
    "lamps": "string",
    "exposure_ev": "float64",
}
_VARIANT = {
    "filter": "string",
    "backend": "string",
    "association": "string",
    "observation": "string",
}
_MASK_SCORES = {
    "iou": "float64",
    "f1": "float64",
    "precision": "float64",
    "recall": "float64",
    "ber": "float64",
    "ap": "float64",
}

FRAME_COLUMNS: dict[str, str] = {
    **_LIGHT,
    "frame": "int64",
    "filter": "string",
    "engine": "string",
    **_MASK_SCORES,
    "psnr_db": "float64",
    "ssim": "float64",
    "psnr_in_mask_db": "float64",
    "masked_share": "float64",
    "true_share": "float64",
    "landmarks_visible": "int64",
    "landmarks_detected": "int64",
    "detections_true": "int64",
    "filter_ms": "float64",
    "status": "string",
}
"""One row per picture and filter. ``status`` is "ok" or "failed: reason"; a filter that fails on a picture
has no metrics there: NaN, no detections. ``time`` is a time of day, "09:00", empty where a study has none;
``lamps`` the name of the lamps' state, "all" where all burn steadily; ``exposure_ev`` stops
over what is metered."""

RUN_COLUMNS: dict[str, str] = {
    **_LIGHT,
    **_VARIANT,
    "seed": "int64",
    "steps": "int64",
    "rmse_m": "float64",
    "rmse_aligned_m": "float64",
    "rmse_x_m": "float64",
    "rmse_y_m": "float64",
    "sq_err_x_max": "float64",
    "sq_err_y_max": "float64",
    "landmarks_total": "int64",
    "landmarks_mapped": "int64",
    "landmarks_duplicated": "int64",
    "landmark_rmse_m": "float64",
    "nees": "float64",
    "rpe_m": "float64",
    "rpe_deg": "float64",
    "bound_m": "float64",
    "association_precision": "float64",
    "association_recall": "float64",
    "nav_success": "float64",
    "nav_cost_ratio": "float64",
    "step_ms": "float64",
    "memory_mb": "float64",
    "status": "string",
}
"""One row per SLAM run. ``status`` is "ok" or "failed: reason"; a metric without a meaning there is NaN. A
picture that the filter failed on gives SLAM no observation; where it failed on all, the run has failed.

``bound_m`` is the Cramér–Rao bound beside ``rmse_m`` (`bench.metrics.cramer_rao`); ``step_ms`` is measured,
and NaN where runs must give the same bytes."""

TIME_COLUMNS: dict[str, str] = {
    "filter": "string",
    "width": "int64",
    "height": "int64",
    "filter_ms": "float64",
    "status": "string",
}
"""``times.parquet`` of a study of filters: one row per filter and size of picture, measured one by one after
all else. Its ``frames.parquet`` holds the pictures with all their light; beside it, with the same columns,
``highlight_free.parquet`` those without any specular light, ``neutral.parquet`` the scores over the pixels of
white and grey objects alone, and ``oracle.parquet`` what the exact mask and repair would give."""

PICTURE_COLUMNS: dict[str, str] = {
    "picture": "string",
    "filter": "string",
    "width": "int64",
    "height": "int64",
    "psnr_db": "float64",
    "psnr_in_mask_db": "float64",
    "ssim": "float64",
    "ssim_volume": "float64",
    "lmse": "float64",
    "delta_e": "float64",
    "filter_ms": "float64",
    "status": "string",
}
"""``pictures.parquet`` of a study of picture pairs: one row per picture and filter."""

MASK_COLUMNS: dict[str, str] = {
    "picture": "string",
    "filter": "string",
    "truth": "string",
    **_MASK_SCORES,
    "masked_share": "float64",
    "true_share": "float64",
}
"""``masks.parquet`` of such a study: one row per picture, filter and true mask ("residue > 16")."""

DRIVE_COLUMNS: dict[str, str] = {
    **_LIGHT,
    **_VARIANT,
    "task": "string",
    "episode": "int64",
    "outcome": "string",
    "success": "int64",
    "collision": "int64",
    "spl": "float64",
    "path_m": "float64",
    "optimum_m": "float64",
    "seconds": "float64",
    "replans": "int64",
    "pictures": "int64",
    "goal_error_m": "float64",
    "rmse_m": "float64",
    "error_max_m": "float64",
    "sigma_end_m": "float64",
    "explored": "float64",
    "landmarks_mapped": "int64",
    "landmarks_visible": "int64",
    "landmarks_detected": "int64",
    "detections_true": "int64",
    "true_share": "float64",
}
"""One row per drive in closed loop. ``outcome`` is "arrived" or "explored" for a success, otherwise "lost",
"collision", "stuck", "timeout" or "failed: reason". ``goal_error_m`` is the largest true distance to a place
at which the robot believed to be; ``sigma_end_m`` the root of the position covariance's trace at the end."""
