"""A path follower for a differential drive: regulated pure pursuit.

Sources
-------
Pure pursuit: Coulter 1992, *Implementation of the pure pursuit path tracking algorithm*, κ = 2 y / L².
Its regulation (slower where the arc is tight and near the goal, turns in place where the path leads away):
Macenski, Singh, Martín & Ginés 2023, *Regulated pure pursuit for robot path tracking*, Autonomous Robots 47.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vslam.errors import VslamError
from vslam.geometry import wrap_angle

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Command:
    """What the drive is told: forward speed, m/s, and turn rate, rad/s counter-clockwise."""

    speed_mps: float
    turn_radps: float


STOP = Command(0.0, 0.0)


@dataclass(frozen=True)
class FollowerSettings:
    """Limits and gains; but for speed and turn rate they are the defaults of nav2's controller of that name.

    Attributes
    ----------
    speed_mps : float
        Largest forward speed; Table 4-1's.
    turn_radps : float
        Largest turn rate. At 1 rad/s two pictures 0.4 s apart share 127° of their 150°.
    lookahead_s, min_lookahead_m, max_lookahead_m : float
        The carrot runs so many seconds of driving ahead on the path, within these bounds.
    min_radius_m, min_speed_mps : float
        On arcs tighter than this the speed falls in proportion to the radius, but not below.
    approach_m, approach_speed_mps : float
        Within so many metres of a stop the speed falls in proportion to the distance, but not below.
    turn_in_place_rad, aligned_rad : float
        Where the carrot lies farther aside than the first, the robot turns on the spot until it lies within
        the second. Corners sharper than the first are driven up to.
    arrival_m : float
        As near counts as there.
    """

    speed_mps: float = 0.93
    turn_radps: float = 1.0
    lookahead_s: float = 1.5
    min_lookahead_m: float = 0.3
    max_lookahead_m: float = 0.6
    min_radius_m: float = 0.9
    min_speed_mps: float = 0.25
    approach_m: float = 0.6
    approach_speed_mps: float = 0.05
    turn_in_place_rad: float = 0.785
    aligned_rad: float = 0.1
    arrival_m: float = 0.08


class PathFollower:
    """Follows one path; made anew for each plan.

    Parameters
    ----------
    path : (n, 2) array_like
        Vertices, metres, in the frame of the poses; n ≥ 1.

    Raises
    ------
    VslamError
        When the path has no vertex or one that is not finite.
    """

    def __init__(self, path: ArrayLike, settings: FollowerSettings | None = None) -> None:
        self.settings = settings or FollowerSettings()
        self.path = _without_repeats(np.asarray(path, dtype=np.float64))
        legs = np.diff(self.path, axis=0)
        self._along = np.concatenate([[0.0], np.cumsum(np.hypot(*legs.T))])
        headings = np.arctan2(legs[:, 1], legs[:, 0])
        sharp = np.abs(wrap_angle(np.diff(headings))) > self.settings.turn_in_place_rad
        self._stops = [*self._along[1:-1][sharp].tolist(), float(self._along[-1])]
        self._done_m, self._turning = 0.0, False

    @property
    def remaining(self) -> FloatArray:
        """(m, 2) float64: what is left of the path, from the point abreast of the robot."""
        ahead = self.path[self._along > self._done_m]
        return np.vstack([self._at(self._done_m), ahead])

    @property
    def remaining_m(self) -> float:
        """Metres of path left."""
        return float(self._along[-1] - self._done_m)

    def off_path_m(self, pose: FloatArray) -> float:
        """Distance to the point of the path that the robot should be at."""
        return float(np.linalg.norm(self._at(self._done_m) - pose[:2]))

    def arrived(self, pose: FloatArray) -> bool:
        """Whether a pose lies at the path's end, and no corner is left out."""
        near = float(np.linalg.norm(self.path[-1] - pose[:2])) <= self.settings.arrival_m
        return near and len(self._stops) == 1

    def command(self, pose: FloatArray) -> Command:
        """What to do at a pose (x, y in metres, heading in rad)."""
        own, (x, y, heading) = self.settings, pose
        self._progress(pose[:2])
        stop = self._stops[0]
        lookahead = float(np.clip(own.speed_mps * own.lookahead_s, own.min_lookahead_m, own.max_lookahead_m))
        carrot = self._at(min(self._done_m + lookahead, stop))
        dx, dy = carrot[0] - x, carrot[1] - y
        distance, aside = float(np.hypot(dx, dy)), float(wrap_angle(np.arctan2(dy, dx) - heading))
        if distance < 1e-6:
            return STOP
        if abs(aside) > (own.aligned_rad if self._turning else own.turn_in_place_rad):
            self._turning = True
            rate = min(own.turn_radps, max(abs(aside) * 4.0, 0.2))  # slower in the end: no overshoot at 10 Hz
            return Command(0.0, float(np.copysign(rate, aside)))
        self._turning = False
        curvature = 2.0 * np.sin(aside) / distance
        return self._regulated(float(curvature), float(np.linalg.norm(self._at(stop) - pose[:2])))

    def _regulated(self, curvature: float, to_stop_m: float) -> Command:
        own = self.settings
        speed = own.speed_mps
        if abs(curvature) * own.min_radius_m > 1.0:
            speed = max(speed / (abs(curvature) * own.min_radius_m), own.min_speed_mps)
        if to_stop_m < own.approach_m:
            speed = min(speed, max(own.speed_mps * to_stop_m / own.approach_m, own.approach_speed_mps))
        if abs(curvature) * speed > own.turn_radps:
            speed = own.turn_radps / abs(curvature)
        return Command(speed, curvature * speed)

    def _progress(self, xy: FloatArray) -> None:
        """Move to the nearest point of the path, forwards, no farther than the carrot and the next stop."""
        if len(self._stops) > 1 and np.linalg.norm(self._at(self._stops[0]) - xy) <= self.settings.arrival_m:
            self._done_m = self._stops.pop(0)
            return
        end = min(self._done_m + self.settings.max_lookahead_m, self._stops[0])
        places = np.append(np.arange(self._done_m, end, 0.02), end)
        distances = np.linalg.norm(self._at(places) - xy, axis=1)
        self._done_m = float(places[int(np.argmin(distances))])

    def _at(self, along: float | FloatArray) -> FloatArray:
        """(..., 2) float64: the points so many metres along the path."""
        return np.stack([np.interp(along, self._along, self.path[:, k]) for k in (0, 1)], axis=-1)


def _without_repeats(path: FloatArray) -> FloatArray:
    if path.ndim != 2 or path.shape[1] != 2 or not len(path) or not np.isfinite(path).all():
        raise VslamError(f"follower: needs a finite (n, 2) path with n ≥ 1, not one of shape {path.shape}")
    new = np.append(True, np.hypot(*np.diff(path, axis=0).T) > 1e-9)
    kept: FloatArray = path[new]
    return kept
