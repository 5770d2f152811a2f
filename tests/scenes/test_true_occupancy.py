"""The true grid against rays cast through the geometry."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import ndimage

from renderers.mesh import RayCaster, build_mesh
from scenes import library
from scenes.errors import SceneError
from scenes.geometry import box, rectangle, surface
from scenes.model import Material, Scene, Sky, Sun, Tour
from scenes.occupancy import TrueOccupancy, check_tour, true_occupancy

GREY = Material((0.5, 0.5, 0.5), 1.0)
RESOLUTION = 0.1


PLACES = ("atrium", "corridor", "office", "regular", "tabletop", "warehouse")


@pytest.fixture(scope="module", params=PLACES)
def place(request):
    scene = library.load(request.param)
    mesh = build_mesh(scene)
    return scene, true_occupancy(scene, RESOLUTION), RayCaster(mesh.vertices, mesh.triangles, threads=1)


def cell_centres(grid):
    rows, columns = np.indices(grid.blocked.shape)
    return grid.origin + (np.stack([columns, rows], axis=-1) + 0.5) * grid.resolution


def crossed(grid, caster, heights, reach=0.49):
    """Cells in which a ray from the centre hits something within ``reach`` cells.

    At 0.49 it stays short of the border, which belongs to both neighbours.
    """
    centres = cell_centres(grid)
    hit = np.zeros(grid.blocked.shape, dtype=bool)
    half = reach * grid.resolution
    for height in heights:
        origins = np.concatenate([centres, np.full((*hit.shape, 1), height)], axis=-1).astype(np.float32)
        for way in ([half, 0, 0], [-half, 0, 0], [0, half, 0], [0, -half, 0]):
            hit |= caster.occluded(origins, np.broadcast_to(np.float32(way), origins.shape), far=1.0)
    low = np.concatenate([centres, np.full((*hit.shape, 1), 0.05)], axis=-1).astype(np.float32)
    return hit | caster.occluded(low, np.broadcast_to(np.float32([0, 0, 1.15]), low.shape), far=1.0)


def test_what_rays_hit_is_blocked(place):
    _, grid, caster = place
    hit = crossed(grid, caster, np.arange(0.06, 1.2, 0.06))
    assert hit.sum() > 400
    assert grid.blocked[hit].all()


def test_free_cells_are_free_and_connected_and_walls_are_thin(place):
    """Beside free cells, a cell is blocked only if some ray through it hits something."""
    _, grid, caster = place
    rows, columns = grid.blocked.shape
    fine = TrueOccupancy(np.zeros((4 * rows, 4 * columns), dtype=bool), grid.origin, RESOLUTION / 4)
    near = crossed(fine, caster, (0.07, 0.3, 0.5, 0.7, 0.9, 1.1), reach=1.1)
    near = near.reshape(rows, 4, columns, 4).any(axis=(1, 3))
    regions, _ = ndimage.label(~grid.blocked)
    assert regions.max() == 1
    reachable_side = ndimage.binary_dilation(~grid.blocked)  # over an edge, not a corner
    border = near[grid.blocked & reachable_side]
    assert (~border).sum() <= 0.02 * len(border)  # cells touched by less than the rays' distance of 25 mm


@pytest.fixture(scope="module")
def corridor_grid():
    return true_occupancy(library.load("corridor"), RESOLUTION)


def test_area_of_the_ring(corridor_grid):
    """20 × 14 m less its 15 × 9 m core, less the cells of the walls and of the furniture."""
    grid = corridor_grid
    free_m2 = (~grid.blocked).sum() * RESOLUTION**2
    assert 0.85 * (20 * 14 - 15 * 9) < free_m2 < 20 * 14 - 15 * 9


def test_outdoors_and_core_are_blocked(corridor_grid):
    grid = corridor_grid
    for outside in ((10.0, 7.0), (10.0, -0.15), (-0.15, 7.0)):
        column, row = np.floor((np.array(outside) - grid.origin) / grid.resolution).astype(int)
        assert grid.blocked[row, column]


def test_tour_is_free(place):
    scene, grid, _ = place
    column, row = np.floor((scene.tour.poses[:, :2] - grid.origin) / grid.resolution).astype(int).T
    assert not grid.blocked[row, column].any()


def room_with(*things, start=(0.5, 0.5)):
    """A room of 4 m × 3 m with thin walls."""
    walls = [
        rectangle((0, 0, 0), (0, 0, 2), (4, 0, 0)),
        rectangle((4, 0, 0), (0, 0, 2), (0, 3, 0)),
        rectangle((4, 3, 0), (0, 0, 2), (-4, 0, 0)),
        rectangle((0, 3, 0), (0, 0, 2), (0, -3, 0)),
    ]
    floor = surface("floor", GREY, rectangle((0, 0, 0), (4, 0, 0), (0, 3, 0)))
    tour = Tour(np.array([[*start, 0.0]]), np.zeros(1))
    surfaces = (floor, surface("wall", GREY, *walls), *things)
    suns, sky = (Sun(0.0, 45.0, 1.0),), Sky(1.0)
    return Scene(
        "room", surfaces, (), suns, sky, (), tour, "floor", (1.0,) * 3, (0.0,) * 3, (0.0, 0.0, 4.0, 3.0)
    )


def test_box_blocks_its_footprint_inside_too():
    block = surface("block", GREY, box((2.02, 1.02, 0), (2.98, 1.98, 0.5)))
    grid = true_occupancy(room_with(block), 0.1)
    x, y = np.moveaxis(cell_centres(grid), -1, 0)
    inside = (x > 2.0) & (x < 3.0) & (y > 1.0) & (y < 2.0)
    room = (x > 0.1) & (x < 3.9) & (y > 0.1) & (y < 2.9)
    np.testing.assert_array_equal(grid.blocked[room], inside[room])


@pytest.mark.parametrize(("low", "high", "blocks"), [(1.3, 1.6, False), (0.0, 0.04, False), (1.1, 1.6, True)])
def test_only_the_robots_height_counts(low, high, blocks):
    """A shelf above the mast and a sill below the wheels are not in the way."""
    shelf = surface("shelf", GREY, box((2, 1, low), (3, 2, high), bottom=True))
    grid = true_occupancy(room_with(shelf), 0.1)
    column, row = np.floor((np.array([2.5, 1.5]) - grid.origin) / grid.resolution).astype(int)
    assert grid.blocked[row, column] == blocks


def test_slanted_board_is_cut_at_the_band():
    """A ramp from the floor to 2.4 m: in the robot's way between 0.05 m and 1.2 m of height."""
    ramp = surface("ramp", GREY, rectangle((1, 1, 0), (2, 0, 2.4), (0, 1, 0)))
    grid = true_occupancy(room_with(ramp), 0.05)
    row = int((1.5 - grid.origin[1]) / 0.05)
    x = cell_centres(grid)[row, :, 0]
    blocked = x[grid.blocked[row] & (x > 0.2) & (x < 3.8)]
    assert blocked.min() == pytest.approx(1 + 0.05 / 1.2, abs=0.05)
    assert blocked.max() == pytest.approx(2.0, abs=0.05)


