import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from vslam.association import Annotated, Icnn, associations, squared_distances
from vslam.backends.ekf import Ekf
from vslam.errors import VslamError
from vslam.frame import Observations, Odometry
from vslam.observation import observation_models
from vslam.slam_backend import DISCARDED, NEW

GATE, NEW_GATE = 0.99, 0.9999
SIGMA_M = 0.1
S = SIGMA_M**2 * np.eye(2)


def seen(points, ids=None):
    points = np.array(points, dtype=np.float64).reshape(-1, 2)
    ids = np.full(len(points), -1) if ids is None else np.array(ids)
    return Observations(points, np.tile(S, (len(points), 1, 1)), ids)


def mapped(points, form="cartesian"):
    """A filter that stands surely at the origin and has seen these landmarks once: P_LL = S."""
    ekf = Ekf(observation_models.get(form)())
    ekf.update(seen(points), np.full(len(points), NEW))
    return ekf


def at(distance):
    """Metres from a once-seen landmark at this squared Mahalanobis distance, as P_LL + S = 2 S."""
    return SIGMA_M * np.sqrt(2.0 * distance)


def icnn():
    return Icnn(GATE, NEW_GATE)


def test_inside_the_gate_matches_between_the_gates_is_nothing_beyond_is_new():
    backend = mapped([[2.0, 0.0]])
    match, new = chi2.ppf([GATE, NEW_GATE], df=2)
    for distance, expected in [
        (0.0, 0),
        (0.99 * match, 0),
        (1.01 * match, DISCARDED),
        (0.99 * new, DISCARDED),
        (1.01 * new, NEW),
        (100.0 * new, NEW),
    ]:
        hypothesis = icnn().associate(backend, seen([[2.0, at(distance)]]))
        assert hypothesis.tolist() == [expected], distance


def test_between_two_landmarks_the_nearer_one_wins():
    backend = mapped([[2.0, 0.0], [2.0, 0.4]])
    assert icnn().associate(backend, seen([[2.0, 0.19]])).tolist() == [0]
    assert icnn().associate(backend, seen([[2.0, 0.21]])).tolist() == [1]


def test_two_observations_want_one_landmark():
    """The nearer takes it; the other is no second sight and no new landmark."""
    backend = mapped([[2.0, 0.0]])
    assert icnn().associate(backend, seen([[2.0, 0.2], [2.0, 0.05]])).tolist() == [DISCARDED, 0]


def test_the_loser_of_a_landmark_takes_the_next_compatible_one():
    """Ambiguous: both observations are nearest to the same landmark, and another one is near."""
    backend = mapped([[2.0, 0.0], [2.0, 0.4]])
    assert icnn().associate(backend, seen([[2.0, 0.02], [2.0, 0.15]])).tolist() == [0, 1]


def test_nearest_is_in_sigmas_not_in_metres():
    ekf = mapped([[2.0, 0.0]])
    vague = Observations(np.array([[2.0, 1.0]]), 0.25 * np.eye(2)[None], np.array([-1]))
    ekf.update(vague, np.array([NEW]))
    # 0.42 m from the sure landmark is beyond its gate; 0.58 m from the vague one is well inside.
    assert icnn().associate(ekf, seen([[2.0, 0.45]])).tolist() == [1]


def test_everything_is_new_on_an_empty_map_and_nothing_is_nothing():
    assert icnn().associate(mapped(np.zeros((0, 2))), seen([[1.0, 0.0], [1.0, 0.05]])).tolist() == [NEW, NEW]
    assert icnn().associate(mapped([[1.0, 0.0]]), Observations.none()).tolist() == []


@pytest.mark.parametrize("form", ["cartesian", "range_bearing"])
def test_distances_are_those_of_the_whole_covariance(form):
    generator = np.random.default_rng(11)
    model = observation_models.get(form)()
    ekf = mapped(generator.uniform(1.0, 4.0, (40, 2)), form)
    ekf.predict(Odometry(np.array([0.3, 0.1, 0.2]), np.diag([0.02, 0.02, 0.01])))
    ekf.update(seen(generator.uniform(1.0, 4.0, (3, 2))), np.array([0, 1, 2]))
    observations = seen(generator.uniform(1.0, 4.0, (5, 2)))
    z, R = model.measure(observations)
    H_R, H_L = model.h_jacobians(ekf.pose, ekf.landmarks)
    expected = np.empty((5, 40))
    for j in range(40):
        H = np.zeros((2, 83))
        H[:, :3], H[:, 3 + 2 * j : 5 + 2 * j] = H_R[j], H_L[j]
        for i in range(5):
            Z = model.innovation(z[i], model.h(ekf.pose, ekf.landmarks)[j])
            expected[i, j] = Z @ np.linalg.inv(H @ ekf.covariance @ H.T + R[i]) @ Z
    np.testing.assert_allclose(squared_distances(ekf, observations), expected, rtol=1e-9)


@given(st.permutations(range(6)), st.integers(0, 20))
def test_the_order_of_observations_does_not_matter(order, seed):
    generator = np.random.default_rng(seed)
    backend = mapped(generator.uniform(0.5, 2.5, (12, 2)))
    points = generator.uniform(0.5, 2.5, (6, 2))
    plain = icnn().associate(backend, seen(points))
    np.testing.assert_array_equal(icnn().associate(backend, seen(points[order])), plain[order])
    taken = plain[plain >= 0]
    assert len(set(taken.tolist())) == len(taken)


def test_annotated_follows_the_ids():
    backend, annotated = mapped(np.zeros((0, 2))), Annotated(GATE, NEW_GATE)
    for ids, expected, numbers in [
        ([7, -1, 3], [NEW, DISCARDED, NEW], [0, DISCARDED, 1]),
        ([3, 9, 7], [1, NEW, 0], [1, 2, 0]),
        ([], [], []),
        ([9], [2], [2]),
    ]:
        picture = seen(1.0 + np.arange(2 * len(ids)).reshape(-1, 2), ids)
        hypothesis = annotated.associate(backend, picture)
        assert hypothesis.tolist() == expected
        assert backend.update(picture, hypothesis).tolist() == numbers


def test_an_id_twice_in_a_picture_is_refused():
    with pytest.raises(VslamError, match="id 4 occurs twice"):
        Annotated(GATE, NEW_GATE).associate(mapped([[1.0, 1.0]]), seen([[1.0, 0.0], [2.0, 0.0]], [4, 4]))


def test_names():
    assert {"annotated", "icnn"} <= set(associations.names())
    with pytest.raises(VslamError, match="registered twice"):
        associations.register("icnn")(Icnn)
