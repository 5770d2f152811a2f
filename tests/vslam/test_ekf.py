"""EKF-SLAM against a plain dense filter written here, against statistics, and at its edges."""

import numpy as np
import pytest
from scipy.stats import chi2

from vslam.backends.ekf import Ekf
from vslam.errors import VslamError
from vslam.frame import Observations, Odometry
from vslam.geometry import to_local
from vslam.motion import motion_jacobians, move
from vslam.observation import observation_models
from vslam.slam_backend import DISCARDED, NEW

FORMS = ["cartesian", "range_bearing"]

# A world in which the filter's models are exact: a robot that circles among landmarks, Gaussian noise.
Q = np.diag([0.01, 0.005, 0.004]) ** 2  # per step, m, m, rad
S = np.array([[0.03**2, 1e-4], [1e-4, 0.02**2]])
RANGE_M = 3.0


class DenseEkf:
    """The textbook, with whole matrices and an explicit inverse."""

    def __init__(self, model):
        self.model, self.x, self.P = model, np.zeros(3), np.zeros((3, 3))

    def step(self, odometry, observations, numbers):
        F, Fn = np.eye(len(self.x)), np.zeros((len(self.x), 3))
        F[:3, :3], Fn[:3] = motion_jacobians(self.x[:3], odometry.delta)
        self.x[:3] = move(self.x[:3], odometry.delta)
        self.P = F @ self.P @ F.T + Fn @ odometry.covariance @ Fn.T
        z, R = self.model.measure(observations)
        known = (len(self.x) - 3) // 2
        self._correct([(z[k], R[k], j) for k, j in enumerate(numbers) if j < known])
        for k, j in enumerate(numbers):
            if j >= known:
                self._found(z[k], R[k])

    def _correct(self, pairs):
        if not pairs:
            return
        H, innovation = np.zeros((2 * len(pairs), len(self.x))), []
        noise = np.zeros((2 * len(pairs), 2 * len(pairs)))
        for row, (z, R, j) in enumerate(pairs):
            at, landmark = slice(3 + 2 * j, 5 + 2 * j), self.x[3 + 2 * j : 5 + 2 * j][None]
            H_R, H_L = self.model.h_jacobians(self.x[:3], landmark)
            H[2 * row : 2 * row + 2, :3], H[2 * row : 2 * row + 2, at] = H_R[0], H_L[0]
            noise[2 * row : 2 * row + 2, 2 * row : 2 * row + 2] = R
            innovation.append(self.model.innovation(z[None], self.model.h(self.x[:3], landmark))[0])
        K = self.P @ H.T @ np.linalg.inv(H @ self.P @ H.T + noise)
        self.x = self.x + K @ np.concatenate(innovation)
        self.P = (np.eye(len(self.x)) - K @ H) @ self.P

    def _found(self, z, R):
        G_R, G_z = (G[0] for G in self.model.g_jacobians(self.x[:3], z[None]))
        J = np.vstack([np.eye(len(self.x)), np.hstack([G_R, np.zeros((2, len(self.x) - 3))])])
        self.P = J @ self.P @ J.T
        self.P[-2:, -2:] += G_z @ R @ G_z.T
        self.x = np.append(self.x, self.model.g(self.x[:3], z[None])[0])


def simulate(generator, steps, landmarks, per_picture=6):
    """A noisy drive round a circle: (odometry, observations) of each step, and the true poses."""
    pose, delta = np.zeros(3), np.array([0.3, 0.0, 0.1])
    world = np.array([0.0, 3.0]) + generator.uniform(-5.0, 5.0, (landmarks, 2))
    drive, truth = [], []
    for _ in range(steps):
        pose = move(pose, delta)
        measured = generator.multivariate_normal(delta, Q)
        # The increment's error lies in the measurement, so the truth is the nominal drive.
        local = to_local(pose, world)
        near = np.flatnonzero((np.hypot(*local.T) < RANGE_M) & (local[:, 0] > 0.3))[:per_picture]
        points = local[near] + generator.multivariate_normal(np.zeros(2), S, len(near))
        drive.append((Odometry(measured, Q), Observations(points, np.tile(S, (len(near), 1, 1)), near)))
        truth.append(pose)
    return drive, np.array(truth)


class Numbering:
    """Landmark numbers by id, in the order of first sight."""

    def __init__(self):
        self.known = {}

    def __call__(self, ids):
        before = len(self.known)
        numbers = [self.known.setdefault(i, len(self.known)) for i in ids.tolist()]
        return np.array(numbers, dtype=np.int64), np.array(
            [j if j < before else NEW for j in numbers], dtype=np.int64
        )


