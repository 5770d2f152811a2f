"""The corridor: what the dissertation asks of it, and that its seed places it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from scenes import library
from scenes.occupancy import true_occupancy

ROBOT_RADIUS_M = 0.25


@pytest.fixture(scope="module")
def corridor():
    return library.load("corridor")


def everything(scene):
    """All that a seed could place, as one array."""
    marks = [[*m.position, m.radius, m.white] for m in scene.landmarks]
    return np.concatenate(
        [np.ravel(marks), *(s.vertices.ravel() for s in scene.surfaces), scene.tour.poses.ravel()]
    )


def test_same_seed_same_scene_other_seed_other_scene(corridor):
    np.testing.assert_array_equal(everything(corridor), everything(library.load("corridor", seed=0)))
    other = library.load("corridor", seed=1)
    assert [m.position for m in other.landmarks] != [m.position for m in corridor.landmarks]
    named = {s.name: s for s in corridor.surfaces}
    moved = {s.name for s in other.surfaces if not np.array_equal(s.vertices, named[s.name].vertices)}
    assert moved == {"door", "lift", "grey cabinet", "red cabinet"}


@pytest.mark.parametrize("seed", range(4))
def test_discs(seed):
    """0.10 … 0.20 m, both colours, about every 1.5 m on both sides, apart from each other, on free floor."""
    scene = library.load("corridor", seed=seed)
    centre = scene.landmark_positions
    radius = np.array([m.radius for m in scene.landmarks])
    assert ((radius >= 0.10) & (radius <= 0.20)).all()
    assert 0.3 < np.mean([m.white for m in scene.landmarks]) < 0.9
    assert [m.id for m in scene.landmarks] == list(range(len(radius)))
    way_m = 2 * (17.5 + 11.5)
    assert 0.85 * 2 * way_m / 1.5 <= len(radius) <= 2 * way_m / 1.5
    apart = np.linalg.norm(centre[:, None] - centre, axis=-1) - radius[:, None] - radius
    np.fill_diagonal(apart, np.inf)
    assert apart.min() > 0
    grid = true_occupancy(scene, 0.05)
    free_m = ndimage.distance_transform_edt(~grid.blocked) * grid.resolution
    column, row = np.floor((centre - grid.origin) / grid.resolution).astype(int).T
    assert (free_m[row, column] > radius - grid.resolution).all()


def test_tour_is_one_and_a_quarter_loops_at_table_4_1s_speed(corridor):
    tour = corridor.tour
    step = np.linalg.norm(np.diff(tour.poses[:, :2], axis=0), axis=1)
    assert np.median(step) / np.median(np.diff(tour.stamps)) == pytest.approx(0.93, rel=1e-3)
    assert (tour.poses[-1, 2] - tour.poses[0, 2]) / (2 * np.pi) == pytest.approx(1.25, abs=0.13)
    # the last quarter is driven twice: it passes where it has been before
    end, before = tour.poses[-1, :2], tour.poses[: len(step) // 2, :2]
    assert np.linalg.norm(before - end, axis=1).min() < 0.5
    assert np.abs(np.diff(tour.poses[:, 2])).max() < 0.93 * 0.5 / 0.8 + 0.01


@pytest.mark.parametrize("seed", range(3))
def test_robot_fits_along_the_whole_tour(seed):
    """The exact distance from each pose to the geometry at robot height, as segments seen from above."""
    scene = library.load("corridor", seed=seed)
    low, high = 0.05, 1.2
    segments = []
    for surface in scene.surfaces:
        corner = surface.vertices[surface.triangles]
        reach = (corner[..., 2].min(axis=1) < high) & (corner[..., 2].max(axis=1) > low)
        flat = corner[reach][..., :2]
        segments += [flat[:, [0, 1]], flat[:, [1, 2]], flat[:, [2, 0]]]
    start, stop = np.moveaxis(np.concatenate(segments), 1, 0)
    along = stop - start
    squared = np.maximum((along**2).sum(axis=1), 1e-12)
    for pose in scene.tour.poses:
        t = np.clip(((pose[:2] - start) * along).sum(axis=1) / squared, 0, 1)
        gap = np.linalg.norm(start + t[:, None] * along - pose[:2], axis=1).min()
        assert gap > ROBOT_RADIUS_M


def test_materials_cover_what_filters_meet(corridor):
    materials = {s.name: s.material for s in corridor.surfaces}
    colour = {name: np.array(m.base_color) for name, m in materials.items()}
    assert materials["floor"].roughness < 0.4  # glossy
    assert colour["wall"].min() > 0.7  # white
    assert np.ptp(colour["grey cabinet"]) < 0.05 and 0.2 < colour["grey cabinet"].mean() < 0.6
    assert colour["red cabinet"][0] > 4 * colour["red cabinet"][1]
    assert sum(m.metallic == 1.0 for m in materials.values()) == 1


def test_sun_reaches_the_corridor_through_its_windows_alone(corridor):
    """From the floor, rays to the sun escape somewhere in the south corridor and nowhere else."""
    from renderers.mesh import RayCaster, build_mesh

    mesh = build_mesh(corridor)
    caster = RayCaster(mesh.vertices, mesh.triangles, threads=1)
    grid = np.stack(np.meshgrid(np.arange(0.2, 20, 0.1), np.arange(0.2, 14, 0.1)), axis=-1)
    inner = (grid[..., 0] > 2.5) & (grid[..., 0] < 17.5) & (grid[..., 1] > 2.5) & (grid[..., 1] < 11.5)
    points = np.concatenate([grid, np.full((*grid.shape[:2], 1), 0.01)], axis=-1).astype(np.float32)
    rays = np.broadcast_to(corridor.suns[0].direction.astype(np.float32), points.shape)
    lit = ~caster.occluded(points, rays) & ~inner
    south = grid[..., 1] < 2.5
    assert 0.1 < lit[south].mean() < 0.6
    assert not lit[~south].any()


def test_bulbs_hang_under_the_ceiling_over_the_way(corridor):
    positions = np.array([b.position for b in corridor.bulbs])
    assert (positions[:, 2] < 2.6).all() and (positions[:, 2] > 2.0).all()
    gap = np.linalg.norm(positions[:, None, :2] - corridor.tour.poses[:, :2], axis=-1).min(axis=1)
    assert gap.max() < 0.3
    assert 12 <= len(positions) <= 16
