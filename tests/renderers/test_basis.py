"""The light basis: what is added must add up."""

from __future__ import annotations

import numpy as np
import pytest

from renderers.basis import LightBasis, SceneRenderer, mean_white, relight
from renderers.camera import Fisheye, Mount, Pinhole
from renderers.errors import RendererError
from renderers.irradiance import DIRECT_ONLY, BakeQuality
from renderers.lights import HORIZON_Z
from renderers.lobe_albedo import albedo_table, directional_albedo
from renderers.raycast import RaycastEngine
from scenes.geometry import box, rectangle, surface
from scenes.model import Bulb, Landmark, Material, Sun

GLOSSY = Material((0.5, 0.3, 0.2), roughness=0.3)
STEEL = Material((0.6, 0.6, 0.6), roughness=0.3, metallic=1.0)
CAMERA = Fisheye(64, 48, 150.0)
MOUNT = Mount(height_m=1.0, pitch_deg=35.0)
POSE = np.array([-1.5, 0.1, 0.05])
WHITE = np.ones(3)

LAMP_A = Bulb((0.0, 0.8, 1.6), 1.0, radius=1e-3, group="a")
LAMP_B = Bulb((0.5, -0.8, 1.2), 1.0, radius=1e-3, group="b")


@pytest.fixture(scope="module")
def corner(floor):
    """A glossy floor, a matt wall and a steel box."""
    wall = surface("wall", Material((0.7, 0.7, 0.2), 0.9), rectangle((2, -2, 0), (0, 0, 2), (0, 4, 0), 1.0))
    steel = surface("box", STEEL, box((0.5, -0.3, 0), (0.9, 0.3, 0.6)))
    return floor(2.0, GLOSSY), wall, steel


@pytest.fixture(scope="module")
def basis(renderer_of, scene_of, corner):
    scene = scene_of(*corner, bulbs=[LAMP_A, LAMP_B], sun=Sun(250.0, 40.0, 1.0))
    return renderer_of(scene, CAMERA, MOUNT).render(POSE)


def colours(basis):
    return dict.fromkeys(basis.layers, WHITE)


def layer(basis, name):
    k = basis.layers.index(name)
    return basis.diffuse[k], basis.specular[k]


def test_layers_are_named_finite_and_not_negative(basis):
    assert basis.layers == ("sun", "sky", "a", "b")
    for part in (basis.diffuse, basis.specular):
        assert part.shape == (4, 48, 64, 3)
        assert part.dtype == np.float32
        assert np.isfinite(part).all() and (part >= 0).all()
        assert (part.reshape(4, -1).max(axis=1) > 0).all()


@pytest.mark.parametrize(("present", "name"), [(LAMP_A, "a"), (LAMP_B, "b")])
def test_superposition_of_two_lamps(renderer_of, scene_of, corner, basis, present, name):
    """Each lamp alone in its own scene gives its layer, direct and bounced."""
    alone = renderer_of(scene_of(*corner, bulbs=[present], sun=Sun(250.0, 40.0, 1.0)), CAMERA, MOUNT).render(
        POSE
    )
    for together, single in zip(layer(basis, name), layer(alone, name), strict=True):
        np.testing.assert_allclose(together, single, rtol=1e-4, atol=1e-7)


def test_two_lamps_in_one_layer_are_the_sum(renderer_of, scene_of, corner, basis):
    lamps = [Bulb(lamp.position, 1.0, radius=1e-3, group="both") for lamp in (LAMP_A, LAMP_B)]
    scene = scene_of(*corner, bulbs=lamps, sun=Sun(250.0, 40.0, 1.0))
    both = layer(renderer_of(scene, CAMERA, MOUNT).render(POSE), "both")
    for k in range(2):
        one, other = layer(basis, "a")[k], layer(basis, "b")[k]
        np.testing.assert_allclose(both[k], one + other, rtol=1e-4, atol=1e-7)


def test_full_is_diffuse_plus_specular(renderer_of, scene_of, basis):
    """The parts of one material sum to its whole BRDF, diffuse (1 − F) + lobe, to float precision."""
    intensity = {"sun": 20_000.0, "sky": 1_000.0, "a": 800.0, "b": 0.0}
    diffuse, specular = relight(basis, intensity, colours(basis))
    full = sum(
        intensity[name] * (basis.diffuse[k].astype(np.float64) + basis.specular[k])
        for k, name in enumerate(basis.layers)
    )
    np.testing.assert_allclose(diffuse + specular, full, rtol=1e-5)


