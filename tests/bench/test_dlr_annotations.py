"""How far the log's reference track can be trusted: it bends round rows that carry another disc's id."""

from dataclasses import replace

import numpy as np

from bench.metrics import trajectory
from bench.replay import true_landmarks
from bench.sequences.dlr import load
from vslam.loop_closing.record import Record
from vslam.loop_closing.smoother import LEAST_SQUARES, Problem, smooth


def rms_m(estimate, log):
    return trajectory.evaluate(estimate.poses[1:], log.truth[1:]).rmse_m


def mahalanobis(problem: Problem, estimate):
    """Squared distances of observations (m,) and of odometry increments (n,), written out."""
    c, s = np.cos(estimate.poses[:, 2]), np.sin(estimate.poses[:, 2])

    def local(pose, points):
        x, y = (points - estimate.poses[pose, :2]).T
        return np.column_stack([c[pose] * x + s[pose] * y, c[pose] * y - s[pose] * x])

    sight = local(problem.pose, estimate.landmarks[problem.landmark]) - problem.points
    before = np.arange(len(problem.deltas))
    turn = np.diff(estimate.poses[:, 2])[:, None]
    motion = np.hstack([local(before, estimate.poses[1:, :2]), turn]) - problem.deltas
    return tuple(
        ((W @ r[..., None]) ** 2).sum(axis=(1, 2))
        for W, r in ((problem.point_roots, sight), (problem.roots, motion))
    )


def test_the_reference_track_bends_round_few_contradictory_rows(dlr_folder):
    log = load(dlr_folder)
    record, labels = Record(), list(true_landmarks(log))
    for (odometry, seen), label in zip(log.steps, labels, strict=True):
        record.add(odometry, seen, label)
    problem = record.problem(labels)
    all_rows = smooth(problem, log.truth, log.landmark_positions, tolerance=1e-3, cauchy=LEAST_SQUARES)
    assert rms_m(all_rows, log) < 0.03
    robust = smooth(problem, log.truth, log.landmark_positions, iterations=40, tolerance=1e-3)
    good = mahalanobis(problem, robust)[0] < 30.0
    assert 60 < (~good).sum() < 100
    used, landmark = np.unique(problem.landmark[good], return_inverse=True)
    fewer = replace(
        problem,
        pose=problem.pose[good],
        landmark=landmark,
        points=problem.points[good],
        point_roots=problem.point_roots[good],
    )
    without = smooth(fewer, robust.poses, robust.landmarks[used], tolerance=1e-3, cauchy=LEAST_SQUARES)
    assert 0.25 < rms_m(without, log) < 0.35
    # Three degrees of freedom: the odometry contradicts the reference track, and not the other one.
    assert mahalanobis(problem, all_rows)[1].max() > 65.0
    assert mahalanobis(fewer, without)[1].max() < 30.0
