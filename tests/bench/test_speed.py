"""``bench speed``: its shape on a tiny configuration, and that both sides do the same work. No test times."""

import json
import pickle

import numpy as np
import pytest

from bench import cli
from bench.filter_times import sample
from bench.speed import (
    astar,
    basis,
    generate,
    numpy_seed,
    numpy_sensor,
    registry,
    relight_expose,
    stage,
    sweep,
)
from bench.speed.measure import copy_bandwidth, measure
from bench.speed.model import Benchmark, Configuration, Sides, summarise
from renderers.sensor import Sensor
from renderers.truth import record
from vslam.astar import GridPath, shortest_path
from vslam.filters import create

TINY = Configuration(
    width=32,
    height=24,
    poses=2,
    illuminations=8,
    laps=0.2,
    rounds=2,
    processes=1,
    fast_bake=True,
    slam_steps=60,
)


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    from dataclasses import replace

    return replace(TINY, cache=tmp_path_factory.mktemp("baked"))


@pytest.mark.parametrize("name", list(registry.benchmarks()))
def test_each_benchmark_measures_both_sides(tiny, name):
    result = measure(registry.benchmarks()[name], tiny)
    assert result.name == name
    assert result.ours > 0
    assert result.baseline > 0
    assert result.ratio > 0
    assert set(result.record()) == {"name", "ours", "baseline", "ratio", "unit"}
    assert result.note


