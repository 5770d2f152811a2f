"""What a drive has measured so far, and which fragments are taken for one disc."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vslam.frame import Observations, Odometry
from vslam.loop_closing.smoother import Problem, inverse_roots

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class Fragments:
    """Fragments that are one disc, as disjoint sets; two discs of one picture are never one.

    A fragment is what the local map has tracked without a gap. Its number is its own for ever; ``root`` names
    the disc.
    """

    def __init__(self) -> None:
        self._root: list[int] = []
        self._pictures: list[set[int]] = []

    def __len__(self) -> int:
        return len(self._root)

    def see(self, fragment: int, picture: int) -> None:
        """Note a sight; an unknown fragment is the next number."""
        if fragment == len(self._root):
            self._root.append(fragment)
            self._pictures.append(set())
        self._pictures[self.root(fragment)].add(picture)

    def root(self, fragment: int) -> int:
        """The fragment that stands for the disc."""
        while self._root[fragment] != fragment:
            self._root[fragment] = self._root[self._root[fragment]]
            fragment = self._root[fragment]
        return fragment

    def labels(self, tracks: list[IntArray]) -> tuple[IntArray, list[IntArray]]:
        """Discs counted from 0.

        Returns
        -------
        (l,) int64
            The fragment that stands for each disc, rising.
        list of (n_k,) int64
            The disc of each tracked observation, −1 for none.
        """
        roots = np.array([self.root(f) for f in range(len(self))], dtype=np.int64)
        used, number = np.unique(roots, return_inverse=True)
        number = np.append(number, -1)  # the last entry answers to −1
        return used, [number[track] for track in tracks]

    def sights(self) -> IntArray:
        """Number of pictures that show the disc of each fragment, (n,) int64."""
        return np.array([len(self._pictures[self.root(f)]) for f in range(len(self))], dtype=np.int64)

    def may_merge(self, a: int, b: int) -> bool:
        """Whether no picture shows both as two discs."""
        a, b = self.root(a), self.root(b)
        return a != b and self._pictures[a].isdisjoint(self._pictures[b])

    def merge(self, a: int, b: int) -> bool:
        """Take two fragments for one disc, named after the older; False where a picture shows them apart."""
        if not self.may_merge(a, b):
            return False
        a, b = sorted((self.root(a), self.root(b)))
        self._root[b] = a
        self._pictures[a] |= self._pictures[b]
        return True


class Record:
    """Odometry and observations of all steps."""

    def __init__(self) -> None:
        self.odometry: list[Odometry] = []
        self.observations: list[Observations] = []
        self.tracks: list[IntArray] = []
        self._roots: list[FloatArray] = []
        self._point_roots: list[FloatArray] = []

    def __len__(self) -> int:
        return len(self.odometry)

    def add(self, odometry: Odometry, observations: Observations, tracks: IntArray) -> None:
        """Append a step; ``tracks`` is the fragment of each observation, −1 for none."""
        self.odometry.append(odometry)
        self.observations.append(observations)
        self.tracks.append(tracks)
        self._roots.append(_root_of(odometry.covariance))
        self._point_roots.append(inverse_roots(observations.covariances))

    def problem(self, labels: list[IntArray]) -> Problem:
        """The smoothing problem in which each observation shows the landmark of its label, −1 for none."""
        flat = np.concatenate([np.zeros(0, dtype=np.int64), *labels])
        used = flat >= 0
        lengths = [len(part) for part in labels]
        return Problem(
            np.array([o.delta for o in self.odometry]).reshape(-1, 3),
            np.array(self._roots).reshape(-1, 3, 3),
            np.repeat(np.arange(1, len(labels) + 1), lengths)[used],
            flat[used],
            np.concatenate([np.zeros((0, 2)), *(o.points for o in self.observations)])[used],
            np.concatenate([np.zeros((0, 2, 2)), *self._point_roots])[used],
        )


def _root_of(Q: FloatArray) -> FloatArray:
    """W of an odometry covariance; a direction without noise gets a thousandth of the largest variance."""
    floor = max(1e-6 * float(np.trace(Q)), 1e-12)
    return np.asarray(np.linalg.inv(np.linalg.cholesky(Q + floor * np.eye(3))))
