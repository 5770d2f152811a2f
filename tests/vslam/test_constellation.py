"""Places known by their discs: found where they are, not where they are not, and several where a
building repeats."""

import numpy as np
import pytest

from vslam.loop_closing.closer import LOG_NFA
from vslam.loop_closing.constellation import density, in_place, recognise

SIGMA_M = 0.03


def scatter(generator, count, size):
    """Points no closer than 0.5 m to each other."""
    kept = []
    while len(kept) < count:
        point = generator.uniform(0, size, 2)
        if not kept or np.hypot(*(np.array(kept) - point).T).min() > 0.5:
            kept.append(point)
    return np.array(kept)


def turned(points, angle, shift, mirror=False):
    c, s = np.cos(angle), np.sin(angle)
    points = points * ([1, -1] if mirror else [1, 1])
    return points @ np.array([[c, s], [-s, c]]) + shift


def ask(query, reference, limit=0.0):
    return recognise(query, reference, density(reference), limit)


@pytest.mark.parametrize("seed", range(6))
def test_finds_twelve_discs_among_three_hundred_whatever_turn_and_shift(seed):
    generator = np.random.default_rng(seed)
    world = scatter(generator, 300, 26.0)
    centre = generator.uniform(5, 21, 2)
    chosen = np.argsort(np.hypot(*(world - centre).T))[:12]
    angle, shift = generator.uniform(-3, 3), generator.uniform(-9, 9, 2)
    query = turned(world[chosen], angle, shift) + generator.normal(size=(12, 2)) * SIGMA_M
    query = np.vstack([query, query.mean(axis=0) + generator.uniform(-3, 3, (3, 2))])  # and three false ones
    found = ask(query, world, LOG_NFA)
    assert len(found) == 1
    best = found[0]
    assert (chosen[best.query[best.query < 12]] == best.reference[best.query < 12]).all()
    assert (best.query < 12).sum() >= 11
    assert np.angle(np.exp(1j * (best.turn + angle))) == pytest.approx(0.0, abs=0.03)


@pytest.mark.parametrize("seed", range(6))
def test_a_mirrored_place_is_another_place(seed):
    generator = np.random.default_rng(seed)
    world = scatter(generator, 40, 10.0)
    query = turned(world[:12], 0.4, (1.0, 2.0), mirror=True)
    assert ask(turned(world[:12], 0.4, (1.0, 2.0)), world, LOG_NFA)
    assert not ask(query, world, LOG_NFA)


def test_the_number_of_false_alarms_is_one():
    """Unrelated scatters: alignments with NFA ≤ 0.1 come at most 0.1 times a query, by definition."""
    generator = np.random.default_rng(5)
    alarms = 0
    for _ in range(60):
        world, query = generator.uniform(0, 20, (160, 2)), generator.uniform(0, 6, (12, 2))
        alarms += len(ask(query, world, -1.0))
    assert alarms <= 6 + 3 * np.sqrt(6)


def test_a_lattice_fits_in_many_ways():
    lattice = np.stack(np.meshgrid(np.arange(12.0), np.arange(12.0)), axis=-1).reshape(-1, 2)
    found = ask(lattice[(lattice < 4).all(axis=1)] + 0.01, lattice, LOG_NFA)
    assert len(found) > 4
    # None is so much better than the next that it would be believed.
    assert found[1].log_nfa < 0.5 * found[0].log_nfa


def test_in_place_needs_fewer_discs_than_a_search():
    generator = np.random.default_rng(2)
    world = scatter(generator, 300, 26.0)
    near = np.argsort(np.hypot(*(world - 13.0).T))[:5]
    query = world[near] + generator.normal(size=(5, 2)) * SIGMA_M + [0.05, 0.0]
    still = in_place(query, world, density(world))
    assert still is not None and still.log_nfa < LOG_NFA
    assert (near[still.query] == still.reference).all() and len(still.query) == 5
    assert not ask(query, world, LOG_NFA)


def test_density_of_a_lattice_and_of_a_scatter():
    lattice = np.stack(np.meshgrid(np.arange(60.0), np.arange(60.0)), axis=-1).reshape(-1, 2) * 0.5
    assert density(lattice) == pytest.approx(4.0, rel=0.1)
    # Clark & Evans: 1 / (1 − e^(−π/4)) times too large for scattered points.
    scattered = np.random.default_rng(0).uniform(0, 40, (3200, 2))
    assert density(scattered) == pytest.approx(2.0 / 0.544, rel=0.1)


def test_too_few_discs_are_no_constellation():
    few = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]])
    assert ask(few, few) == [] and ask(np.zeros((0, 2)), few) == []
    assert in_place(np.zeros((0, 2)), few, 1.0) is None and in_place(few, few[:1], 1.0) is None
