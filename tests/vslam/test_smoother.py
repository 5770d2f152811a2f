"""The smoother against GTSAM, and what merging does to covariances."""

import gtsam
import numpy as np
import pytest
from gtsam.symbol_shorthand import L, X

from tests.vslam.simulated_building import simulate
from vslam.geometry import to_global
from vslam.loop_closing.record import Fragments, Record
from vslam.loop_closing.smoother import CAUCHY, LEAST_SQUARES, Estimate, Problem, smooth
from vslam.motion import move


def recorded(count=60):
    """The first steps of a simulated drive with known discs, and a first guess from odometry alone."""
    building = simulate(3)
    record, poses, landmarks = Record(), [np.zeros(3)], {}
    for odometry, seen in building.steps[:count]:
        record.add(odometry, seen, seen.ids)
        poses.append(move(poses[-1], odometry.delta))
        for disc, point in zip(seen.ids.tolist(), seen.points, strict=True):
            if disc >= 0:
                landmarks.setdefault(disc, to_global(poses[-1], point[None])[0])
    order = sorted(landmarks)
    labels = [np.array([order.index(i) if i >= 0 else -1 for i in seen.ids.tolist()], dtype=np.int64)
              for _, seen in building.steps[:count]]  # fmt: skip
    return record.problem(labels), np.array(poses), np.array([landmarks[i] for i in order])


def factor(pose, landmark, point, noise):
    """Cartesian observation as a GTSAM factor: L in the frame of R, minus z."""

    def error(this, values, jacobians):
        A, B = np.zeros((2, 3), order="F"), np.zeros((2, 2), order="F")
        local = values.atPose2(this.keys()[0]).transformTo(values.atPoint2(this.keys()[1]), A, B)
        if jacobians is not None:
            jacobians[0], jacobians[1] = A, B
        return local - point

    return gtsam.CustomFactor(noise, [X(pose), L(landmark)], error)


def by_gtsam(problem, poses, landmarks, cauchy):
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    graph.add(gtsam.NonlinearEqualityPose2(X(0), gtsam.Pose2(*poses[0])))
    for k, (delta, W) in enumerate(zip(problem.deltas, problem.roots, strict=True)):
        noise = gtsam.noiseModel.Gaussian.Information(W.T @ W)
        graph.add(gtsam.BetweenFactorPose2(X(k), X(k + 1), gtsam.Pose2(*delta), noise))
    for k, j, z, W in zip(problem.pose, problem.landmark, problem.points, problem.point_roots, strict=True):
        noise = gtsam.noiseModel.Gaussian.Information(W.T @ W)
        if np.isfinite(cauchy):
            noise = gtsam.noiseModel.Robust.Create(gtsam.noiseModel.mEstimator.Cauchy.Create(cauchy), noise)
        graph.add(factor(int(k), int(j), z, noise))
    for k, pose in enumerate(poses):
        values.insert(X(k), gtsam.Pose2(*pose))
    for j, landmark in enumerate(landmarks):
        values.insert(L(j), landmark)
    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setRelativeErrorTol(1e-12)
    parameters.setAbsoluteErrorTol(1e-12)
    result = gtsam.LevenbergMarquardtOptimizer(graph, values, parameters).optimize()
    return result, gtsam.Marginals(graph, result)


@pytest.mark.parametrize("cauchy", [LEAST_SQUARES, CAUCHY])
def test_same_optimum_and_covariances_as_gtsam(cauchy):
    """Odometry residuals differ in second order (GTSAM's live in the tangent space of SE(2)), hence 1 mm."""
    problem, poses, landmarks = recorded()
    ours = smooth(problem, poses, landmarks, iterations=100, tolerance=1e-8, cauchy=cauchy)
    theirs, marginals = by_gtsam(problem, poses, landmarks, cauchy)
    track = np.array([[p.x(), p.y(), p.theta()] for p in (theirs.atPose2(X(k)) for k in range(len(poses)))])
    np.testing.assert_allclose(ours.poses, track, atol=1e-3)
    np.testing.assert_allclose(
        ours.landmarks, [theirs.atPoint2(L(j)) for j in range(len(landmarks))], atol=1e-3
    )
    for j in (0, len(landmarks) - 1):
        np.testing.assert_allclose(
            ours.covariance(np.array([j])), marginals.marginalCovariance(L(j)), rtol=0.03
        )


def test_one_wild_observation_moves_the_robust_solution_little():
    problem, poses, landmarks = recorded()
    clean = smooth(problem, poses, landmarks)
    problem.points[len(problem.points) // 2] += 3.0
    moved = {c: smooth(problem, poses, landmarks, cauchy=c) for c in (CAUCHY, LEAST_SQUARES)}
    error = {c: np.abs(e.poses - clean.poses).max() for c, e in moved.items()}
    assert error[CAUCHY] < 0.02 < error[LEAST_SQUARES]


def test_merging_two_fragments_adds_their_information():
    """A robot that stands still, to a hair: C = (C₁⁻¹ + C₂⁻¹)⁻¹."""
    still = Problem(
        np.zeros((2, 3)), np.tile(1e6 * np.eye(3), (2, 1, 1)), np.array([1, 1, 2]), np.array([0, 0, 1]),
        np.array([[2.0, 0.0], [2.1, 0.1], [2.0, 0.2]]),
        np.stack([np.diag([10.0, 20.0]), np.diag([10.0, 20.0]), np.diag([5.0, 40.0])]),
    )  # fmt: skip
    apart = smooth(still, np.zeros((3, 3)), np.ones((2, 2)), cauchy=LEAST_SQUARES)
    fields = vars(still) | {"landmark": np.zeros(3, dtype=np.int64)}
    merged = smooth(Problem(**fields), np.zeros((3, 3)), np.ones((1, 2)), cauchy=LEAST_SQUARES)

    def information(estimate: Estimate, j: int):
        return np.linalg.inv(estimate.covariance(np.array([j])))

    total = information(apart, 0) + information(apart, 1)
    np.testing.assert_allclose(information(merged, 0), total, rtol=1e-5, atol=1e-4)
    mean = np.linalg.solve(total, sum(information(apart, j) @ apart.landmarks[j] for j in range(2)))
    np.testing.assert_allclose(merged.landmarks[0], mean, atol=1e-6)


def test_two_discs_of_one_picture_are_never_one():
    fragments = Fragments()
    for fragment, picture in [(0, 0), (1, 0), (2, 5), (3, 9)]:
        fragments.see(fragment, picture)
    assert not fragments.merge(0, 1)
    assert fragments.merge(2, 0) and fragments.merge(3, 2) and not fragments.merge(3, 0)
    assert not fragments.merge(3, 1)  # by way of 0
    used, labels = fragments.labels([np.array([0, 1]), np.array([2, -1]), np.array([3])])
    assert used.tolist() == [0, 1] and [label.tolist() for label in labels] == [[0, 1], [0, -1], [0]]
    assert fragments.sights().tolist() == [3, 1, 3, 3]