def test_tour_inside_an_obstacle():
    block = surface("block", GREY, box((0.3, 0.3, 0), (0.52, 0.52, 1.0)))
    with pytest.raises(SceneError, match="scene 'room': the tour starts inside an obstacle"):
        true_occupancy(room_with(block, start=(0.31, 0.31)), 0.1)


def test_tour_outside_the_plan():
    scene = dataclasses.replace(room_with(start=(9.0, 9.0)))
    with pytest.raises(SceneError, match="scene 'room': the tour starts outside"):
        true_occupancy(scene, 0.1)


def driven(*poses):
    """A scene with a wall 4 cm thick across most of its room, north of which is a gap, and a tour."""
    partition = surface("partition", GREY, box((1.98, 0.0, 0), (2.02, 2.0, 2.0)))
    poses = np.array([[x, y, 0.0] for x, y in poses])
    return dataclasses.replace(room_with(partition), tour=Tour(poses, np.arange(float(len(poses)))))


def test_a_tour_through_a_thin_wall_says_where():
    scene = driven((1.3, 1.0), (1.7, 1.0), (2.3, 1.0))  # no pose stands in the wall
    with pytest.raises(SceneError, match=r"scene 'room': the tour runs into an obstacle at \(1\.\d+, 1\) m"):
        check_tour(scene)


@pytest.mark.parametrize("end", [(2.0, 1.0), (5.0, 1.0)])
def test_a_tour_that_ends_in_a_wall_or_outside_says_where(end):
    with pytest.raises(SceneError, match=rf"the tour runs into an obstacle at \({end[0]:g}, 1\) m"):
        check_tour(driven((0.5, 1.0), end))


def test_a_tour_around_the_wall_may_be_read_in_strides():
    """Poses far apart do not say that the robot drove straight from one to the next."""
    check_tour(driven((0.8, 1.0), (1.6, 2.5), (2.4, 2.5), (3.2, 1.0)))
    check_tour(driven((0.8, 1.0), (3.2, 1.0)))


def test_no_tour_of_the_library_runs_through_a_wall(place):
    check_tour(place[0])