def run(model, drive):
    ekf, numbering = Ekf(model), Numbering()
    for odometry, observations in drive:
        ekf.predict(odometry)
        numbers, hypothesis = numbering(observations.ids)
        np.testing.assert_array_equal(ekf.update(observations, hypothesis), numbers)
    return ekf


@pytest.mark.parametrize("form", FORMS)
def test_equals_the_dense_textbook_filter(form):
    model = observation_models.get(form)()
    drive, _ = simulate(np.random.default_rng(1), steps=30, landmarks=150, per_picture=8)
    dense, numbering = DenseEkf(model), Numbering()
    for odometry, observations in drive:
        dense.step(odometry, observations, numbering(observations.ids)[0])
    ekf = run(model, drive)
    assert len(ekf.landmarks) > 32, "the state must outgrow its first chunk"
    np.testing.assert_allclose(ekf.pose, dense.x[:3], atol=1e-9)
    np.testing.assert_allclose(ekf.landmarks.ravel(), dense.x[3:], atol=1e-9)
    np.testing.assert_allclose(ekf.covariance, dense.P, atol=1e-9 * np.abs(dense.P).max())


def test_the_blocks_are_those_of_the_whole_covariance():
    drive, _ = simulate(np.random.default_rng(2), steps=15, landmarks=40)
    ekf = run(observation_models.get("cartesian")(), drive)
    P, n = ekf.covariance, len(ekf.landmarks)
    np.testing.assert_array_equal(ekf.pose_covariance, P[:3, :3])
    np.testing.assert_array_equal(ekf.cross_covariances, [P[:3, 3 + 2 * i : 5 + 2 * i] for i in range(n)])
    own = [P[3 + 2 * i : 5 + 2 * i, 3 + 2 * i : 5 + 2 * i] for i in range(n)]
    np.testing.assert_array_equal(ekf.landmark_covariances, own)
    rows = [0, 1, 2, 3 + 2 * 7, 4 + 2 * 7, 3 + 2 * 2, 4 + 2 * 2]
    np.testing.assert_array_equal(ekf.joint_covariance(np.array([7, 2])), P[np.ix_(rows, rows)])


@pytest.mark.parametrize("form", FORMS)
def test_covariance_stays_symmetric_and_positive(form):
    drive, _ = simulate(np.random.default_rng(3), steps=300, landmarks=40)
    P = run(observation_models.get(form)(), drive).covariance
    np.testing.assert_array_equal(P, P.T)
    assert np.linalg.eigvalsh(P)[0] > -1e-12 * np.abs(P).max()


@pytest.mark.parametrize("form", FORMS)
def test_is_consistent_where_its_models_are_exact(form):
    """Mean NEES of the pose over 50 runs inside its χ² band (95 %), at every tenth step of two rounds."""
    model, runs, steps = observation_models.get(form)(), 50, 120
    nees = np.zeros((runs, steps))
    for r in range(runs):
        drive, truth = simulate(np.random.default_rng([7, r]), steps, landmarks=25, per_picture=4)
        ekf, numbering = Ekf(model), Numbering()
        for k, (odometry, observations) in enumerate(drive):
            ekf.predict(odometry)
            ekf.update(observations, numbering(observations.ids)[1])
            e = ekf.pose - truth[k]
            nees[r, k] = e @ np.linalg.solve(ekf.pose_covariance, e)
    low, high = chi2.ppf([0.025, 0.975], df=3 * runs) / runs
    at = nees[:, 9::10].mean(axis=0)
    inside = (at >= low) & (at <= high)
    assert inside.mean() >= 0.85, at
    assert low <= at[-1] <= high, at


@pytest.mark.parametrize("form", FORMS)
def test_the_order_of_observations_does_not_matter(form):
    model = observation_models.get(form)()
    drive, _ = simulate(np.random.default_rng(4), steps=40, landmarks=30)
    generator = np.random.default_rng(0)
    shuffled, founded = [], Numbering()
    for odometry, o in drive:
        order = generator.permutation(len(o))
        shuffled.append((odometry, Observations(o.points[order], o.covariances[order], o.ids[order])))
        founded(o.ids)
    one, other = run(model, drive), run(model, shuffled)
    np.testing.assert_allclose(one.pose, other.pose, atol=1e-10)
    np.testing.assert_allclose(one.pose_covariance, other.pose_covariance, atol=1e-12)
    by_x = [np.sort(e.landmarks[:, 0]) for e in (one, other)]
    np.testing.assert_allclose(by_x[0], by_x[1], atol=1e-10)


