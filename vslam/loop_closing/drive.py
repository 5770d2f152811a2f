"""SLAM over a whole drive that closes its loops: association ``constellation``.

Step by step the local map tracks discs, which is easy, and says nothing of places seen long ago.
Every few metres the robot smooths what it has and asks whether the discs of the last metres lie like
discs it knows from before; if so, and if there is only one way to see it, they become one. When the
drive is over, what was put off is asked again, duplicates that now lie on each other are joined, and
every observation is paired anew with the smoothed map.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vslam.backends.parts.input_checks import check_observations, check_odometry
from vslam.frame import Observations, Odometry
from vslam.geometry import to_global
from vslam.loop_closing.closer import Bounds, closures
from vslam.loop_closing.hindsight import neighbours, pair_anew
from vslam.loop_closing.local_map import LocalMap
from vslam.loop_closing.record import Fragments, Record
from vslam.loop_closing.smoother import CAUCHY, LEAST_SQUARES, Estimate, smooth
from vslam.motion import motion_jacobians, move

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

WINDOW_M = 8.0
"""The query: discs of the last eight metres, about twenty on the DLR log; more would bend with the track."""

STRIDE_M = 4.0
"""Half a window, so that each disc is asked for twice, in different company."""

SIGHTS = 3
"""A disc counts from its third sight: false detections seldom repeat, and a mean of three is known
to 3 cm."""

LARGEST_SIGMAS = 4.0
"""How far the track may be off, in σ of its loosest pose so far: 1 in 3,000 is farther (two degrees
of freedom). Two poses together are off by √2 of it at most, as errors along a track correlate positively."""


class Drive:
    """The drive as it goes.

    Parameters
    ----------
    gate, new_gate : float
        As in `vslam.slam.SlamSettings`.

    Attributes
    ----------
    poses : (n + 1, 3) float64
        The start and the pose after each step, as estimated now.
    online_poses, online_covariances : list of n (3,) and (3, 3) float64
        As they were when the step was taken.
    closed : list of (step, pairings made)
    """

    def __init__(self, gate: float = 0.99, new_gate: float = 0.9999) -> None:
        self._gate = new_gate
        self._local = LocalMap(gate, new_gate)
        self._record, self._fragments = Record(), Fragments()
        self._landmarks: dict[int, FloatArray] = {}
        self._travelled = [0.0]
        self._keyframe_at = 0.0
        self._deferred: list[int] = []
        self._loosest = np.zeros(2)  # σ of heading and position
        self.poses = np.zeros((1, 3))
        self.online_poses: list[FloatArray] = []
        self.online_covariances: list[FloatArray] = []
        self.closed: list[tuple[int, int]] = []

    def step(self, odometry: Odometry, observations: Observations) -> None:
        """Take one increment and what is seen after it.

        Raises
        ------
        VslamError
            For input that is not finite or covariances that are not positive definite.
        """
        check_odometry(odometry)
        check_observations(observations)
        tracks = self._local.step(odometry, observations)
        picture = len(self._record)
        self._record.add(odometry, observations, tracks)
        self._move(odometry)
        for fragment, point in zip(tracks.tolist(), observations.points, strict=True):
            if fragment >= 0:
                self._fragments.see(fragment, picture)
                self._landmarks.setdefault(fragment, to_global(self.poses[-1], point[None])[0])
        self._travelled.append(self._travelled[-1] + float(np.hypot(*odometry.delta[:2])))
        if self._travelled[-1] - self._keyframe_at >= STRIDE_M:
            self._keyframe(picture)

    def finish(self) -> tuple[Estimate, list[IntArray]]:
        """Decide with hindsight and smooth for the last time.

        Returns
        -------
        Estimate
            All poses, and the landmarks with at least `SIGHTS` observations.
        list of n (n_k,) int64
            Landmark of each observation, −1 for none; numbered in the order of their first mention.
        """
        for picture in self._deferred:
            self._ask(picture, *self._solve(1))
        while True:
            estimate, used, labels = self._solve()
            if not self._merge(used, neighbours(estimate, self._gate)):
                break
        known = np.flatnonzero(self._fragments.sights()[used] >= SIGHTS)
        landmarks, poses = estimate.landmarks[known], estimate.poses
        # The gates of the new pairings have done what the robust loss was for, so the last solution is least
        # squares: reweighted least squares of one step (Rousseeuw & Leroy 1987).
        for cauchy in (CAUCHY, LEAST_SQUARES):
            labels = pair_anew(poses[1:], landmarks, self._record.observations, self._gate)
            labels, order = _renumbered(labels, len(landmarks))
            estimate = smooth(
                self._record.problem(labels), poses, landmarks[order], tolerance=1e-3, cauchy=cauchy
            )
            landmarks, poses = estimate.landmarks, estimate.poses
        return estimate, labels

    def _move(self, odometry: Odometry) -> None:
        """Carry pose and covariance along until the next smoothing."""
        last = self.poses[-1]
        F_R, F_n = motion_jacobians(last, odometry.delta)
        P = self.online_covariances[-1] if self.online_covariances else np.zeros((3, 3))
        self.online_covariances.append(F_R @ P @ F_R.T + F_n @ odometry.covariance @ F_n.T)
        self.poses = np.vstack([self.poses, move(last, odometry.delta)])
        self.online_poses.append(self.poses[-1])

    def _keyframe(self, picture: int) -> None:
        self._keyframe_at = self._travelled[-1]
        estimate, used, labels = self._solve(1)
        P = estimate.pose_covariance(picture + 1)
        self._loosest = np.maximum(self._loosest, np.sqrt([P[2, 2], np.linalg.eigvalsh(P[:2, :2])[1]]))
        if self._ask(picture, estimate, used, labels):
            estimate, _, _ = self._solve()
            P = estimate.pose_covariance(picture + 1)
        self.online_poses[-1], self.online_covariances[-1] = self.poses[-1], P

    def _ask(self, picture: int, estimate: Estimate, used: IntArray, labels: list[IntArray]) -> bool:
        """Whether the discs around a picture are known from elsewhere; merges them if so."""
        first = int(np.searchsorted(self._travelled, self._travelled[picture + 1] - WINDOW_M))
        window = np.unique(np.concatenate(labels[first : picture + 1]))
        window = window[window >= 0]
        often = self._fragments.sights()[used] >= SIGHTS
        others = np.setdiff1d(np.flatnonzero(often), window)
        bounds = Bounds(self._gate, *(np.sqrt(2.0) * LARGEST_SIGMAS * self._loosest))
        answer = closures(estimate, window[often[window]], others, bounds)
        if answer.deferred:
            self._deferred.append(picture)
        merged = self._merge(used, answer.pairs)
        if merged:
            self.closed.append((picture, merged))
        return merged > 0

    def _merge(self, used: IntArray, pairs: list[tuple[int, int]]) -> int:
        return sum(self._fragments.merge(int(used[a]), int(used[b])) for a, b in pairs)

    def _solve(self, iterations: int = 20) -> tuple[Estimate, IntArray, list[IntArray]]:
        """Smooth all there is; the estimate, the fragment that stands for each landmark, and the labels."""
        used, labels = self._fragments.labels(self._record.tracks)
        guess = np.array([self._landmarks[f] for f in used.tolist()]).reshape(-1, 2)
        # A centimetre is a quarter of one sight's σ: closer need not be known before the end.
        estimate = smooth(self._record.problem(labels), self.poses, guess, iterations, tolerance=0.01)
        self.poses = estimate.poses
        self._landmarks.update(zip(used.tolist(), estimate.landmarks, strict=True))
        return estimate, used, labels


def _renumbered(labels: list[IntArray], count: int) -> tuple[list[IntArray], IntArray]:
    """Drop landmarks with fewer than `SIGHTS` observations, number the others by their first mention."""
    flat = np.concatenate([np.zeros(0, dtype=np.int64), *labels])
    sights = np.bincount(flat[flat >= 0], minlength=count)
    mentioned, first = np.unique(flat, return_index=True)
    order = mentioned[np.argsort(first, kind="stable")]
    order = order[order >= 0]
    order = order[sights[order] >= SIGHTS]
    number = np.full(count + 1, -1, dtype=np.int64)  # the last entry answers to −1
    number[order] = np.arange(len(order))
    return [number[label] for label in labels], order
