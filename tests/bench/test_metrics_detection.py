"""The detection metric by hand and against brute force."""

from itertools import permutations

import numpy as np
import pytest

from bench.errors import BenchError
from bench.metrics.detection import evaluate, match

ALL = np.array([[1.0, 0.0], [2.0, 1.0], [3.0, -1.0], [4.0, 0.0]])


def test_truth_given_as_result_is_perfect():
    s = evaluate(ALL, ALL, ALL)
    assert (s.visible, s.detected, s.true, s.precision, s.recall) == (4, 4, 4, 1.0, 1.0)
    np.testing.assert_array_equal(s.assigned_ids, [0, 1, 2, 3])


def test_false_missed_and_set_aside():
    found = np.array([[2.05, 1.0], [4.0, 0.1], [6.0, 0.0]])  # visible, below the limit, nothing there
    s = evaluate(found, ALL[:3], ALL)
    assert (s.visible, s.detected, s.true) == (3, 2, 1)
    assert s.precision == 0.5 and s.recall == pytest.approx(1 / 3)
    np.testing.assert_array_equal(s.assigned_ids, [1, 3, -1])


def test_second_detection_of_a_disc_is_false():
    s = evaluate([[1.0, 0.05], [1.0, -0.01]], ALL[:1], ALL)
    assert (s.detected, s.true, s.precision) == (2, 1, 0.5)
    np.testing.assert_array_equal(s.assigned_ids, [-1, 0])


def test_nothing_found_and_nothing_to_find():
    s = evaluate([], ALL, ALL)
    assert s.recall == 0.0 and np.isnan(s.precision)
    s = evaluate([[9.0, 9.0]], [], ALL)
    assert s.precision == 0.0 and np.isnan(s.recall)
    s = evaluate([], [], [])
    assert np.isnan(s.precision) and np.isnan(s.recall)


def test_number_of_pairs_comes_before_their_distance():
    # Greedy would take the short middle pair and leave the outer two alone.
    a, b = np.array([[0.0, 0.0], [0.12, 0.0]]), np.array([[0.11, 0.0], [0.22, 0.0]])
    np.testing.assert_array_equal(match(a, b, 0.15), [[0, 0], [1, 1]])


def test_match_against_brute_force():
    rng = np.random.default_rng(11)
    for _ in range(50):
        a, b = rng.uniform(0, 0.5, (4, 2)), rng.uniform(0, 0.5, (5, 2))
        distance = np.linalg.norm(a[:, None] - b[None], axis=2)
        best = (0, 0.0)
        for columns in permutations(range(5), 4):
            d = distance[np.arange(4), columns]
            inside = d <= 0.15
            best = max(best, (int(inside.sum()), -float(d[inside].sum())))
        pairs = match(a, b, 0.15)
        assert len(pairs) == best[0]
        assert distance[pairs[:, 0], pairs[:, 1]].sum() == pytest.approx(-best[1])


def test_malformed_input_raises():
    with pytest.raises(BenchError, match="detections"):
        evaluate([[1.0, 2.0, 3.0]], ALL, ALL)
    with pytest.raises(BenchError, match="detections"):
        evaluate([[np.nan, 2.0]], ALL, ALL)
    with pytest.raises(BenchError, match="one of all"):
        evaluate([], [[7.0, 7.0]], ALL)