def test_starts_certain_at_the_origin_and_grows_unsure_by_dead_reckoning():
    ekf = Ekf(observation_models.get("cartesian")())
    assert not ekf.pose.any() and not ekf.pose_covariance.any()
    determinants = []
    for _ in range(5):
        ekf.predict(Odometry(np.array([1.0, 0.0, 0.2]), Q))
        ekf.update(Observations.none(), np.zeros(0, dtype=np.int64))
        determinants.append(np.linalg.det(ekf.pose_covariance))
    assert np.all(np.diff(determinants) > 0)


def test_a_discarded_observation_changes_nothing():
    drive, _ = simulate(np.random.default_rng(6), steps=10, landmarks=30)
    ekf = run(observation_models.get("cartesian")(), drive)
    pose, P = ekf.pose, ekf.covariance
    stray = Observations(np.array([[1.0, 1.0]]), S[None], np.array([-1]))
    np.testing.assert_array_equal(ekf.update(stray, np.array([DISCARDED])), [DISCARDED])
    np.testing.assert_array_equal(ekf.pose, pose)
    np.testing.assert_array_equal(ekf.covariance, P)


def test_a_second_sight_of_a_landmark_halves_its_variance():
    """With a robot that knows where it stands, two sights average."""
    ekf = Ekf(observation_models.get("cartesian")())
    sight = Observations(np.array([[2.0, 1.0]]), S[None], np.array([0]))
    ekf.update(sight, np.array([NEW]))
    np.testing.assert_allclose(ekf.landmark_covariances[0], S, rtol=1e-12)
    ekf.update(Observations(sight.points + 0.01, S[None], sight.ids), np.array([0]))
    np.testing.assert_allclose(ekf.landmark_covariances[0], S / 2, rtol=1e-12)
    np.testing.assert_allclose(ekf.landmarks[0], [2.005, 1.005], rtol=1e-12)


def test_a_robot_that_cannot_slide_has_singular_noise():
    """Q of the dissertation's u = [Δx, Δθ] has a zero row: allowed."""
    ekf = Ekf(observation_models.get("cartesian")())
    ekf.predict(Odometry(np.array([1.0, 0.0, 0.1]), np.diag([1e-4, 0.0, 1e-6])))
    assert np.isfinite(ekf.pose_covariance).all()


@pytest.mark.parametrize(
    ("delta", "covariance", "message"),
    [
        ([np.nan, 0.0, 0.0], Q, "not finite"),
        ([0.1, 0.0, 0.0], np.full((3, 3), np.inf), "not finite"),
        ([0.1, 0.0, 0.0], np.diag([1e-4, -1e-4, 1e-4]), "not positive semi-definite"),
        (
            [0.1, 0.0, 0.0],
            np.diag([1e-4, 1e-4, 1e-4]) + np.triu(np.full((3, 3), 1e-5), 1),
            "not positive semi-definite",
        ),
    ],
)
def test_bad_odometry_is_one_clear_line(delta, covariance, message):
    with pytest.raises(VslamError, match=message):
        Ekf(observation_models.get("cartesian")()).predict(Odometry(np.array(delta), covariance))


@pytest.mark.parametrize(
    ("point", "covariance", "message"),
    [
        ([np.nan, 1.0], S, "not finite"),
        ([1.0, 1.0], -S, "not positive definite"),
        ([1.0, 1.0], np.zeros((2, 2)), "not positive definite"),
        ([1.0, 1.0], [[1.0, 2.0], [2.0, 1.0]], "not positive definite"),
        ([1.0, 1.0], [[1.0, 0.5], [0.0, 1.0]], "not positive definite"),
    ],
)
def test_bad_observations_are_one_clear_line(point, covariance, message):
    observations = Observations(np.array([point]), np.array([covariance]), np.array([0]))
    with pytest.raises(VslamError, match=message):
        Ekf(observation_models.get("range_bearing")()).update(observations, np.array([NEW]))


@pytest.mark.parametrize("hypothesis", [[0], [5], [-3], [NEW, NEW]])
def test_a_hypothesis_must_fit(hypothesis):
    observations = Observations(np.array([[1.0, 1.0]]), S[None], np.array([0]))
    with pytest.raises(VslamError, match="hypothes"):
        Ekf(observation_models.get("cartesian")()).update(observations, np.array(hypothesis))
