"""Baked light against cases with a known answer."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.irradiance import BakeQuality, Irradiance, bake
from renderers.irradiance_cache import load_or_bake
from renderers.lights import unit_lights
from renderers.mesh import RayCaster, build_mesh
from scenes.geometry import rectangle, surface
from scenes.model import Bulb, Material, Sun


def baked(scene):
    mesh = build_mesh(scene)
    lights = unit_lights(scene)
    caster = RayCaster(mesh.vertices, mesh.triangles, threads=1)
    return mesh, dict(zip(lights, range(len(lights)), strict=True)), bake(mesh, caster, list(lights.values()))


def flux(mesh, lux, surface_index=0):
    """Lumen on a surface: the integral of the vertices' illuminance over the triangles, per channel."""
    triangles = mesh.triangles[mesh.surface == surface_index]
    a, b, c = (mesh.vertices[triangles[:, k]].astype(np.float64) for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    return area @ lux[triangles].mean(axis=1)


def room(albedo, cell=0.25):
    """A closed cube of 2 m, its faces turned inwards."""
    material = Material((albedo, albedo, albedo), roughness=1.0, specular=0.0)
    faces = []
    for axis in range(3):
        u, v = np.roll([2.0, 0, 0], axis + 1), np.roll([2.0, 0, 0], axis + 2)
        faces.append(rectangle((0, 0, 0), tuple(u), tuple(v), cell))
        faces.append(rectangle(tuple(np.roll([2.0, 0, 0], axis)), tuple(v), tuple(u), cell))
    return surface("room", material, *faces)


@pytest.mark.parametrize("albedo", [0.2, 0.5, 0.7])
def test_flux_balance_of_a_closed_room(scene_of, albedo):
    """A lamp of 1 lm in a closed room of reflectance ρ: bounced light brings ρ + ρ² + … = ρ / (1 − ρ) lm.

    Light is followed over a fixed number of bounces, so the series ends there.
    """
    lamp = Bulb((0.9, 1.1, 1.2), lumen=1.0, radius=1e-4)
    mesh, layer, light = baked(scene_of(room(albedo), bulbs=[lamp]))
    series = albedo / (1 - albedo) * (1 - albedo ** (BakeQuality().bounces + 1))
    assert flux(mesh, light.indirect[layer["bulbs"]]) == pytest.approx(np.full(3, series), rel=0.03)
    direct = light.total[layer["bulbs"]] - light.indirect[layer["bulbs"]]
    assert flux(mesh, direct[..., 0]) == pytest.approx(1.0, rel=0.01)
    assert not light.total[layer["sun"]].any()
    assert not light.total[layer["sky"]].any()


def test_open_ground_has_one_lux_per_lux_of_sky(scene_of, floor):
    _, layer, light = baked(scene_of(floor(2.0)))
    np.testing.assert_allclose(light.indirect[layer["sky"]], 1.0, rtol=1e-6)


def test_tall_wall_hides_half_of_the_sky(scene_of, floor):
    """At the foot of an endless wall E = 1/2; at distance d from height h it is (1 + sin atan(d/h)) / 2."""
    black = Material((0.0, 0.0, 0.0), roughness=1.0, specular=0.0)
    wall = surface("wall", black, rectangle((2.0, -400, 0), (0, 0, 40), (0, 800, 0), 800.0))
    mesh, layer, light = baked(scene_of(floor(2.0, black), wall))
    ground = mesh.vertices[: 5 * 5]
    lux = light.indirect[layer["sky"], : 5 * 5, 0]
    distance = 2.0 - ground[:, 0]
    expected = (1 + np.sin(np.arctan(distance / 40))) / 2
    np.testing.assert_allclose(lux, expected, atol=0.01)
    assert lux[distance == 0] == pytest.approx(0.5, abs=0.01)


def test_floor_lights_a_wall_by_its_form_factor(scene_of):
    """One bounce of sun: from a long sunlit floor strip to a wall of right angles, E = ρ E0 F.

    For a wall point at height z over a floor of depth d: F = (1 − z / √(z² + d²)) / 2 (crossed strings).
    """
    grey = Material((0.5, 0.5, 0.5), roughness=1.0, specular=0.0)
    black = Material((0.0, 0.0, 0.0), roughness=1.0, specular=0.0)
    depth = 3.0
    strip = surface("floor", grey, rectangle((0, -150, 0), (depth, 0, 0), (0, 300, 0), 300.0))
    wall = surface("wall", black, rectangle((0, -0.5, 0), (0, 1, 0), (0, 0, 2), 0.5))
    mesh, layer, light = baked(scene_of(strip, wall, sun=Sun(90.0, 90.0, lux=1.0)))
    on_wall = np.arange(len(mesh.vertices)) >= 4
    z = mesh.vertices[on_wall, 2]
    expected = 0.5 * (1 - z / np.hypot(z, depth)) / 2
    inner = (z > 0.1) & (z < 1.9)
    np.testing.assert_allclose(light.indirect[layer["sun"], on_wall, 0][inner], expected[inner], atol=0.012)


def test_back_faces_reflect_nothing(scene_of, floor):
    """A lit sheet above the floor that faces up leaves the floor below dark."""
    white = Material((1.0, 1.0, 1.0), roughness=1.0, specular=0.0)
    sheet = surface("sheet", white, rectangle((-20, -20, 1), (40, 0, 0), (0, 40, 0), 40.0))
    _, layer, light = baked(scene_of(floor(2.0), sheet, sun=Sun(0.0, 90.0, lux=1.0)))
    assert not light.total[layer["sun"], :25].any()


def test_colour_bleeds(scene_of, floor):
    red = Material((0.8, 0.0, 0.0), roughness=1.0, specular=0.0)
    wall = surface("wall", red, rectangle((2.0, -2, 0), (0, 0, 2), (0, 4, 0), 1.0))
    _, layer, light = baked(scene_of(floor(2.0), wall, sun=Sun(270.0, 45.0, lux=1.0)))
    on_floor = light.indirect[layer["sun"], :25]
    assert (on_floor[:, 0] > 0).any()
    assert not on_floor[:, 1:].any()  # nothing else is lit that could bring another colour


class TestCache:
    def parts(self, scene):
        mesh = build_mesh(scene)
        return mesh, RayCaster(mesh.vertices, mesh.triangles, threads=1), list(unit_lights(scene).values())

    def test_same_scene_is_read_back(self, scene_of, tmp_path):
        parts = self.parts(scene_of())
        first = load_or_bake(*parts, tmp_path)
        (file,) = tmp_path.iterdir()
        np.savez(file, indirect=first.indirect + 1, total=first.total)  # to see that it is this file
        again = load_or_bake(*parts, tmp_path)
        np.testing.assert_array_equal(again.indirect, first.indirect + 1)

    def test_other_light_geometry_or_reflectance_is_baked_anew(self, scene_of, floor, tmp_path):
        for scene in (
            scene_of(),
            scene_of(floor(1.0)),
            scene_of(floor(2.0, Material((0.1, 0.1, 0.1), 1.0))),
            scene_of(sun=Sun(0.0, 10.0, 1.0)),
            scene_of(bulbs=[Bulb((0, 0, 1), 1.0)]),
        ):
            load_or_bake(*self.parts(scene), tmp_path)
        assert len(list(tmp_path.iterdir())) == 5

    def test_intensity_does_not_matter(self, scene_of, floor, tmp_path):
        for lux in (1.0, 5000.0):
            scene = scene_of(floor(2.0, Material((0.5, 0.5, 0.5), 0.5)), sun=Sun(0.0, 45.0, lux))
            load_or_bake(*self.parts(scene), tmp_path)
        assert len(list(tmp_path.iterdir())) == 1

    def test_damaged_file_is_replaced(self, scene_of, tmp_path):
        parts = self.parts(scene_of())
        first = load_or_bake(*parts, tmp_path)
        (file,) = tmp_path.iterdir()
        file.write_bytes(file.read_bytes()[:100])
        again = load_or_bake(*parts, tmp_path)
        np.testing.assert_array_equal(again.total, first.total)
        assert file.stat().st_size > 100
        assert [p.name for p in tmp_path.iterdir()] == [file.name]

    def test_folder_that_cannot_be_written_costs_no_result(self, scene_of, tmp_path):
        blocked = tmp_path / "file"
        blocked.write_text("")
        assert isinstance(load_or_bake(*self.parts(scene_of()), blocked / "cache"), Irradiance)
