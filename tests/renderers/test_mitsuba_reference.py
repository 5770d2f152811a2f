"""Radiance against Mitsuba 3 (`scalar_rgb`), an independent renderer with the same BRDF.

The BRDF is written once more here, as a Mitsuba plug-in, from the definition of glTF's appendix B in Heitz's
form with tangents. Mitsuba samples it; its `path` integrator also follows all bounces.
"""

from __future__ import annotations

import mitsuba as mi
import numpy as np
import pytest

from renderers.camera import Mount, Pinhole, T_world_robot
from renderers.irradiance import DIRECT_ONLY, BakeQuality
from renderers.mesh import NOTHING
from scenes.geometry import box, rectangle, surface
from scenes.model import Bulb, Material, Sun
from scenes.shapes import curved_surface, cylinder, place, sphere

mi.set_variant("scalar_rgb")

GREY = Material((0.5, 0.45, 0.4), roughness=1.0, specular=0.0)
RED = Material((0.6, 0.15, 0.1), roughness=1.0, specular=0.0)
POLISHED = Material((0.3, 0.25, 0.2), roughness=0.3)
SATIN = Material((0.2, 0.3, 0.5), roughness=0.6)
STEEL = Material((0.56, 0.57, 0.58), roughness=0.45, metallic=1.0)

FINE = 0.1  # m
PLANE, CURVED = 2e-3, 1e-2

CAMERA = Pinhole(64, 48, 70.0)
MOUNT = Mount(height_m=1.1, pitch_deg=30.0)
POSE = np.array([-2.2, 0.2, 0.0])


class GltfBsdf(mi.BSDF):
    """glTF 2.0 metallic-roughness, one-sided, sampled by cosine: made to be right, not fast."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.base = np.array([props[f"base_{c}"] for c in "rgb"])
        self.alpha2 = props["roughness"] ** 4
        self.metallic, self.specular = props["metallic"], props["specular"]
        self.m_components = [mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide]
        self.m_flags = self.m_components[0]

    def reflected(self, wi, wo):
        """BRDF times the cosine towards wo, (3,)."""
        if wi[2] <= 0 or wo[2] <= 0:
            return np.zeros(3)
        half = wi + wo
        half /= np.sqrt(half @ half)

        def smith_lambda(w):
            return (-1 + np.sqrt(1 + self.alpha2 * (1 / w[2] ** 2 - 1))) / 2

        tan2 = 1 / half[2] ** 2 - 1
        distribution = self.alpha2 / (np.pi * half[2] ** 4 * (self.alpha2 + tan2) ** 2)
        lobe = distribution / (1 + smith_lambda(wi) + smith_lambda(wo)) / (4 * wi[2] * wo[2])
        grazing = (1 - wi @ half) ** 5
        fresnel = self.specular * (0.04 + 0.96 * grazing)
        dielectric = (1 - fresnel) * self.base / np.pi + fresnel * lobe
        metal = (self.base + (1 - self.base) * grazing) * lobe
        return ((1 - self.metallic) * dielectric + self.metallic * metal) * wo[2]

    def eval(self, ctx, si, wo, active):
        return mi.Color3f(self.reflected(np.array(si.wi), np.array(wo)))

    def pdf(self, ctx, si, wo, active):
        return mi.warp.square_to_cosine_hemisphere_pdf(wo) if si.wi[2] > 0 and wo[2] > 0 else 0.0

    def eval_pdf(self, ctx, si, wo, active):
        return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

    def sample(self, ctx, si, sample1, sample2, active):
        sample = mi.BSDFSample3f()
        wo = mi.warp.square_to_cosine_hemisphere(sample2)
        sample.wo, sample.pdf, sample.eta = wo, self.pdf(ctx, si, wo, active), 1.0
        sample.sampled_type, sample.sampled_component = int(mi.BSDFFlags.DiffuseReflection), 0
        if sample.pdf <= 0:
            return sample, mi.Color3f(0.0)
        return sample, self.eval(ctx, si, wo, active) / sample.pdf

    def to_string(self):
        return "GltfBsdf[]"


mi.register_bsdf("gltf", GltfBsdf)


def bsdf(material):
    """Lambert and a mirror of GGX are Mitsuba's own (and a thousand times faster); else the plug-in."""
    if material.metallic == 1 and material.base_color == (1, 1, 1):  # reflects all: F = 1 in any direction
        return {
            "type": "roughconductor",
            "material": "none",
            "distribution": "ggx",
            "alpha": material.roughness**2,
        }
    if material.specular == 0 and material.metallic == 0:
        return {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(material.base_color)}}
    base = {f"base_{c}": float(v) for c, v in zip("rgb", material.base_color, strict=True)}
    return {
        "type": "gltf",
        **base,
        "roughness": material.roughness,
        "metallic": material.metallic,
        "specular": material.specular,
    }


