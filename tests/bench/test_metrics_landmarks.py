import numpy as np
import pytest

from bench.errors import BenchError
from bench.metrics import landmarks
from bench.schema import RUN_COLUMNS

TRUE = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])

# A run over four true landmarks. Landmark 3 is never seen.
SEEN = ([0, 1], [0, 1, -1], [1, 2, -1], [0, 2, 1])
# Estimates: 0 is true 0; 1 is true 1; 2 is a false detection; 3 is true 2; 4 is true 1 once more.
MATCHES = ([0, 1], [0, 1, 2], [4, 3, 2], [1, 3, -1])
#           new       right, right, new false    duplicate, new, false again   0 taken for 1, right, discarded
ESTIMATED = np.array([[0.3, 0.4], [1.0, 0.0], [9.0, 9.0], [2.0, 0.5], [7.0, 7.0]])


def test_golden_values():
    scores = landmarks.evaluate(ESTIMATED, MATCHES, SEEN, TRUE)
    assert (scores.landmarks_total, scores.landmarks_mapped, scores.landmarks_duplicated) == (4, 3, 1)
    # The first estimates: 0.5 m, 0 and 0.5 m off; the duplicate far away does not count.
    assert scores.landmark_rmse_m == pytest.approx(np.sqrt(0.5 / 3), abs=1e-12)
    # Pairings that founded nothing: right 0, right 1, wrong 0 as 1, right 2. False on false is neither.
    assert scores.association_precision == pytest.approx(3 / 4)
    # Observations of what was in the map: 0, 1 | 1 (duplicated) | 0 (wrong), 2, 1 (discarded).
    assert scores.association_recall == pytest.approx(3 / 6)


def test_a_false_detection_given_to_a_true_landmark_is_wrong_unless_nobody_knows():
    arguments = [[0.0, 0.0]], ([0], [0], [0]), ([0], [0], [-1]), TRUE
    assert landmarks.evaluate(*arguments).association_precision == pytest.approx(1 / 2)
    assert landmarks.evaluate(*arguments, unlabelled=True).association_precision == 1.0


def test_a_landmark_of_false_detections_is_false_unless_nobody_knows():
    arguments = [[0.0, 0.0]], ([0], [0], [0]), ([-1], [-1], [2]), TRUE
    assert landmarks.evaluate(*arguments).landmarks_mapped == 0
    assert landmarks.evaluate(*arguments).association_precision == 0.0
    assert landmarks.evaluate(*arguments, unlabelled=True).landmarks_mapped == 1


def test_the_majority_says_what_a_landmark_is_and_the_first_sight_breaks_ties():
    one = np.zeros(1, dtype=np.int64)

    def identity(shown):
        shown = np.array(shown)
        return landmarks.identities(landmarks.Pairings(np.arange(len(shown)), shown, 0 * shown), 1)[0]

    assert identity([2, 3, 3]) == 3
    assert identity([2, 3]) == 2
    assert identity([3, 2, 2, 3]) == 3
    assert landmarks.identities(landmarks.Pairings(one, one - 1, one), 1, unlabelled=True)[0] == -1


def test_the_truth_scores_perfectly():
    seen = ([0, 1], [1, 2], [2, 3], [0, 1, 2, 3])
    scores = landmarks.evaluate(TRUE, seen, seen, TRUE)
    assert vars(scores) == {
        "landmarks_total": 4,
        "landmarks_mapped": 4,
        "landmarks_duplicated": 0,
        "landmark_rmse_m": 0.0,
        "association_precision": 1.0,
        "association_recall": 1.0,
    }
    assert set(vars(scores)) <= set(RUN_COLUMNS)


def test_an_empty_map_has_no_error_and_no_precision():
    scores = landmarks.evaluate(np.zeros((0, 2)), ([-1], [], [-1]), ([0], [], [-1]), TRUE)
    assert (scores.landmarks_total, scores.landmarks_mapped, scores.landmarks_duplicated) == (4, 0, 0)
    assert np.isnan([scores.landmark_rmse_m, scores.association_precision, scores.association_recall]).all()


def test_nothing_seen_nothing_scored():
    scores = landmarks.evaluate(np.zeros((0, 2)), (), (), TRUE)
    assert scores.landmarks_mapped == 0 and np.isnan(scores.association_recall)


def test_the_table_has_every_landmark():
    table = landmarks.table(ESTIMATED, MATCHES, SEEN, TRUE)
    nan = np.nan
    expected = [
        [0, 0, 0, 0.3, 0.4],
        [1, 1, 0, 1.0, 0.0],
        [1, 1, 0, 7.0, 7.0],
        [2, 2, 0, 2.0, 0.5],
        [3, 3, 0, nan, nan],
        [-1, nan, nan, 9.0, 9.0],
    ]
    np.testing.assert_array_equal(table, expected)


@pytest.mark.parametrize(
    ("estimated", "matches", "seen", "message"),
    [
        (ESTIMATED, MATCHES[:3], SEEN, "same observations"),
        (ESTIMATED, ([0], *MATCHES[1:]), SEEN, "same observations"),
        (ESTIMATED[:4], MATCHES, SEEN, "a match names a landmark outside -1 … 3"),
        (ESTIMATED, MATCHES, ([0, 4], *SEEN[1:]), "a true landmark names a landmark outside"),
        (np.vstack([ESTIMATED, ESTIMATED]), MATCHES, SEEN, "has no observation"),
        (ESTIMATED * np.nan, MATCHES, SEEN, "must be finite"),
    ],
)
def test_malformed_input_raises(estimated, matches, seen, message):
    with pytest.raises(BenchError, match=message):
        landmarks.evaluate(estimated, matches, seen, TRUE)
