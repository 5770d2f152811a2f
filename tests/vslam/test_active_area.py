"""The compressed filter of a small area against the Kalman filter of everything."""

import numpy as np
import pytest

from tests.vslam.drives import circle, run
from vslam.backends.parts.active_area import ActiveArea
from vslam.backends.parts.full_covariance import FullCovariance
from vslam.observation import observation_models
from vslam.slam_backend import create

SIZE = 31  # the robot and 14 landmarks
ROWS = np.array([0, 1, 2, 9, 10, 5, 6, 21, 22])  # the area: the robot and three of them, in any order


class Whole:
    """The same steps on the whole of X and P."""

    def __init__(self, P):
        self.X, self.P = np.zeros(len(P)), P

    def move(self, F, noise):
        whole = np.eye(len(self.P))
        whole[:3, :3] = F
        self.P = whole @ self.P @ whole.T
        self.P[:3, :3] += noise

    def correct(self, rows, H, R, Z):
        whole = np.zeros((len(H), len(self.P)))
        whole[:, rows] = H
        K = self.P @ whole.T @ np.linalg.inv(whole @ self.P @ whole.T + R)
        self.X = self.X + K @ Z
        self.P = self.P - K @ whole @ self.P
        return K @ Z

    def append(self, G, noise):
        J = np.vstack([np.eye(len(self.P)), np.zeros((len(G), len(self.P)))])
        J[-len(G) :, :3] = G
        self.P = J @ self.P @ J.T
        self.P[-len(G) :, -len(G) :] += noise
        self.X = np.append(self.X, np.zeros(len(G)))


def random_covariance(generator, n, scale=1.0):
    root = scale * generator.standard_normal((n, n + 2))
    return root @ root.T


def drive_both(generator, steps):
    """An area and the whole through the same random motions and corrections; two landmarks are founded."""
    P = random_covariance(generator, SIZE)
    area, whole = ActiveArea(ROWS, P[:, ROWS], room=6), Whole(P)
    for k in range(steps):
        F, noise = np.eye(3) + 0.1 * generator.standard_normal((3, 3)), random_covariance(generator, 3, 0.1)
        area.move(F, noise)
        whole.move(F, noise)
        at = np.append([0, 1, 2], 3 + generator.permutation(len(area.rows) - 3)[:3])
        H, R = generator.standard_normal((4, len(at))), random_covariance(generator, 4)
        Z = generator.standard_normal(4)
        step = area.correct(at, H, R, Z)
        np.testing.assert_allclose(step, whole.correct(area.rows[at], H, R, Z)[area.rows], atol=1e-8)
        if k in (2, 5):
            G, noise = generator.standard_normal((2, 3)), random_covariance(generator, 2)
            area.append(len(whole.P) + np.arange(2), G, noise)
            whole.append(G, noise)
    return area, whole, P


# 4 rows a step: 7 steps stay within the area's 9 columns, 200 must be compressed while they are collected
@pytest.mark.parametrize("steps", [1, 7, 200])
def test_the_rest_follows_exactly(steps):
    area, whole, P = drive_both(np.random.default_rng(steps), steps)
    np.testing.assert_array_equal(area.P_AA, area.P_AA.T)
    np.testing.assert_allclose(area.columns(), whole.P[:, area.rows], atol=1e-8)
    np.testing.assert_array_equal(area.columns(3), area.columns()[:, :3])
    others = np.setdiff1d(np.arange(SIZE), area.rows)
    loss = area.loss_of_others()
    assert loss.shape[1] == min(4 * steps, len(ROWS))
    np.testing.assert_allclose(
        P[np.ix_(others, others)] - (loss @ loss.T)[np.ix_(others, others)],
        whole.P[np.ix_(others, others)],
        atol=1e-8,
    )
    assert not loss[ROWS].any()
    np.testing.assert_allclose(area.shift_of_others()[others], whole.X[others], atol=1e-7)
    assert not area.shift_of_others().any(), "it was taken"


@pytest.mark.parametrize("steps", [3, 200])
def test_what_is_told_in_parts_is_the_whole(steps):
    """Where V was compressed before all of it was told, telling starts anew."""
    area, _, P = drive_both(np.random.default_rng(1), 4)
    told = area.untold_loss_of_others()
    generator = np.random.default_rng(2)
    for _ in range(steps):
        area.correct(np.arange(5), generator.standard_normal((4, 5)), np.eye(4), np.zeros(4))
    compressed = area.told == 0
    assert compressed == (steps == 200)
    parts = [area.untold_loss_of_others()] if compressed else [told, area.untold_loss_of_others()]
    loss = area.loss_of_others()
    np.testing.assert_allclose(sum(p @ p.T for p in parts), loss @ loss.T, atol=1e-9 * np.abs(P).max())


def test_an_innovation_without_positive_covariance_changes_nothing():
    P = random_covariance(np.random.default_rng(0), SIZE)
    area = ActiveArea(ROWS, P[:, ROWS], room=0)
    H = np.eye(2, 5)
    assert area.correct(np.arange(5), H, -1e6 * np.eye(2), np.ones(2)) is None
    np.testing.assert_array_equal(area.columns(), P[:, ROWS])
    assert area.loss_of_others().shape == (SIZE, 0)


@pytest.mark.parametrize("nearest", [0, 3, 1000])
@pytest.mark.parametrize("name", ["ekf_fej", "ukf"])
def test_the_size_of_the_area_changes_nothing(name, nearest, monkeypatch):
    """Two rounds of a circle with many areas, or few, asked after each step or at the end alone."""
    drive, *_ = circle(np.random.default_rng(8), steps=130, landmarks=90, per_picture=8)
    model = observation_models.get("cartesian")()
    usual = run(name, model, drive)
    assert len(usual.landmarks) > 40
    monkeypatch.setattr(FullCovariance, "nearest", nearest)
    other, known = create(name, model, 0, {}), {}
    for odometry, seen in drive:
        other.predict(odometry)
        hypothesis = np.array([known.get(i, -2) for i in seen.ids.tolist()], dtype=np.int64)
        known.update(zip(seen.ids.tolist(), other.update(seen, hypothesis).tolist(), strict=True))
        blocks, cross = other.landmark_covariances, other.cross_covariances
    P = other.covariance
    np.testing.assert_allclose(other.pose, usual.pose, atol=1e-10)
    np.testing.assert_allclose(other.landmarks, usual.landmarks, atol=1e-10)
    np.testing.assert_allclose(P, usual.covariance, atol=1e-12)
    at = 3 + 2 * np.arange(len(blocks))
    np.testing.assert_allclose(cross[:, :, 0], P[:3, at].T, atol=1e-12)
    np.testing.assert_allclose(blocks[:, 0, 1], P[at, at + 1], atol=1e-12)
    np.testing.assert_allclose(blocks[:, 1, 1], P[at + 1, at + 1], atol=1e-12)
    assert np.linalg.eigvalsh(P)[0] > 0.0