def mesh(piece):
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(bsdf(piece.material))
    counts = len(piece.vertices), len(piece.triangles)
    shape = mi.Mesh(piece.name, *counts, props=properties, has_vertex_normals=piece.normals is not None)
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = piece.vertices.astype(np.float32).ravel()
    parameters["faces"] = piece.triangles.astype(np.uint32).ravel()
    if piece.normals is not None:
        parameters["vertex_normals"] = piece.normals.astype(np.float32).ravel()
    parameters.update()
    return shape


def grey_light(value):
    return {"type": "rgb", "value": [float(value)] * 3}


def sun_of(sun):
    """1 lux on a plane that faces it."""
    return {"type": "directional", "direction": [*(-sun.direction)], "irradiance": grey_light(1.0)}


def point_of(bulb):
    """1 lm from a point."""
    return {"type": "point", "position": [*bulb.position], "intensity": grey_light(1 / (4 * np.pi))}


def sphere_of(bulb):
    """1 lm from a luminous sphere."""
    luminance = 1 / (4 * np.pi) / (np.pi * bulb.radius**2)
    emitter = {"type": "area", "radiance": grey_light(luminance)}
    return {"type": "sphere", "center": [*bulb.position], "radius": bulb.radius, "emitter": emitter}


SKY = {"type": "constant", "radiance": grey_light(1 / np.pi)}


