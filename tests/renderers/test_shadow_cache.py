"""Shadows that are told once for a scene's surfaces: against rays, and pictures against those without."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.basis import LightBasis, SceneRenderer, mean_white, relight
from renderers.camera import Fisheye, Mount
from renderers.irradiance import BakeQuality
from renderers.lights import DirectLight, unit_lights
from renderers.mesh import NOTHING, RayCaster, build_mesh
from renderers.sensor import Sensor
from renderers.shadow_cache import AWAY, BORDER, DARK, LIT, UNTOLD, ShadowCache, lit_shares
from renderers.shadows import POINTS, lit_share
from renderers.surface_cells import CELL_M, CellGrid
from renderers.threads import Threads
from renderers.truth import record
from scenes import library
from scenes.geometry import rectangle, surface
from scenes.model import Bulb, Material, Scene, Sun

GREY = Material((0.5, 0.5, 0.5), roughness=1.0, specular=0.0)
QUICK, CAMERA = BakeQuality(16, 4, 0), Fisheye(160, 120, 150.0)


def random_points(grid: CellGrid, triangles: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Where in triangles, (n, 2) barycentric and (n, 3) metres, evenly spread."""
    weights = np.random.default_rng(seed).dirichlet(np.ones(3), len(triangles)).astype(np.float32)
    corners = grid.mesh.vertices[grid.mesh.triangles[triangles]]
    return weights[:, 1:], np.einsum("nk,nkc->nc", weights, corners).astype(np.float32)


def found(grid: CellGrid, triangles: np.ndarray, where: np.ndarray, side: float = 1.0) -> np.ndarray:
    return grid.cells(triangles.astype(np.int32), where, np.float32(side) * grid.mesh.normals[triangles])


def test_cells_are_small_and_no_two_places_share_one(scene_of, floor) -> None:
    grid = CellGrid.of(build_mesh(scene_of(floor(1.0, GREY, 0.7))))
    triangles = np.repeat(np.arange(len(grid.side)), 4000)
    where, points = random_points(grid, triangles, 1)
    cells = found(grid, triangles, where)
    assert cells.min() == 0 and cells.max() == grid.count - 1
    assert len(np.unique(cells)) == grid.count == (grid.side**2).sum()
    legs = np.sort([np.ptp(points[cells == cell], axis=0)[:2] for cell in range(0, grid.count, 37)])
    assert legs.max() <= CELL_M + 1e-6
    triangle = legs.min(axis=1) * legs.max(axis=1) / 2  # points of two cells would span a square at least
    assert (triangle <= CELL_M**2 / 2).all() and triangle.mean() > 0.5 * (2.0**2 / grid.count)


def test_backs_large_and_curved_triangles_have_none(scene_of, floor) -> None:
    grid = CellGrid.of(build_mesh(scene_of(floor(1.0, GREY, 0.5))))
    one, where = np.zeros(1, int), np.float32([[0.3, 0.3]])
    assert found(grid, one, where)[0] >= 0
    assert found(grid, one, where, side=-1.0)[0] == NOTHING
    assert grid.cells(np.int32([NOTHING]), where, np.float32([[0, 0, 1]]))[0] == NOTHING
    assert not CellGrid.of(build_mesh(scene_of(floor(40.0, GREY, 20.0)))).side.any()


@pytest.mark.parametrize("light", ["sun", "bulbs 1"])
def test_what_is_told_of_a_corridor_is_what_rays_find(light: str) -> None:
    place = library.load("corridor", seed=3)
    mesh = build_mesh(place)
    caster, grid = RayCaster(mesh.vertices, mesh.triangles, 1), CellGrid.of(mesh)
    one = next(x for group in unit_lights(place).values() for x in group if x.name == light)
    assert isinstance(one, DirectLight)
    cache = ShadowCache(grid, one, caster, Threads(1))
    assert (cache.told == UNTOLD).all()
    cache.tell(np.ones(len(grid.side), dtype=bool))
    assert (cache.told != UNTOLD).all()
    corners = mesh.vertices[mesh.triangles]
    twice = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    area = np.where(grid.side > 0, twice, 0.0)
    triangles = np.random.default_rng(2).choice(len(area), 20_000, p=area / area.sum())
    where, points = random_points(grid, triangles, 2)
    told = cache.told[found(grid, triangles, where)]
    share = lit_share(one, points, mesh.normals[triangles], np.arange(len(points)), caster, POINTS)
    lit, dark = told == LIT, told == DARK
    facing = one.arriving(points, mesh.normals[triangles])[1] > 0
    np.testing.assert_array_equal(told[~facing], AWAY)
    assert lit.sum() > 100 and dark.sum() > 5000 and 0 < (told == BORDER).mean() < 0.05
    assert (share[lit] < 1).mean() <= 0.01  # borders between the rays: a door's edge, the rim of a penumbra
    assert (share[dark] > 0).mean() <= 0.01


