"""What is merged, and what is put off: significance, agreement with the drive, rivals."""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from vslam.loop_closing.closer import Bounds, closures
from vslam.loop_closing.smoother import Estimate

BOUNDS = Bounds(0.9999)


def ask(query, reference, sigma_m):
    """Two maps whose landmarks are known to ``sigma_m`` each, independently; no pose but the start."""
    landmarks = np.vstack([query, reference])
    factor = splu(sp.eye(2 * len(landmarks), format="csc") / sigma_m**2)
    estimate = Estimate(np.zeros((1, 3)), landmarks, 0.0, factor)
    return closures(estimate, np.arange(len(query)), np.arange(len(query), len(landmarks)), BOUNDS)


def scatter():
    generator = np.random.default_rng(8)
    cells = np.stack(np.meshgrid(np.arange(12.0), np.arange(12.0)), axis=-1).reshape(-1, 2)
    return cells + generator.uniform(-0.3, 0.3, cells.shape)


LATTICE = np.stack(np.meshgrid(np.arange(12.0), np.arange(12.0)), axis=-1).reshape(-1, 2)


def middle(points):
    return points[((points > 3.5) & (points < 7.5)).all(axis=1)]


def test_one_place_that_fits_is_merged_disc_by_disc():
    world = scatter()
    answer = ask(middle(world) + np.array([0.7, -0.4]), world, 2.0)
    assert not answer.deferred and len(answer.pairs) == len(middle(world))
    landmarks = np.vstack([middle(world), world])
    assert all(np.array_equal(landmarks[a], landmarks[b]) for a, b in answer.pairs)


def test_a_place_that_repeats_itself_is_put_off():
    """Shifted by a period the lattice fits as well, and the drive, unsure by metres, does not tell which."""
    answer = ask(middle(LATTICE) + np.array([0.4, -0.3]), LATTICE, 2.0)
    assert answer.deferred and answer.pairs == []


def test_it_is_merged_once_the_drive_tells_the_periods_apart():
    answer = ask(middle(LATTICE) + np.array([0.1, -0.05]), LATTICE, 0.1)
    assert not answer.deferred and len(answer.pairs) == 16


@pytest.mark.parametrize("sigma_m, merged", [(2.0, True), (0.1, False)])
def test_an_alignment_that_the_drive_excludes_is_put_off(sigma_m, merged):
    world = scatter()
    answer = ask(middle(world) + np.array([1.4, 0.8]), world, sigma_m)
    assert (len(answer.pairs) > 0) == merged and answer.deferred == (not merged)


def test_nothing_known_is_nothing_put_off():
    generator = np.random.default_rng(1)
    answer = ask(generator.uniform(0, 5, (12, 2)) + 40.0, scatter(), 50.0)
    assert answer.pairs == [] and not answer.deferred
