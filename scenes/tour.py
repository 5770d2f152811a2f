"""Tours: a track of poses driven at constant speed along a closed way with rounded corners."""

from __future__ import annotations

import numpy as np

from scenes.errors import SceneError
from scenes.model import FloatArray, Tour


def rounded_loop(corners: FloatArray, radius: float, spacing_m: float = 0.005) -> FloatArray:
    """Sample a closed polygon whose corners are arcs.

    Parameters
    ----------
    corners : (k, 2) float64
        Polygon, in driving order, metres.
    radius : float
        Of the corner arcs, metres.

    Returns
    -------
    points : (n, 2) float64
        About ``spacing_m`` apart; the last is followed by the first.
    """
    pieces = []
    for before, corner, after in zip(np.roll(corners, 1, 0), corners, np.roll(corners, -1, 0), strict=True):
        into = (corner - before) / np.linalg.norm(corner - before)
        out = (after - corner) / np.linalg.norm(after - corner)
        turn = np.arctan2(into[0] * out[1] - into[1] * out[0], into @ out)
        reach = radius * np.tan(abs(turn) / 2)
        if reach > 0.5 * min(np.linalg.norm(corner - before), np.linalg.norm(after - corner)):
            raise SceneError(f"tour: corner radius {radius} m does not fit at {corner}; choose a smaller one")
        left = np.sign(turn) * np.array([-into[1], into[0]])
        centre = corner - reach * into + radius * left
        phi = np.linspace(0, turn, max(2, int(np.ceil(radius * abs(turn) / spacing_m))))
        spoke = -radius * left
        arc = centre + np.stack(
            [
                spoke[0] * np.cos(phi) - spoke[1] * np.sin(phi),
                spoke[0] * np.sin(phi) + spoke[1] * np.cos(phi),
            ],
            axis=1,
        )
        start, stop = arc[-1], after - out * reach
        n = max(2, int(np.ceil(np.linalg.norm(stop - start) / spacing_m)))
        pieces += [arc, start + np.linspace(0, 1, n + 1)[1:-1, None] * (stop - start)]
    return np.concatenate(pieces)


def loop_length(way: FloatArray) -> float:
    """Metres along a closed polyline, (n, 2)."""
    return float(np.linalg.norm(np.roll(way, -1, axis=0) - way, axis=1).sum())


def starting_at(way: FloatArray, place: tuple[float, float]) -> FloatArray:
    """The same closed polyline, (n, 2), from its point nearest to a place."""
    return np.roll(way, -int(np.argmin(np.linalg.norm(way - place, axis=1))), axis=0)


def drive(way: FloatArray, start_m: float, length_m: float, speed_mps: float, interval_s: float) -> Tour:
    """Drive along a closed way and note the pose at each frame.

    Parameters
    ----------
    way : (n, 2) float64
        Closed polyline, metres.
    start_m, length_m : float
        Where on the way the tour starts and how far it goes, metres along it; it may go round more than once.

    Raises
    ------
    SceneError
        If speed or interval is not positive, or the length negative.
    """
    if not (0 < speed_mps < np.inf and 0 < interval_s < np.inf and 0 <= length_m < np.inf):
        raise SceneError(
            f"tour: speed {speed_mps} m/s and frame interval {interval_s} s must be positive, "
            f"length {length_m} m not negative"
        )
    closed = np.vstack([way, way[:1]])
    segment = np.diff(closed, axis=0)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(segment, axis=1))])
    heading = np.unwrap(np.arctan2(segment[:, 1], segment[:, 0]))
    heading = np.append(heading, heading[0] + 2 * np.pi * np.round((heading[-1] - heading[0]) / (2 * np.pi)))
    stamps = interval_s * np.arange(int(length_m / (speed_mps * interval_s)) + 1, dtype=np.float64)
    s = start_m + stamps * speed_mps
    laps, s = np.floor(s / along[-1]), np.mod(s, along[-1])
    poses = np.empty((len(s), 3))
    poses[:, 0] = np.interp(s, along, closed[:, 0])
    poses[:, 1] = np.interp(s, along, closed[:, 1])
    poses[:, 2] = np.interp(s, along, heading) + laps * (heading[-1] - heading[0])
    return Tour(poses, stamps)


def orbit(
    centre: tuple[float, float], radius: float, laps: float, speed_mps: float, interval_s: float
) -> Tour:
    """Go round a place counter-clockwise with the camera towards it, as a robot does that can drive sideways.

    Parameters
    ----------
    radius : float
        Of the circle that is driven, metres.
    laps : float
        Times around.

    Raises
    ------
    SceneError
        As `drive`.
    """
    angle = np.linspace(-np.pi, np.pi, 720, endpoint=False)
    circle = np.asarray(centre) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    tangent = drive(circle, 0.0, laps * loop_length(circle), speed_mps, interval_s)
    return Tour(tangent.poses + np.array([0.0, 0.0, np.pi / 2]), tangent.stamps)


def body_twist(tour: Tour, frame: int) -> FloatArray:
    """The robot's velocity at a frame: the mean of the constant twists from the frame before and to the next.

    Returns
    -------
    (3,) float64
        Forward and left, m/s, in the robot's frame; counter-clockwise, rad/s. 0 for a tour of one frame.
    """
    steps = [(k, k + 1) for k in (frame - 1, frame) if 0 <= k < len(tour.stamps) - 1]
    twists = [_twist(tour.poses[a], tour.poses[b], tour.stamps[b] - tour.stamps[a]) for a, b in steps]
    return np.mean(twists, axis=0) if twists else np.zeros(3)


def _twist(before: FloatArray, after: FloatArray, seconds: float) -> FloatArray:
    """The constant twist that leads from one pose to another: the logarithm of SE(2) over the time."""
    turn = float(np.remainder(after[2] - before[2] + np.pi, 2 * np.pi) - np.pi)
    c, s = np.cos(before[2]), np.sin(before[2])
    x, y = np.array([[c, s], [-s, c]]) @ (after[:2] - before[:2])
    half = turn / 2
    stretch = half / np.tan(half) if abs(half) > 1e-9 else 1.0
    return np.array([stretch * x + half * y, stretch * y - half * x, turn]) / seconds
