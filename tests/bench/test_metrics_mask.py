"""Mask scores: by hand, against scikit-learn, and in the empty cases."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn import metrics as sklearn

from bench.errors import BenchError
from bench.metrics.mask import MaskScores, evaluate


def flat(score: float, shape: tuple[int, int] = (4, 5)) -> np.ndarray:
    return np.full(shape, score, dtype=np.float32)


def row(*values: float) -> np.ndarray:
    return np.array([values], dtype=np.float32)


def bits(*values: int) -> np.ndarray:
    return np.array([values], dtype=bool)


def test_by_hand() -> None:
    # TP 2, FP 1, FN 1, TN 4. Thresholds from the top, each finds a third more where a true pixel lies:
    # 1.0: 1 of 1 true; 0.8: nothing more; 0.6: 2 of 3; 0.2: 3 of 6; 0.0: nothing more
    predicted = bits(1, 1, 1, 0, 0, 0, 0, 0)
    true = bits(1, 0, 1, 1, 0, 0, 0, 0)
    score = row(1.0, 0.8, 0.6, 0.2, 0.2, 0.2, 0.0, 0.0)
    found = evaluate(predicted, true, score)
    assert found.iou == pytest.approx(2 / 4)
    assert found.f1 == pytest.approx(4 / 6)
    assert found.precision == pytest.approx(2 / 3)
    assert found.recall == pytest.approx(2 / 3)
    assert found.ber == pytest.approx((1 / 3 + 1 / 5) / 2)
    assert found.ap == pytest.approx((1 + 2 / 3 + 1 / 2) / 3)
    assert found.masked_share == pytest.approx(3 / 8)
    assert found.true_share == pytest.approx(3 / 8)


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    height=st.integers(1, 20),
    width=st.integers(1, 20),
    share=st.floats(0.02, 0.98),
    levels=st.sampled_from([2, 5, 256]),
)
def test_agrees_with_scikit_learn(seed: int, height: int, width: int, share: float, levels: int) -> None:
    rng = np.random.default_rng(seed)
    true = rng.random((height, width)) < share
    true[0, 0] = True
    predicted = rng.random((height, width)) < share
    predicted[-1, -1] = True
    score = (rng.integers(0, levels, (height, width)) / 255).astype(np.float32)
    found = evaluate(predicted, true, score)
    y, z = true.ravel(), predicted.ravel()
    assert found.iou == pytest.approx(sklearn.jaccard_score(y, z), abs=1e-12)
    assert found.f1 == pytest.approx(sklearn.f1_score(y, z), abs=1e-12)
    assert found.precision == pytest.approx(sklearn.precision_score(y, z), abs=1e-12)
    assert found.recall == pytest.approx(sklearn.recall_score(y, z), abs=1e-12)
    assert found.ap == pytest.approx(sklearn.average_precision_score(y, score.ravel()), abs=1e-12)
    if not y.all():
        assert found.ber == pytest.approx(1 - sklearn.balanced_accuracy_score(y, z), abs=1e-12)


def test_the_truth_scores_one() -> None:
    true = np.random.default_rng(0).random((12, 16)) < 0.3
    found = evaluate(true, true, true.astype(np.float32))
    share = true.mean()
    assert found == MaskScores(1.0, 1.0, 1.0, 1.0, 0.0, 1.0, pytest.approx(share), pytest.approx(share))


def test_doing_nothing_where_there_is_light() -> None:
    true = np.zeros((4, 5), dtype=bool)
    true[0] = True
    found = evaluate(np.zeros_like(true), true, flat(0.0))
    assert (found.iou, found.f1, found.recall, found.ber, found.masked_share) == (0.0, 0.0, 0.0, 0.5, 0.0)
    assert math.isnan(found.precision)
    assert found.ap == pytest.approx(0.25)  # what chance gives: the true share


@pytest.mark.parametrize("alarms", [0, 6])
def test_without_light_only_false_alarms_count(alarms: int) -> None:
    true = np.zeros((4, 5), dtype=bool)
    predicted = np.zeros(20, dtype=bool)
    predicted[:alarms] = True
    found = evaluate(predicted.reshape(4, 5), true, flat(0.5))
    assert all(math.isnan(value) for value in (found.iou, found.f1, found.recall, found.ap))
    assert found.ber == pytest.approx(alarms / 20)
    assert found.masked_share == pytest.approx(alarms / 20)
    assert found.precision == 0.0 if alarms else math.isnan(found.precision)


def test_light_everywhere() -> None:
    true = np.ones((4, 5), dtype=bool)
    predicted = true.copy()
    predicted[0] = False
    found = evaluate(predicted, true, flat(0.5))
    assert found.recall == found.iou == pytest.approx(0.75)
    assert found.ber == pytest.approx(0.25)  # the error rate of the only class
    assert found.ap == 1.0


def test_the_mean_over_frames_is_over_the_same_frames_for_every_filter() -> None:
    rng = np.random.default_rng(1)
    truths = [rng.random((6, 6)) < share for share in (0.0, 0.3, 0.6)]
    for predicted in (np.zeros((6, 6), dtype=bool), np.ones((6, 6), dtype=bool), rng.random((6, 6)) < 0.5):
        scores = [evaluate(predicted, true, flat(0.5, (6, 6))) for true in truths]
        for name in ("iou", "f1", "recall", "ap"):
            assert [math.isnan(getattr(s, name)) for s in scores] == [True, False, False]


def test_memory_layout_does_not_matter() -> None:
    rng = np.random.default_rng(2)
    true, predicted = rng.random((8, 9)) < 0.4, rng.random((8, 9)) < 0.4
    score = (rng.integers(0, 256, (8, 9)) / 255).astype(np.float32)
    turned = evaluate(predicted[::-1, ::2], np.asfortranarray(true[::-1, ::2]), score[::-1, ::2])
    assert turned == evaluate(predicted[:, ::2].copy(), true[:, ::2].copy(), score[:, ::2].copy())


@pytest.mark.parametrize(
    ("predicted", "true", "score", "message"),
    [
        (np.zeros((4, 5), np.uint8), np.zeros((4, 5), bool), flat(0), "predicted"),
        (np.zeros((4, 5), bool), np.zeros((4, 5, 1), bool), flat(0), "true"),
        (np.zeros((0, 5), bool), np.zeros((0, 5), bool), flat(0, (0, 5)), "predicted"),
        (np.zeros((4, 5), bool), np.zeros((5, 4), bool), flat(0), "shapes differ"),
        (np.zeros((4, 5), bool), np.zeros((4, 5), bool), flat(0, (5, 4)), "shapes differ"),
        (np.zeros((4, 5), bool), np.zeros((4, 5), bool), flat(1.5), "0…1"),
        (np.zeros((4, 5), bool), np.zeros((4, 5), bool), flat(-0.1), "0…1"),
        (np.zeros((4, 5), bool), np.zeros((4, 5), bool), flat(math.nan), "0…1"),
    ],
)
def test_malformed_input_is_refused(
    predicted: np.ndarray, true: np.ndarray, score: np.ndarray, message: str
) -> None:
    with pytest.raises(BenchError, match=message) as caught:
        evaluate(predicted, true, score)
    assert "\n" not in str(caught.value)
