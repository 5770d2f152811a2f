"""Branch and bound against all hypotheses there are, and what the cross-covariances are for."""

from itertools import product

import numpy as np
import pytest
from scipy.stats import chi2

from vslam.association import Icnn, squared_distances
from vslam.backends.ekf import Ekf
from vslam.frame import Observations, Odometry
from vslam.jcbb import Jcbb
from vslam.joint_compatibility import BUDGET, branch_and_bound, joint_bounds
from vslam.observation import observation_models
from vslam.slam_backend import DISCARDED, NEW

GATE, NEW_GATE = 0.99, 0.9999


def random_case(seed):
    """Up to four observations of up to five landmarks, so close to each other that many hypotheses pass."""
    generator = np.random.default_rng(seed)
    n, m = generator.integers(1, 5), generator.integers(1, 6)
    A = generator.normal(size=(2 * m, 2 * m + 2)) * 0.3
    projected = A @ A.T
    S = np.tile(0.05 * np.eye(2), (n, 1, 1))
    places = generator.uniform(0.0, 2.5, (m, 2))
    shift = generator.normal(size=2) * 0.5
    z = places[generator.integers(0, m, n)] + shift + generator.normal(size=(n, 2)) * 0.3
    return z[:, None] - places[None], projected, S


def squared(pairs, Z, projected, S):
    """D² of a hypothesis from scratch."""
    i, j = map(list, zip(*pairs, strict=True))
    rows = np.array([[2 * b, 2 * b + 1] for b in j]).ravel()
    C = projected[np.ix_(rows, rows)].copy()
    for k, a in enumerate(i):
        C[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] += S[a]
    v = Z[i, j].ravel()
    return v @ np.linalg.solve(C, v)


def brute_force(Z, projected, S, bounds):
    """All hypotheses that are jointly compatible at every level of the tree: most pairings, then least D²."""
    n, m = Z.shape[:2]
    best = ((0, 0.0), [-1] * n)
    for hypothesis in product(range(-1, m), repeat=n):
        pairs = [(i, j) for i, j in enumerate(hypothesis) if j >= 0]
        if len({j for _, j in pairs}) < len(pairs) or not pairs:
            continue
        alone = all(squared([pair], Z, projected, S) <= bounds[1] for pair in pairs)
        if not alone or any(
            squared(pairs[:k], Z, projected, S) > bounds[k] for k in range(1, len(pairs) + 1)
        ):
            continue
        score = (len(pairs), -squared(pairs, Z, projected, S))
        if best[0][0] == 0 or score > best[0]:
            best = (score, list(hypothesis))
    return best[1]


def search(Z, projected, S, budget=BUDGET):
    n, m = Z.shape[:2]
    distances = np.array([[squared([(i, j)], Z, projected, S) for j in range(m)] for i in range(n)])
    bounds = joint_bounds(GATE, n)
    return branch_and_bound(Z, projected, S, distances, distances <= bounds[1], bounds, budget)


@pytest.mark.parametrize("seed", range(60))
def test_finds_what_brute_force_finds(seed):
    Z, projected, S = random_case(seed)
    assert search(Z, projected, S)[0].tolist() == brute_force(Z, projected, S, joint_bounds(GATE, len(Z)))


def test_work_is_bounded_and_what_was_found_in_time_stands():
    Z, projected, S = np.zeros((9, 9, 2)), 0.1 * np.eye(18), np.tile(np.eye(2), (9, 1, 1))
    whole, tests = search(Z, projected, S, budget=30)
    assert tests == 30 and (whole >= 0).sum() == len(set(whole[whole >= 0].tolist())) == 9
    cut, tests = search(Z, projected, S, budget=5)
    assert tests == 5 and (cut >= 0).sum() == 5


def backend_with(landmarks, sideways_m, form="cartesian"):
    """Two metres before a row of landmarks that were seen sharply; then a slip sideways of unknown size."""
    ekf = Ekf(observation_models.get(form)())
    ekf.update(seen(landmarks), np.full(len(landmarks), NEW))
    ekf.predict(Odometry(np.zeros(3), np.diag([1e-6, sideways_m**2, 1e-8])))
    return ekf


def seen(points, sigma=0.03):
    points = np.array(points, dtype=np.float64).reshape(-1, 2)
    return Observations(points, np.tile(sigma**2 * np.eye(2), (len(points), 1, 1)), np.full(len(points), -1))


@pytest.mark.parametrize("form", ["cartesian", "range_bearing"])
def test_the_slip_is_common_to_all_observations(form):
    """Nearest neighbours pair landmarks crosswise; one slip explains all three observations at once."""
    row = np.array([[2.0, 0.0], [2.0, 1.0], [2.3, 1.8]])
    backend, slipped = backend_with(row, 0.5, form), seen(row + np.array([0.0, 0.6]))
    assert Icnn(GATE, NEW_GATE).associate(backend, slipped).tolist() != [0, 1, 2]
    assert Jcbb(GATE, NEW_GATE).associate(backend, slipped).tolist() == [0, 1, 2]


def test_an_observation_that_fits_alone_but_not_with_the_others_is_discarded():
    row = np.array([[2.0, 0.0], [2.0, 3.0], [2.0, 6.0]])
    backend = backend_with(row, 0.5)
    spoilt = seen(row + np.array([[0.0, 0.6], [0.0, 0.6], [0.0, -0.6]]))
    assert (squared_distances(backend, spoilt).diagonal() < chi2.ppf(GATE, 2)).all()
    assert Jcbb(GATE, NEW_GATE).associate(backend, spoilt).tolist() == [0, 1, DISCARDED]


def test_far_from_all_is_new_and_an_empty_map_or_picture_is_no_case():
    backend = backend_with([[2.0, 0.0]], 0.1)
    assert Jcbb(GATE, NEW_GATE).associate(backend, seen([[2.0, 0.0], [4.0, 3.0]])).tolist() == [0, NEW]
    assert Jcbb(GATE, NEW_GATE).associate(backend, Observations.none()).tolist() == []
    empty = Ekf(observation_models.get("cartesian")())
    assert Jcbb(GATE, NEW_GATE).associate(empty, seen([[1.0, 0.0]])).tolist() == [NEW]