def test_the_command_prints_json_and_nothing_else(monkeypatch, capsys, tmp_path):
    def of_nothing(configuration):
        from contextlib import nullcontext

        return nullcontext(Sides(lambda: 1, lambda: 1, lambda ours, baseline: "limit"))

    quick = Benchmark("quick", "nothing", "ms", False, "none", of_nothing)
    monkeypatch.setattr(registry, "benchmarks", lambda: {"quick": quick})
    assert cli.execute(["speed", "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert set(row) == {"name", "ours", "baseline", "ratio", "unit"}
    assert (row["name"], row["unit"]) == ("quick", "ms")
    assert cli.execute(["speed", "--only", "quick"]) == 0
    text = capsys.readouterr().out
    assert "quick" in text
    assert "limit" in text


def test_an_unknown_benchmark_is_one_line(capsys):
    assert cli.execute(["speed", "--only", "swepp"]) == 2
    assert capsys.readouterr().err == "error: unknown benchmark 'swepp': did you mean 'sweep'?\n"


def test_the_ratio_is_of_each_round():
    # the machine was half as fast in the second round: the ratio does not see it
    two = summarise(
        Benchmark("b", "", "ms", False, "", lambda c: None), np.array([3.0, 6.0]), np.array([1.0, 2.0]), ""
    )
    assert (two.ratio, two.ours, two.baseline) == (3.0, 4.5, 1.5)


def test_the_plain_sensor_takes_the_same_picture():
    rng = np.random.default_rng(0)
    diffuse = rng.uniform(5, 80, (60, 80, 3)).astype(np.float32)
    specular = (rng.uniform(0, 300, (60, 80, 3)) * (rng.random((60, 80, 1)) < 0.2)).astype(np.float32)
    white, sensor = np.array([1.1, 1.0, 0.8]), Sensor()
    ours = record(sensor, diffuse, specular, white, np.random.default_rng(1))
    plain = numpy_sensor.record(sensor, diffuse, diffuse + specular, white, np.random.default_rng(2))
    # without noise the same numbers, but for float32 against float64 on the edge of a step
    for truth in ("full", "diffuse"):
        off = np.abs(getattr(ours, truth).astype(int) - getattr(plain, truth))
        assert (off > 0).mean() < 1e-3
    assert (ours.highlight != plain.highlight).mean() < 1e-2
    assert (ours.saturated != plain.saturated).mean() < 1e-3
    # with noise the same mean and variance about the noise-free picture
    a, b = (r.raw.astype(float) for r in (ours, plain))
    assert a.mean() == pytest.approx(b.mean(), rel=2e-3)
    assert (a - b).mean() == pytest.approx(0.0, abs=4 * (a - b).std() / np.sqrt(a.size))
    assert a.std() == pytest.approx(b.std(), rel=5e-3)


def test_both_sides_write_the_same_pictures(tiny, tmp_path):
    pickled = pickle.dumps(generate.job(tiny, tmp_path))
    (tmp_path / "alone").mkdir()
    assert generate._ours((pickled, 1)) == generate._baseline((tmp_path, 1)) == tiny.illuminations
    written = sorted(path.read_bytes() for path in (tmp_path / "tum").rglob("*.png"))
    assert written == sorted(path.read_bytes() for path in (tmp_path / "alone").iterdir())
    assert len(written) == 5 * tiny.illuminations
    assert generate.write_speed(tmp_path, size=4_000_000) > 1e5


def test_relighting_is_the_same_on_both_sides(tiny):
    for k in (0, 7):
        ours, plain = relight_expose.ours(tiny, k), relight_expose.baseline(tiny, k)
        assert np.abs(ours.full.astype(int) - plain.full).max() <= 1
        assert ours.image.mean() == pytest.approx(plain.image.mean(), rel=0.02)


def test_stock_pyrender_sees_the_same_place(tiny):
    poses = stage.poses(stage.scene(sweep.BULBS, tiny.laps), tiny.poses)
    ours = sweep._renderer(tiny).render(poses[1]).depth
    *_, depth = sweep._stock(tiny).render(poses[1], stage.lights(stage.scene(sweep.BULBS), 1)[0])
    inside = (ours > 0) & (ours < 20)
    assert np.median(np.abs(depth - ours)[inside]) < 0.02


def test_eight_lights_cast_shadows_in_basis(tiny):
    place = stage.scene(basis.BULBS, tiny.laps)
    rays = basis.rays_of(place, tiny, stage.poses(place, 1)[0])
    assert len(rays.primary) == tiny.width * tiny.height
    # each light: a ray a point, then fifteen in penumbrae, unless none of its rays arrives
    once, penumbra = ([r for r, _ in rays.shadow if r.shape[1] == count] for count in (1, 15))
    assert len(once) == 8 and len(once) + len(penumbra) == len(rays.shadow)
    assert all(0 < len(r) <= len(rays.primary) for r in once)
    assert any(len(r) for r in penumbra)
    assert rays.count == len(rays.primary) + sum(map(len, once)) + 15 * sum(map(len, penumbra))


def test_both_filters_map_the_same(tiny):
    from bench.speed import slam, slam_stage
    from vslam.slam import SlamSettings, run_slam

    over = slam_stage.drive(tiny)
    plain = slam.NumpyEkf()
    for odometry, observations in over.steps:
        plain.step(odometry, observations)
    ours = run_slam(over.steps, SlamSettings("ekf", "annotated", "cartesian"))
    np.testing.assert_allclose(plain.x[:3], ours.poses[-1], atol=1e-9)
    np.testing.assert_allclose(plain.x[3:].reshape(-1, 2), ours.landmarks, atol=1e-9)


def test_isam2_follows_the_same_drive(tiny):
    from bench.speed import slam_graph, slam_stage

    over = slam_stage.drive(tiny)
    made = slam_graph.updates(over)
    assert slam_graph.baseline(made) == slam_stage.ours(over) == len(over.steps)
    assert sum(one.factors.size() for one in made) == 1 + sum(1 + (o.ids >= 0).sum() for _, o in over.steps)


def test_the_copy_is_measured():
    assert copy_bandwidth(size=1_000_000, repeats=1) > 1e7


@pytest.mark.parametrize("size", [(320, 240), (41, 23)])
def test_the_plain_form_of_the_seed_is_the_same_filter(size):
    """Equal masks and scores; ours bins Λmax (to 1/3072), which moves a few codes by a level or two."""
    picture = sample(*size)
    ours, plain = create("seed")(picture), numpy_seed.seed(picture)
    np.testing.assert_array_equal(ours.mask, plain.mask)
    np.testing.assert_array_equal(ours.score, plain.score)
    difference = np.abs(ours.image.astype(int) - plain.image)
    assert difference.max() <= 2 and difference.mean() < 0.05
    assert ours.mask.any() and (ours.image != picture).any()


def test_both_planners_find_the_same_cost():
    blocked = astar.grid(60)
    path = shortest_path(blocked, (0, 0), (59, 59), 1.0)
    assert isinstance(path, GridPath)
    assert path.cost_m == pytest.approx(astar.dijkstra_cost(blocked), abs=1e-6)