def test_matt_surfaces_have_no_specular_part_and_metals_no_diffuse_part(renderer_of, scene_of, floor):
    matt = scene_of(floor(), sun=Sun(0.0, 45.0, 1.0), bulbs=[LAMP_A])
    assert not renderer_of(matt, CAMERA, MOUNT).render(POSE).specular.any()
    metal = scene_of(floor(2.0, STEEL), sun=Sun(0.0, 45.0, 1.0), bulbs=[LAMP_A])
    picture = renderer_of(metal, CAMERA, MOUNT).render(POSE)
    on_floor = picture.surface == 0
    assert on_floor.any() and not picture.diffuse[:, on_floor].any()


def test_polish_does_not_change_what_lambert_loses_to_fresnel(renderer_of, scene_of, floor):
    """The same floor without its specular layer is brighter in the diffuse part, nowhere darker."""
    sun = Sun(0.0, 45.0, 1.0)
    polished, bare = (
        renderer_of(scene_of(floor(2.0, Material((0.5, 0.3, 0.2), 0.3, specular=s)), sun=sun), CAMERA, MOUNT)
        .render(POSE)
        .diffuse
        for s in (1.0, 0.0)
    )
    assert (polished <= bare * (1 + 1e-6)).all()
    assert (polished[0] < bare[0]).any()


def test_polished_floor_mirrors_the_sky(renderer_of, scene_of, floor):
    """Uniform sky above a smooth floor: specular = albedo of the lobe × L, L = 1/π per lux."""
    camera = Pinhole(11, 11, 20.0)
    eye = Mount(height_m=1.0, pitch_deg=60.0)
    picture = renderer_of(scene_of(floor(4.0, Material((0.5,) * 3, 0.2))), camera, eye).render(np.zeros(3))
    a, b = directional_albedo(albedo_table(), np.sin(np.radians(60.0)), 0.2)
    assert picture.specular[1, 5, 5] == pytest.approx((0.04 * a + b) / np.pi, rel=1e-3)


def test_mirror_image_stands_where_the_wall_is(renderer_of, scene_of, floor):
    """A red wall's image in a black polished floor begins at its foot and is as wide as the wall."""
    red = Material((0.8, 0.0, 0.0), 1.0, specular=0.0)
    wall = surface("wall", red, rectangle((2, -0.5, 0), (0, 0, 1), (0, 1, 0), 0.5))
    scene = scene_of(floor(2.0, Material((0.0, 0.0, 0.0), 0.1)), wall)
    camera = Pinhole(101, 101, 70.0)
    picture = renderer_of(scene, camera, Mount(height_m=1.0, pitch_deg=30.0)).render(np.zeros(3))
    shine = picture.specular[1]
    on_floor = picture.surface == 0
    image = on_floor & (shine[..., 0] > 2 * shine[..., 1])  # redder than the sky's own image
    foot = np.flatnonzero((picture.surface == 1).any(axis=1)).max()
    rows = np.flatnonzero(image.any(axis=1))
    assert rows.min() == foot + 1
    columns, wall_columns = np.flatnonzero(image[foot + 1]), np.flatnonzero((picture.surface == 1)[foot])
    assert abs(columns.min() - wall_columns.min()) <= 1 and abs(columns.max() - wall_columns.max()) <= 1
    # as bright as the wall's own foot times what the polish reflects there: the eye 1 m up, the foot 2 m away
    a, b = directional_albedo(albedo_table(), 1 / np.sqrt(5), 0.1)
    mirrored, seen = shine[foot + 1, 50, 0], picture.diffuse[1, foot, 50, 0]
    assert mirrored == pytest.approx((0.04 * a + b) * seen, rel=0.1)


def test_lamp_and_sky_seen_directly(renderer_of, scene_of, floor):
    lamp = Bulb((1.0, 0.0, 1.0), 1.0, radius=0.1)
    camera = Pinhole(41, 41, 60.0)
    scene, eye = scene_of(floor(), bulbs=[lamp]), Mount(1.0, 0.0, 0.0)  # no floor light on the globe
    picture = renderer_of(scene, camera, eye, quality=DIRECT_ONLY).render(np.zeros(3))
    bulbs = layer(picture, "bulbs")[0]
    # I / (π r²) with 1/4π cd; the disc of radius 0.1 at 1 m
    np.testing.assert_allclose(bulbs[20, 20], 1 / (4 * np.pi) / (np.pi * 0.1**2), rtol=1e-5)
    expected = np.pi * (camera.focal * np.tan(np.arcsin(0.1))) ** 2
    assert (bulbs[..., 0] > 1).sum() == pytest.approx(expected, rel=0.1)  # an octagon-like sphere
    sky = layer(picture, "sky")[0]
    rays = camera.unproject(np.array([20.0, 2.0]))
    assert -rays[1] > HORIZON_Z
    np.testing.assert_allclose(sky[2, 20], 1 / np.pi, rtol=1e-5)
    assert picture.depth[2, 20] == 0 and picture.surface[2, 20] == -1


