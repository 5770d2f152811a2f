"""Unscented Kalman filter SLAM.

Sources: Julier & Uhlmann 1997, "A new extension of the Kalman filter to nonlinear systems"; Julier 2002, "The
scaled unscented transformation"; for SLAM, Martinez-Cantin & Castellanos 2005, "Unscented SLAM for
large-scale outdoor environments". `sigma_points` says why points over pose and seen landmarks are enough.
"""

from __future__ import annotations

from vslam.backends.parts.sigma_point_filter import SigmaPointFilter
from vslam.backends.parts.sigma_points import unscented
from vslam.slam_backend import backends


@backends.register("ukf")
class Ukf(SigmaPointFilter):
    """The unscented Kalman filter with n + κ = 3."""

    name = "ukf"
    rule_of = staticmethod(unscented)
