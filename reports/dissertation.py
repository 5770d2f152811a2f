"""The dissertation's numbers, to stand beside ours."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan


@dataclass(frozen=True)
class Published:
    """One line of the dissertation's results; NaN where it gives no number.

    Attributes
    ----------
    label, source : str
    rmse_m : float
        Position RMSE without alignment (3-39), metres.
    sq_err_x_max, sq_err_y_max : float
        Largest squared error of an axis (3-40, 3-41), m².
    landmarks : str
        As printed there.
    """

    label: str
    source: str
    rmse_m: float
    sq_err_x_max: float = nan
    sq_err_y_max: float = nan
    landmarks: str = ""


LANDMARK_SHARE = 0.60

PROPOSED = Published(
    "dissertation, proposed",
    "its Table 4-2, figures 4-1C, 4-3A and 4-3B; simulated sensor",
    0.13,
    0.168,
    0.494,
    "60 % (332)",
)
CKF = Published("CKF-SLAM, Li 2017", "quoted in its Table 4-2; other data, other conditions", 0.19)
SRCKF = Published("SRCKF-SLAM, Li 2017", "quoted in its Table 4-2; other data, other conditions", 0.15)
ROWS = (PROPOSED, CKF, SRCKF)

BOUND_M = 0.962
"""Posterior Cramér–Rao bound on the position RMSE of any online estimator on this log, metres.

Computed on a reduced public copy of it (14,237 observations of 560 landmarks).
"""

DIFFERENCE = (
    "The dissertation's 0.13 m cannot be compared with a replay of this log: no online estimator can reach "
    "it here (the posterior Cramér–Rao bound is about 0.96 m, computed on a "
    "reduced copy of the log), whereas the dissertation simulated a virtual "
    "sensor of 12 m and ±75° on this map, where the real detector reports nothing beyond 4.4 m, and let "
    "ground truth update the odometry."
)