def test_depth_is_z_in_the_camera(renderer_of, scene_of, floor, on_floor):
    for camera in (Pinhole(32, 24, 80.0), Fisheye(32, 24, 120.0)):
        eye = Mount(height_m=1.0, pitch_deg=60.0)
        picture = renderer_of(scene_of(floor(30.0, cell=60.0)), camera, eye).render(np.zeros(3))
        T = eye.T_robot_camera
        z = (on_floor(camera, T) - T[:3, 3]) @ T[:3, 2]
        seen = picture.surface == 0
        assert seen.sum() > 100
        np.testing.assert_allclose(picture.depth[seen], z[seen], rtol=1e-4)
        assert not picture.depth[~seen].any()


@pytest.mark.parametrize("factor", [2, 3])
def test_supersampled_picture_is_the_box_average(renderer_of, scene_of, corner, factor):
    scene = scene_of(*corner, bulbs=[LAMP_A])
    fine = renderer_of(scene, CAMERA.enlarged(factor), MOUNT).render(POSE)
    smooth = renderer_of(scene, CAMERA, MOUNT, supersampling=factor).render(POSE)
    boxes = {
        name: getattr(fine, name).reshape(-1, 48, factor, 64, factor, 3).mean(axis=(2, 4))
        for name in ("diffuse", "specular")
    }
    np.testing.assert_allclose(smooth.diffuse, boxes["diffuse"], rtol=1e-4, atol=1e-7)
    # a pixel's samples cast their mirrored rays elsewhere than as many pixels do
    assert smooth.specular.mean() == pytest.approx(boxes["specular"].mean(), rel=0.01)
    if factor == 3:  # an odd factor has a sample at the pixel's centre
        plain = renderer_of(scene, CAMERA, MOUNT).render(POSE)
        np.testing.assert_array_equal(smooth.surface, plain.surface)
        np.testing.assert_allclose(smooth.depth, plain.depth, rtol=1e-4)


def test_supersampling_must_be_positive(renderer_of, scene_of):
    with pytest.raises(RendererError, match="supersampling 0"):
        renderer_of(scene_of(), CAMERA, MOUNT, supersampling=0)


def test_same_pose_same_bytes(renderer_of, scene_of, corner):
    scene = scene_of(*corner, bulbs=[LAMP_A, LAMP_B], landmarks=[Landmark(0, (0.0, 0.0), 0.1, True)])
    one, other = (renderer_of(scene, CAMERA, MOUNT).render(POSE) for _ in range(2))
    for name in ("diffuse", "specular", "depth", "surface", "landmark", "visible_share"):
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes()


def test_any_number_of_threads_gives_the_same_bytes(scene_of, corner):
    sun = Sun(250.0, 40.0, 1.0)
    scene = scene_of(*corner, bulbs=[LAMP_A, LAMP_B], landmarks=[Landmark(0, (0.0, 0.0), 0.1, True)], sun=sun)
    wide = Pinhole(160, 120, 70.0)  # several blocks
    quality = BakeQuality(64, 16, 1)
    bases = []
    for threads in (1, 2, 5):
        renderer = SceneRenderer(scene, wide, MOUNT, threads=threads, quality=quality)
        bases.append(renderer.render(POSE))
        renderer.close()
    for other in bases[1:]:
        for name in ("diffuse", "specular", "depth", "surface", "landmark", "visible_share"):
            assert getattr(bases[0], name).tobytes() == getattr(other, name).tobytes()


def test_world_turned_with_the_robot_looks_the_same(renderer_of, scene_of, floor):
    """Light from the bulb straight above does not depend on heading."""
    scene = scene_of(floor(8.0, cell=16.0), bulbs=[Bulb((0, 0, 2), 1.0, radius=1e-3)])
    renderer = renderer_of(scene, Pinhole(32, 24, 60.0), Mount(1.0, 0.0, 60.0))
    one, other = renderer.render(np.zeros(3)), renderer.render(np.array([0.0, 0.0, 2.0]))
    np.testing.assert_allclose(one.diffuse, other.diffuse, rtol=1e-3)


