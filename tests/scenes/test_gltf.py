"""glTF files written by hand: what stands where, of what, and lit by what."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest

from renderers.lights import BulbLight
from scenes.errors import SceneError
from scenes.gltf.document import read
from scenes.gltf.importer import load

TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 0, -1]]  # on glTF's floor, counter-clockwise seen from above
QUARTER_ABOUT_Y = [0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5)]


def normal_of(surface):
    a, b, c = surface.vertices[surface.triangles[0]]
    n = np.cross(b - a, c - a)
    return n / np.linalg.norm(n)


def test_y_up_becomes_z_up_and_front_stays_front(glb, tmp_path):
    glb.node(name="t", mesh=glb.mesh(TRIANGLE, [0, 1, 2]))
    (surface,) = load(glb.save(tmp_path / "a.glb")).surfaces
    np.testing.assert_allclose(surface.vertices, [[0, 0, 0], [1, 0, 0], [0, 1, 0]], atol=1e-7)
    np.testing.assert_allclose(normal_of(surface), [0, 0, 1], atol=1e-7)


def test_children_are_scaled_turned_and_moved_with_their_parents(glb, tmp_path):
    """By hand: scale by 2, turn 90° about y (x to −z), move by (10, 0, 0); the parent lifts by 3."""
    child = glb.node(
        False, name="c", mesh=glb.mesh(TRIANGLE, [0, 1, 2]), translation=[10, 0, 0], rotation=QUARTER_ABOUT_Y,
        scale=[2, 2, 2],
    )  # fmt: skip
    glb.node(name="p", children=[child], matrix=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 3, 0, 1])
    (surface,) = load(glb.save(tmp_path / "a.glb")).surfaces
    # glTF: (1,0,0) → (2,0,0) → (0,0,−2) → (10,3,−2); in our axes (10, 2, 3)
    np.testing.assert_allclose(surface.vertices, [[10, 0, 3], [10, 2, 3], [8, 0, 3]], atol=1e-6)
    np.testing.assert_allclose(normal_of(surface), [0, 0, 1], atol=1e-7)


def test_a_mirrored_node_keeps_its_front_and_an_uneven_scale_its_normals(glb, tmp_path):
    slope = np.array([[0, 0, 0], [1, 1, 0], [0, 0, -1]], dtype=float)
    own = np.cross(slope[1] - slope[0], slope[2] - slope[0])
    # half tilted away from the flat normal, so that they are kept
    normals = [own / np.linalg.norm(own), [0, 1, 0], own / np.linalg.norm(own)]
    glb.node(name="m", mesh=glb.mesh(slope, [0, 1, 2], NORMAL=normals), scale=[-2, 1, 1])
    (surface,) = load(glb.save(tmp_path / "a.glb")).surfaces
    assert normal_of(surface)[2] > 0
    np.testing.assert_allclose(surface.normals[0], normal_of(surface), atol=1e-6)
    np.testing.assert_allclose(surface.normals[1], [0, 0, 1], atol=1e-6)


@pytest.mark.parametrize("mode, corners", [(5, [0, 1, 2, 3]), (6, [0, 1, 3, 2])])
def test_strips_and_fans_are_the_same_square_as_a_list(glb, tmp_path, mode, corners):
    square = [[0, 0, 0], [1, 0, 0], [0, 0, -1], [1, 0, -1]]
    mesh = glb.mesh(square, corners)
    glb.json["meshes"][mesh]["primitives"][0]["mode"] = mode
    glb.node(name="s", mesh=mesh)
    (surface,) = load(glb.save(tmp_path / "a.glb")).surfaces
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    area = 0.5 * np.cross(b - a, c - a)
    np.testing.assert_allclose(area, [[0, 0, 0.5]] * 2, atol=1e-7)


def test_accessors_interleaved_normalised_and_sparse(glb, tmp_path):
    data = struct.pack("<4B4B", 0, 128, 255, 9, 255, 0, 64, 9)
    glb.json["accessors"].append(
        {"bufferView": glb.view(data), "byteOffset": 1, "componentType": 5121, "count": 2, "type": "VEC2",
         "normalized": True}
    )  # fmt: skip
    glb.json["bufferViews"][-1]["byteStride"] = 4
    where, what = glb.view(struct.pack("<H", 2)), glb.view(struct.pack("<f", 7.0))
    glb.json["accessors"].append(
        {"componentType": 5126, "count": 4, "type": "SCALAR",
         "sparse": {"count": 1, "indices": {"bufferView": where, "componentType": 5123},
                    "values": {"bufferView": what}}}
    )  # fmt: skip
    document = read(glb.save(tmp_path / "a.glb"))
    np.testing.assert_allclose(document.accessor(0, "x"), [[128 / 255, 1], [0, 64 / 255]])
    np.testing.assert_array_equal(document.accessor(1, "x"), [0, 0, 7, 0])


def test_a_point_light_of_x_candela_gives_x_over_d_squared(glb, tmp_path):
    glb.quad("floor", (0, 0, 0), (1, 0, 0), (0, 1, 0))
    glb.node(name="l", translation=[1, 2, -3], extensions=glb.light(type="point", intensity=90.0))
    (bulb,) = load(glb.save(tmp_path / "a.glb")).bulbs
    assert bulb.position == pytest.approx((1, 3, 2))
    light = BulbLight("l", 0, bulb.position, bulb.radius, bulb.aim, bulb.photometry)
    _, lux, _ = light.arriving(np.float32([[1, 3, 0]]), np.float32([[0, 0, 1]]))
    assert lux[0] * bulb.lumen == pytest.approx(90 / 2**2, rel=1e-5)


def test_a_spot_shines_along_minus_z_of_its_node_as_the_extension_says(glb, tmp_path):
    glb.quad("floor", (0, 0, 0), (1, 0, 0), (0, 1, 0))
    cone = {"innerConeAngle": 0.2, "outerConeAngle": 0.5}
    # −z turned by −90° about x points down
    node = {"translation": [0, 2, 0], "rotation": [-np.sqrt(0.5), 0, 0, np.sqrt(0.5)]}
    glb.node(name="s", **node, extensions=glb.light(type="spot", intensity=50.0, spot=cone))
    (bulb,) = load(glb.save(tmp_path / "a.glb")).bulbs
    light = BulbLight("s", 0, bulb.position, bulb.radius, bulb.aim, bulb.photometry)
    angles = np.array([0.0, 0.15, 0.35, 0.55])
    points = np.stack([2 * np.tan(angles), 0 * angles, 0 * angles], axis=-1).astype(np.float32)
    _, lux, _ = light.arriving(points, np.tile(np.float32([0, 0, 1]), (4, 1)))
    edge = (np.cos(0.35) - np.cos(0.5)) / (np.cos(0.2) - np.cos(0.5))
    candela = lux * bulb.lumen * (2 / np.cos(angles)) ** 2
    np.testing.assert_allclose(candela, [50, 50, 50 * edge**2, 0], rtol=2e-3)


def test_a_directional_light_is_the_sun_that_it_comes_from(glb, tmp_path):
    glb.quad("floor", (0, 0, 0), (1, 0, 0), (0, 1, 0))
    # −z tipped down by 30° about x, then turned by 90° about y to −x: it comes from the east
    s, c = np.sqrt(0.5) * np.sin(np.radians(-15)), np.sqrt(0.5) * np.cos(np.radians(-15))
    glb.node(name="s", rotation=[s, c, -s, c], extensions=glb.light(type="directional", intensity=700.0))
    (sun,) = load(glb.save(tmp_path / "a.glb")).suns
    assert (sun.lux, sun.azimuth_deg, sun.elevation_deg) == pytest.approx((700, 90, 30), abs=1e-4)


def test_factors_textures_and_specular_strength_are_read(glb, tmp_path):
    picture = np.arange(2 * 3 * 3, dtype=np.uint8).reshape(2, 3, 3)
    texture = {"index": glb.texture(picture, wrap=33648)}
    pbr = {"baseColorFactor": [0.5, 0.25, 1, 1], "roughnessFactor": 0.3, "baseColorTexture": texture}
    material = glb.material(
        name="m", pbrMetallicRoughness=pbr, extensions={"KHR_materials_specular": {"specularFactor": 0.4}}
    )
    glb.quad("q", (0, 0, 0), (1, 0, 0), (0, 1, 0), material)
    (surface,) = load(glb.save(tmp_path / "a.glb")).surfaces
    m = surface.material
    assert (m.base_color, m.roughness, m.metallic, m.specular) == ((0.5, 0.25, 1.0), 0.3, 1.0, 0.4)
    base = surface.textures.base_color
    np.testing.assert_array_equal(base.texels, picture)
    assert base.srgb and base.wrap == ("mirror", "mirror") and surface.textures.normal is None


def test_a_texture_transform_moves_turns_and_scales_coordinates(glb, tmp_path):
    moved = {"KHR_texture_transform": {"offset": [0.5, 0.25], "rotation": np.pi / 2, "scale": [2, 3]}}
    texture = {"index": glb.texture(np.zeros((1, 1, 3), dtype=np.uint8)), "extensions": moved}
    material = glb.material(pbrMetallicRoughness={"baseColorTexture": texture})
    glb.quad("q", (0, 0, 0), (1, 0, 0), (0, 1, 0), material)
    (surface,) = load(glb.save(tmp_path / "a.glb")).surfaces
    # the extension's matrix turns (u, 0) to (0, −u) and (0, v) to (v, 0)
    np.testing.assert_allclose(surface.uv, [[3.5, 0.25], [3.5, -1.75], [0.5, -1.75], [0.5, 0.25]], atol=1e-6)


def test_glass_and_cut_out_texels_are_left_out(glb, tmp_path):
    leaf = np.full((4, 4, 4), 255, dtype=np.uint8)
    leaf[:, 2:, 3] = 0
    look = {"baseColorTexture": {"index": glb.texture(leaf)}}
    cut = glb.material(alphaMode="MASK", pbrMetallicRoughness=look)
    glass = glb.material(alphaMode="BLEND", pbrMetallicRoughness={"baseColorFactor": [1, 1, 1, 0.2]})
    pane = glb.material(extensions={"KHR_materials_transmission": {"transmissionFactor": 1.0}})
    glb.quad("glass", (0, 0, 0), (1, 0, 0), (0, 1, 0), glass)
    glb.quad("pane", (0, 0, 0), (1, 0, 0), (0, 1, 0), pane)
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [2, 0, 0], [3, 0, 0], [3, 1, 0]]
    uv = [[0, 1], [0.4, 1], [0.4, 0], [0.6, 1], [1, 1], [1, 0]]
    glb.node(name="leaf", mesh=glb.mesh(points, [[0, 1, 2], [3, 4, 5]], cut, TEXCOORD_0=uv))
    (surface,) = load(glb.save(tmp_path / "a.glb")).surfaces
    assert surface.name == "leaf"
    np.testing.assert_array_equal(surface.triangles, [[0, 1, 2]])


def test_a_two_sided_sheet_gets_a_back_and_a_closed_solid_does_not(glb, tmp_path):
    both = glb.material(doubleSided=True)
    glb.quad("sheet", (0, 0, 0), (2, 0, 0), (0, 1, 0), both)
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    apart = corners[np.array(faces)].reshape(-1, 3)  # as files store it: corners of their own for each face
    glb.node(name="solid", mesh=glb.mesh(apart, np.arange(12), both))
    sheet, solid = load(glb.save(tmp_path / "a.glb")).surfaces
    assert len(solid.triangles) == 4
    a, b, c = (sheet.vertices[sheet.triangles[:, k]] for k in range(3))
    np.testing.assert_allclose(np.cross(b - a, c - a).sum(axis=0), 0, atol=1e-7)
    assert len(sheet.triangles) == 4 and -0.01 < sheet.vertices[4:, 2].max() < 0


def test_a_large_picture_is_reduced_and_said_so(glb, tmp_path):
    wide = np.zeros((2, 5000, 3), dtype=np.uint8)
    look = {"baseColorTexture": {"index": glb.texture(wide)}}
    glb.quad("q", (0, 0, 0), (1, 0, 0), (0, 1, 0), glb.material(name="wall", pbrMetallicRoughness=look))
    found = load(glb.save(tmp_path / "a.glb"))
    assert found.surfaces[0].textures.base_color.texels.shape == (2, 4096, 3)
    assert found.notices == ("texture of material 'wall': 5000 × 2 texels, reduced to 4096 × 2",)


@pytest.mark.parametrize("size, text", [(0.02, "0.02 × 0.02 × 0 m"), (3000, "3e+03 × 3e+03 × 0 m")])
def test_an_absurd_size_is_named(glb, tmp_path, size, text):
    glb.quad("q", (0, 0, 0), (size, 0, 0), (0, size, 0))
    (notice,) = load(glb.save(tmp_path / "a.glb")).notices
    assert text in notice


def test_a_hall_in_centimetres_is_named_by_its_height(glb, tmp_path):
    """Ground planes may be as wide as an 8 m hall in centimetres, but nothing is as tall."""
    glb.quad("ground", (0, 0, 0), (800, 0, 0), (0, 600, 0))
    assert load(glb.save(tmp_path / "ground.glb")).notices == ()
    glb.quad("wall", (0, 0, 0), (800, 0, 0), (0, 0, 250))
    (notice,) = load(glb.save(tmp_path / "hall.glb")).notices
    assert "measures 800 × 600 × 250 m" in notice


def gltf_without_buffer(glb, folder):
    glb.quad("q", (0, 0, 0), (1, 0, 0), (0, 1, 0))
    glb.json["buffers"][0] |= {"uri": "q.bin", "byteLength": len(glb.data)}
    (folder / "a.gltf").write_text(json.dumps(glb.json))
    return folder / "a.gltf"


def test_a_gltf_reads_the_buffer_beside_it(glb, tmp_path):
    path = gltf_without_buffer(glb, tmp_path)
    (tmp_path / "q.bin").write_bytes(glb.data)
    (surface,) = load(path).surfaces
    assert len(surface.triangles) == 2
    assert read(path).files() == ("q.bin",)


def no_file(glb, folder):
    return folder / "none.glb"


def cut_short(glb, folder):
    path = glb.save(folder / "a.glb")
    path.write_bytes(path.read_bytes()[:-30])
    return path


def text_file(glb, folder):
    (folder / "a.glb").write_text("hello")
    return folder / "a.glb"


def version_1(glb, folder):
    glb.json["asset"]["version"] = "1.0"
    return glb.save(folder / "a.glb")


def compressed(glb, folder):
    glb.json["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    return glb.save(folder / "a.glb")


def without_faces(glb, folder):
    glb.node(name="empty")
    return glb.save(folder / "a.glb")


def missing_texture(glb, folder):
    texture = glb.texture(np.zeros((2, 2, 3), dtype=np.uint8))
    glb.json["images"][0] = {"uri": "wood.png"}
    look = {"baseColorTexture": {"index": texture}}
    glb.quad("q", (0, 0, 0), (1, 0, 0), (0, 1, 0), glb.material(name="planks", pbrMetallicRoughness=look))
    return glb.save(folder / "a.glb")


def broken_texture(glb, folder):
    (folder / "wood.png").write_text("no picture")
    return missing_texture(glb, folder)


def index_beyond(glb, folder):
    glb.node(name="t", mesh=glb.mesh(TRIANGLE, [0, 1, 3]))
    return glb.save(folder / "a.glb")


def loop_of_nodes(glb, folder):
    glb.node(name="snake", children=[0])
    return glb.save(folder / "a.glb")


def short_view(glb, folder):
    glb.node(name="t", mesh=glb.mesh(TRIANGLE, [0, 1, 2]))
    glb.json["accessors"][0]["count"] = 9
    return glb.save(folder / "a.glb")


def nonsense(glb, folder):
    glb.node(name="t", mesh=glb.mesh(TRIANGLE, [0, 1, 2]), translation="far")
    return glb.save(folder / "a.glb")


@pytest.mark.parametrize(
    "make, says",
    [
        (no_file, "none.glb: not found"),
        (cut_short, "cut short"),
        (text_file, "no glTF file"),
        (version_1, "version 1.0"),
        (compressed, "KHR_draco_mesh_compression"),
        (without_faces, "no faces"),
        (gltf_without_buffer, "q.bin: not found"),
        (missing_texture, "material 'planks'"),
        (missing_texture, "wood.png: not found"),
        (broken_texture, "wood.png cannot be decoded"),
        (index_beyond, "beyond its 3 vertices"),
        (loop_of_nodes, "'snake' is its own ancestor"),
        (short_view, "too short for 9 values"),
        (nonsense, "malformed"),
    ],
)
def test_bad_files_are_refused_in_one_line(glb, tmp_path: Path, make, says):
    path = make(glb, tmp_path)
    with pytest.raises(SceneError) as error:
        load(path)
    assert str(path) in str(error.value) and says in str(error.value) and "\n" not in str(error.value)