def reference(surfaces, light, integrator, samples):
    """Mitsuba's picture, (H, W, 3) radiance, box-filtered over each pixel."""
    T = T_world_robot(POSE) @ MOUNT.T_robot_camera
    to_world = T @ np.diag([-1.0, -1.0, 1.0, 1.0])  # Mitsuba's camera: x left, y up
    fov = 2 * np.degrees(np.arctan(0.5 * CAMERA.width / CAMERA.focal))
    scene = {
        "type": "scene",
        "integrator": integrator,
        "light": light,
        "sensor": {
            "type": "perspective",
            "to_world": mi.ScalarTransform4f(to_world),
            "fov": fov,
            "fov_axis": "x",
            "near_clip": 0.01,
            "sampler": {"type": "stratified", "sample_count": samples, "seed": 1},
            "film": {
                "type": "hdrfilm",
                "width": CAMERA.width,
                "height": CAMERA.height,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
        },
    }
    for k, piece in enumerate(surfaces):
        scene[f"piece_{k}"] = mesh(piece)
    return np.array(mi.render(mi.load_dict(scene), seed=1))


DIRECT = {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0, "hide_emitters": True}


def away_from_edges(basis, reach=1, bend=PLANE):
    """Pixels whose neighbours all show the same plane, or with a larger ``bend`` (1/m) the same curve."""
    ids = basis.surface + 0.0
    depth = np.where(basis.depth > 0, 1 / np.maximum(basis.depth, 1e-6), 0)
    keep = basis.surface != NOTHING
    for axis in (0, 1):
        second = np.abs(np.diff(depth, 2, axis=axis)) > bend  # 1/z of a plane is linear in the picture
        jump = np.diff(ids, axis=axis) != 0
        for k in range(-reach, reach + 1):
            for change, width in ((jump, 1), (second, 2)):
                bad = np.zeros_like(keep)
                index = [slice(None)] * 2
                for offset in range(width + 1):
                    index[axis] = slice(offset, offset + change.shape[axis])
                    bad[tuple(index)] |= change
                keep &= ~np.roll(bad, k, axis=axis)
    return keep


def errors(ours, theirs, keep):
    lit = keep & (theirs.mean(axis=-1) > 0.01 * np.median(theirs[keep]))
    assert lit.sum() > 0.5 * keep.sum()
    return np.abs(ours[lit] - theirs[lit]).mean(axis=-1) / theirs[lit].mean(axis=-1)


def room(on_floor, on_wall, on_box):
    """A floor before a wall with a box on it, on wide ground that hides what is below the horizon.

    Cut into the library's usual cells of 0.4 m, so that baked light is judged as scenes have it.
    """
    return (
        surface("floor", on_floor, rectangle((-3, -3, 0), (6, 0, 0), (0, 6, 0))),
        surface("wall", on_wall, rectangle((2, -3, 0), (0, 0, 2.4), (0, 6, 0))),
        surface("box", on_box, box((-0.2, -0.5, 0), (0.6, 0.3, 0.7))),
        surface("ground", GREY, rectangle((-300, -300, -0.01), (600, 0, 0), (0, 600, 0), 600.0)),
    )


def still_life(on_floor, on_shapes):
    """A ball and a column, shaded between their vertex normals, with a slanted and a turned box.

    The floor is cut finer than scenes are, as a ball touches it: its contact shadow is smaller than 0.4 m.
    """
    return (
        surface("floor", on_floor, rectangle((-3, -3, 0), (6, 0, 0), (0, 6, 0), FINE)),
        curved_surface("ball", on_shapes, place(sphere(0.4), (-0.2, -0.6, 0.0))),
        curved_surface("column", on_shapes, place(cylinder(0.25, 1.2, 0.4), (0.6, 0.5, 0.0))),
        surface(
            "slab", on_shapes, place(box((-0.4, -0.2, 0), (0.4, 0.2, 0.5)), (-0.4, 0.6, 0.15), 25.0, -20.0)
        ),
        surface("block", on_shapes, place(box((-0.3, -0.3, 0), (0.3, 0.3, 0.9)), (1.2, -0.8, 0.0), 40.0)),
        surface("ground", GREY, rectangle((-300, -300, -0.01), (600, 0, 0), (0, 600, 0), 600.0)),
    )


def colonnade(on_floor, on_wall, on_columns):
    """Square and round columns under a roof that juts out before a wall, open to three sides."""
    columns = [box((0.3, y, 0), (0.55, y + 0.25, 1.9)) for y in (-1.6, -0.4, 0.8)]
    return (
        surface("floor", on_floor, rectangle((-3, -3, 0), (6, 0, 0), (0, 6, 0), FINE)),
        surface("wall", on_wall, rectangle((1.8, -3, 0), (0, 0, 2.4), (0, 6, 0), FINE)),
        surface("roof", on_wall, box((0.1, -3, 1.9), (1.8, 3, 2.05))),
        surface("columns", on_columns, *columns),
        curved_surface("bollard", on_columns, place(cylinder(0.2, 0.8, 0.4), (-0.6, 0.3, 0.0))),
        surface("ground", GREY, rectangle((-300, -300, -0.01), (600, 0, 0), (0, 600, 0), 600.0)),
    )


MATT_ROOM = room(GREY, RED, GREY)
MATT_SHAPES, GLOSSY_SHAPES = still_life(GREY, RED), still_life(POLISHED, SATIN)
MATT_COLONNADE, GLOSSY_COLONNADE = colonnade(GREY, RED, GREY), colonnade(POLISHED, SATIN, STEEL)
GLOSSY_ROOM = room(POLISHED, SATIN, STEEL)
SUN = Sun(azimuth_deg=200.0, elevation_deg=40.0, lux=1.0)
POINT = Bulb((0.2, 1.0, 1.9), 1.0, radius=1e-3)
SPHERE = Bulb((0.2, 1.0, 1.9), 1.0, radius=0.08)
OUTER = Bulb((-0.6, -1.2, 1.6), 1.0, radius=0.08)
FRONT = Bulb((-1.4, 0.6, 1.7), 1.0, radius=0.08)
SKY_TOO = {**DIRECT, "bsdf_samples": 1}
PATH = {"type": "path", "max_depth": 8, "rr_depth": 100, "hide_emitters": True}
ALL_BOUNCES = BakeQuality(sky_rays=1024, bounce_rays=256, bounces=6)


def ours(renderer_of, scene, layer, quality, supersampling=2):
    basis = renderer_of(scene, CAMERA, MOUNT, supersampling=supersampling, quality=quality).render(POSE)
    k = basis.layers.index(layer)
    return basis, basis.diffuse[k] + basis.specular[k]


@pytest.mark.parametrize(
    ("surfaces", "lamps", "layer", "light", "integrator", "samples"),
    [
        pytest.param(GLOSSY_ROOM, {"sun": SUN}, "sun", sun_of(SUN), DIRECT, 4, id="sun, glossy"),
        pytest.param(
            GLOSSY_ROOM, {"bulbs": [POINT]}, "bulbs", point_of(POINT), DIRECT, 16, id="point, glossy"
        ),
        pytest.param(
            GLOSSY_ROOM, {"bulbs": [SPHERE]}, "bulbs", sphere_of(SPHERE), DIRECT, 4, id="bulb, glossy"
        ),
        pytest.param(
            MATT_ROOM, {"bulbs": [SPHERE]}, "bulbs", sphere_of(SPHERE), DIRECT, 256, id="bulb, matt"
        ),
        pytest.param(MATT_ROOM, {}, "sky", SKY, SKY_TOO, 1024, id="sky, matt"),
        pytest.param(GLOSSY_SHAPES, {"sun": SUN}, "sun", sun_of(SUN), DIRECT, 4, id="sun, shapes"),
        pytest.param(
            MATT_SHAPES, {"bulbs": [FRONT]}, "bulbs", sphere_of(FRONT), DIRECT, 256, id="bulb, shapes"
        ),
        pytest.param(MATT_SHAPES, {}, "sky", SKY, SKY_TOO, 1024, id="sky, shapes"),
        pytest.param(GLOSSY_COLONNADE, {"sun": SUN}, "sun", sun_of(SUN), DIRECT, 4, id="sun, colonnade"),
        pytest.param(
            MATT_COLONNADE, {"bulbs": [OUTER]}, "bulbs", sphere_of(OUTER), DIRECT, 256, id="bulb, colonnade"
        ),
        pytest.param(MATT_COLONNADE, {}, "sky", SKY, SKY_TOO, 1024, id="sky, colonnade"),
    ],
)
def test_direct_light(renderer_of, scene_of, surfaces, lamps, layer, light, integrator, samples):
    """Median relative error at most 1 %, 95th percentile at most 5 %, away from silhouettes."""
    basis, picture = ours(renderer_of, scene_of(*surfaces, **lamps), layer, DIRECT_ONLY)
    keep = away_from_edges(basis, bend=CURVED if any(s.normals is not None for s in surfaces) else PLANE)
    found = errors(picture, reference(surfaces, light, integrator, samples), keep)
    assert np.median(found) <= 0.01
    assert np.percentile(found, 95) <= 0.05


@pytest.mark.parametrize("roughness", [0.1, 0.3])
def test_mirrored_sky(renderer_of, scene_of, roughness):
    """The sky in a glossy floor: 256 rays a pixel come to Mitsuba's picture.

    Judged where the mirror image is no darker than a fifth of the sky: about black, relative errors say
    nothing. One ray a pixel has the same mean (within 2 %) and shows a blurred edge in 16 steps.
    """
    surfaces = room(Material((1.0, 1.0, 1.0), roughness=roughness, metallic=1.0), RED, GREY)
    expected = reference(surfaces, SKY, SKY_TOO, 4096)
    scene = scene_of(*surfaces)
    basis, picture = ours(renderer_of, scene, "sky", DIRECT_ONLY, supersampling=16)
    floor = away_from_edges(basis) & (basis.surface == 0)
    found = errors(picture, expected, floor & (expected.mean(axis=-1) > 0.2 * expected[floor].max()))
    assert np.median(found) <= 0.01
    assert np.percentile(found, 95) <= 0.05
    once, quick = ours(renderer_of, scene, "sky", DIRECT_ONLY, supersampling=1)
    floor = away_from_edges(once) & (once.surface == 0)
    assert quick[floor].mean() == pytest.approx(expected[floor].mean(), rel=0.02)


@pytest.mark.parametrize(
    ("surfaces", "lamps", "layer", "light", "samples"),
    [
        pytest.param(MATT_ROOM, {"sun": SUN}, "sun", sun_of(SUN), 64, id="sun, matt"),
        pytest.param(MATT_ROOM, {"bulbs": [SPHERE]}, "bulbs", sphere_of(SPHERE), 64, id="bulb, matt"),
        pytest.param(MATT_ROOM, {}, "sky", SKY, 64, id="sky, matt"),
        pytest.param(GLOSSY_ROOM, {"sun": SUN}, "sun", sun_of(SUN), 4, id="sun, glossy"),
        pytest.param(GLOSSY_ROOM, {}, "sky", SKY, 4, id="sky, glossy"),
        pytest.param(MATT_SHAPES, {"sun": SUN}, "sun", sun_of(SUN), 64, id="sun, shapes"),
        pytest.param(MATT_COLONNADE, {"sun": SUN}, "sun", sun_of(SUN), 64, id="sun, colonnade"),
        pytest.param(MATT_COLONNADE, {}, "sky", SKY, 64, id="sky, colonnade"),
    ],
)
def test_with_indirect_light(renderer_of, scene_of, surfaces, lamps, layer, light, samples):
    """Mean radiance within 5 %, away from silhouettes; with matt surfaces also pixel by pixel."""
    basis, picture = ours(renderer_of, scene_of(*surfaces, **lamps), layer, ALL_BOUNCES)
    expected, keep = reference(surfaces, light, PATH, samples), away_from_edges(basis)
    assert picture[keep].mean() == pytest.approx(expected[keep].mean(), rel=0.05)
    if surfaces is MATT_ROOM:
        assert np.median(errors(picture, expected, keep)) <= 0.03


def test_the_comparison_notices_a_tenth_less_light(renderer_of, scene_of):
    basis, picture = ours(renderer_of, scene_of(*MATT_ROOM, sun=SUN), "sun", DIRECT_ONLY)
    expected = reference(MATT_ROOM, sun_of(SUN), DIRECT, 4)
    assert np.median(errors(0.9 * picture, expected, away_from_edges(basis))) == pytest.approx(0.1, abs=0.01)
