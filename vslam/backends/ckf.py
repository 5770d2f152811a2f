"""Cubature Kalman filter SLAM, the first of the two that Li et al. 2017 compare.

Source: Arasaratnam & Haykin 2009, "Cubature Kalman filters", eqs. 28 … 48. The rule's points lie √n standard
deviations out for n dimensions, so that over a whole map of 576 landmarks they would probe the measurement 34
standard deviations away; over pose and seen landmarks (`sigma_points`) n stays small.
"""

from __future__ import annotations

from vslam.backends.parts.sigma_point_filter import SigmaPointFilter
from vslam.backends.parts.sigma_points import cubature
from vslam.slam_backend import backends


@backends.register("ckf")
class Ckf(SigmaPointFilter):
    """The cubature Kalman filter."""

    name = "ckf"
    rule_of = staticmethod(cubature)