def test_a_cell_is_told_the_same_in_whatever_order_it_is_seen(scene_of, floor) -> None:
    shade = surface("shade", GREY, rectangle((-0.3, -0.3, 1), (0.6, 0, 0), (0, 0.6, 0), 0.3))
    mesh = build_mesh(scene_of(floor(2.0, GREY, 0.4), shade))
    caster, grid = RayCaster(mesh.vertices, mesh.triangles, 1), CellGrid.of(mesh)
    bulb = unit_lights(scene_of(bulbs=[Bulb((0.2, 0, 2), 100.0, radius=0.05)]))["bulbs"][0]
    assert isinstance(bulb, DirectLight)
    at_once, by_two = (ShadowCache(grid, bulb, caster, Threads(1)) for _ in range(2))
    at_once.tell(np.ones(len(grid.side), dtype=bool))
    for first in (1, 0):
        by_two.tell(np.arange(len(grid.side)) % 2 == first)
    np.testing.assert_array_equal(at_once.told, by_two.told)
    assert {DARK, LIT, BORDER} <= set(at_once.told)


def test_rays_are_cast_where_no_surface_has_cells(scene_of, floor) -> None:
    roof = surface("roof", GREY, rectangle((0, -40, 5), (40, 0, 0), (0, 80, 0), 80.0))
    place = scene_of(floor(40.0, GREY, 20.0), roof, sun=Sun(azimuth_deg=180.0, elevation_deg=80.0, lux=1.0))
    mesh = build_mesh(place)
    caster, grid = RayCaster(mesh.vertices, mesh.triangles, 1), CellGrid.of(mesh)
    assert grid.count == 0
    sun = unit_lights(place)[place.suns[0].name][0]
    assert isinstance(sun, DirectLight)
    cache, cells = ShadowCache(grid, sun, caster, Threads(1)), np.full(2, NOTHING, dtype=np.int32)
    points, up = np.float32([[-20, 0, 0], [20, 0, 0]]), np.float32([[0, 0, 1]] * 2)
    assert lit_shares(sun, cache, cells, points, up, np.arange(2), caster).tolist() == [1.0, 0.0]


def picture(place: Scene, basis: LightBasis) -> np.ndarray:
    """What a camera without noise makes of it, under the scene's own lights."""
    suns = {sun.name: sun.lux for sun in place.suns}
    intensity = suns | {place.sky.name: place.sky.lux} | {bulb.group: bulb.lumen for bulb in place.bulbs}
    colour = dict.fromkeys(basis.layers, np.ones(3))
    light = relight(basis, intensity, colour)
    return record(Sensor(), *light, mean_white(basis, intensity, colour), np.random.default_rng(0)).full


@pytest.mark.parametrize("name", ["corridor", "office", "warehouse"])
def test_pictures_are_those_without(name: str, tmp_path) -> None:
    place = library.load(name, seed=4)
    exact, cached = (
        SceneRenderer(place, CAMERA, Mount(), threads=1, cache=tmp_path, quality=QUICK, cached_shadows=on)
        for on in (False, True)
    )
    poses = place.tour.poses[:: len(place.tour.poses) // 3]
    for pose in poses:
        a, b = (picture(place, renderer.render(pose)).astype(int) for renderer in (exact, cached))
        far = np.abs(a - b).max(axis=-1) > 8
        assert far.mean() < 0.0015
    last = cached.render(poses[-1])
    fresh = SceneRenderer(
        place, CAMERA, Mount(), threads=2, cache=tmp_path, quality=QUICK, cached_shadows=True
    ).render(poses[-1])
    np.testing.assert_array_equal(last.diffuse, fresh.diffuse)
    np.testing.assert_array_equal(last.specular, fresh.specular)