class TestRelight:
    def test_is_linear_in_the_intensities(self, basis):
        colour = {"sun": np.array([1.1, 1.0, 0.8]), "sky": np.array([0.9, 1, 1.2]), "a": WHITE, "b": WHITE}
        one = {"sun": 3.0, "sky": 0.0, "a": 7.0, "b": 1.0}
        two = {"sun": 5.0, "sky": 2.0, "a": 0.0, "b": 4.0}
        mixed = {name: 2 * one[name] + 3 * two[name] for name in one}
        for k in range(2):
            expected = 2 * relight(basis, one, colour)[k] + 3 * relight(basis, two, colour)[k]
            np.testing.assert_allclose(relight(basis, mixed, colour)[k], expected, rtol=1e-5, atol=1e-8)

    def test_weights_each_channel_by_the_lights_colour(self, basis):
        colour = {**colours(basis), "a": np.array([2.0, 1.0, 0.5])}
        off = dict.fromkeys(basis.layers, 0.0)
        diffuse, specular = relight(basis, {**off, "a": 10.0}, colour)
        np.testing.assert_allclose(diffuse, layer(basis, "a")[0] * [20.0, 10.0, 5.0], rtol=1e-6)
        np.testing.assert_allclose(specular, layer(basis, "a")[1] * [20.0, 10.0, 5.0], rtol=1e-6)

    @pytest.mark.parametrize("count", [1, 2, 3, 8])
    def test_sums_any_number_of_layers(self, count):
        rng = np.random.default_rng(count)
        parts = rng.random((2, count, 5, 7, 3), dtype=np.float32)
        none, names = np.zeros((5, 7)), tuple("abcdefgh"[:count])
        intensity = dict(zip(names, rng.uniform(0, 9, count), strict=True))
        colour = {name: rng.uniform(0.5, 1.5, 3) for name in names}
        weights = np.array([intensity[name] * colour[name] for name in names])
        lit = relight(LightBasis(names, *parts, none, none, none, none, none), intensity, colour)
        np.testing.assert_allclose(lit, np.einsum("plhwc,lc->phwc", parts, weights), rtol=1e-5)

    def test_no_light_is_black(self, basis):
        diffuse, specular = relight(basis, dict.fromkeys(basis.layers, 0.0), colours(basis))
        assert not diffuse.any() and not specular.any()

    @pytest.mark.parametrize("bad", [None, -1.0, np.nan, np.inf])
    def test_bad_intensity_names_the_layer(self, basis, bad):
        intensity = dict.fromkeys(basis.layers, 1.0)
        if bad is None:
            del intensity["a"]
        else:
            intensity["a"] = bad
        with pytest.raises(RendererError, match="layer 'a'"):
            relight(basis, intensity, colours(basis))

    def test_missing_colour_names_the_layer(self, basis):
        colour = colours(basis)
        del colour["sky"]
        with pytest.raises(RendererError, match="layer 'sky'"):
            relight(basis, dict.fromkeys(basis.layers, 1.0), colour)


class TestMeanWhite:
    def two_layers(self):
        diffuse = np.zeros((2, 4, 4, 3), np.float32)
        diffuse[0], diffuse[1] = 1.0, 3.0
        none = np.zeros((4, 4))
        return LightBasis(("x", "y"), diffuse, 0 * diffuse, none, none, none, none, none)

    def test_weights_colours_by_their_share_of_the_light(self):
        colour = {"x": np.array([1.0, 1.0, 1.0]), "y": np.array([2.0, 1.0, 0.0])}
        white = mean_white(self.two_layers(), {"x": 6.0, "y": 2.0}, colour)  # both add 6 to the mean
        np.testing.assert_allclose(white, [1.5, 1.0, 0.5])

    def test_of_one_light_is_its_colour_and_of_none_is_white(self):
        colour = {"x": np.array([1.2, 1.0, 0.8]), "y": np.array([2.0, 1.0, 0.0])}
        np.testing.assert_allclose(mean_white(self.two_layers(), {"x": 5.0, "y": 0.0}, colour), colour["x"])
        np.testing.assert_array_equal(mean_white(self.two_layers(), {"x": 0.0, "y": 0.0}, colour), np.ones(3))


def test_engine_is_closed_with_the_renderer(renderer_of, scene_of):
    renderer = renderer_of(scene_of(), CAMERA, MOUNT)
    assert isinstance(renderer._engine, RaycastEngine)
    renderer.close()
