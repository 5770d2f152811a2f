"""A scene out of the user's own file, from the command line to the tour; files written by hand."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bench.another_place import in_scene
from bench.cli import execute
from bench.own_scene.build import build
from bench.study import load, parse
from scenes.errors import SceneError
from scenes.occupancy import true_occupancy

pytestmark = pytest.mark.usefixtures("cache_home")

STUDY = """
sequence: rendered
name: own
engine: raycast
illuminations: {{sun_lux: [20000], bulb_lm: [800]}}
camera: {{width: 64, height: 48}}
scene: {{file: {file}}}
"""


def hall(glb, width=6.0, depth=4.0, level=0.4):
    """A hall with a sky of its own: walls, a box in the middle of its floor, a lamp."""

    def wall(name, start, along, height):
        glb.quad(name, (*start, level), (*along, 0), (0, 0, height))

    glb.quad("ground", (0, 0, level), (width, 0, 0), (0, depth, 0))
    wall("south", (width, 0), (-width, 0), 2.5)
    wall("north", (0, depth), (width, 0), 2.5)
    wall("west", (0, 0), (0, depth), 2.5)
    wall("east", (width, depth), (0, -depth), 2.5)
    x, y = width / 2, depth / 2
    wall("box south", (x - 0.3, y - 0.3), (0.6, 0), 1.0)
    wall("box east", (x + 0.3, y - 0.3), (0, 0.6), 1.0)
    wall("box north", (x + 0.3, y + 0.3), (-0.6, 0), 1.0)
    wall("box west", (x - 0.3, y + 0.3), (0, -0.6), 1.0)
    lamp = {"translation": [x, level + 2.2, -1.0], "extensions": glb.light(type="point", intensity=60.0)}
    glb.node(name="lamp", **lamp)
    return glb


def study_of(path: Path, **keys: object):
    return parse(STUDY.format(file=json.dumps({"path": str(path), **keys})), "own.yaml")


def test_a_planned_round_keeps_clear_of_walls_and_boxes_and_comes_back(glb, tmp_path):
    study = study_of(hall(glb).save(tmp_path / "hall.glb"), laps=1.0)
    scene = build(study)
    x, y, heading = scene.tour.poses.T
    radius = study.navigation.robot_radius_m
    assert (x > radius).all() and (x < 6 - radius).all() and (y > radius).all() and (y < 4 - radius).all()
    assert (np.maximum(abs(x - 3), abs(y - 2)) > 0.3 + radius / np.sqrt(2)).all()
    assert np.hypot(x[-1] - x[0], y[-1] - y[0]) < 0.5
    assert np.ptp(x) > 2 and np.ptp(y) > 1
    assert np.abs(np.diff(heading)).max() < 0.7
    blocked = true_occupancy(scene, 0.1)
    cells = np.floor((scene.tour.poses[:, :2] - blocked.origin) / 0.1).astype(int)
    assert not blocked.blocked[cells[:, 1], cells[:, 0]].any()


def test_floor_lamps_and_discs_stand_on_zero(glb, tmp_path):
    scene = build(study_of(hall(glb).save(tmp_path / "hall.glb")))
    floor = next(s for s in scene.surfaces if s.name == scene.floor)
    assert scene.floor == "ground" and np.abs(floor.vertices[:, 2]).max() < 1e-9
    assert scene.bulbs[0].position == pytest.approx((3, 1, 2.2))
    assert len(scene.landmarks) >= 8
    for mark in scene.landmarks:
        x, y = mark.position
        assert mark.radius < x < 6 - mark.radius and mark.radius < y < 4 - mark.radius
        assert max(abs(x - 3), abs(y - 2)) > 0.3 + mark.radius / np.sqrt(2)
    edges = np.concatenate([np.diff(s.vertices[s.triangles], axis=1).reshape(-1, 3) for s in scene.surfaces])
    assert np.linalg.norm(edges, axis=1).max() <= 0.4 + 1e-9


def test_the_same_seed_gives_the_same_discs(glb, tmp_path):
    study = study_of(hall(glb).save(tmp_path / "hall.glb"))
    other = study.model_copy(update={"scene": study.scene.model_copy(update={"seed": 5})})
    assert build(study).landmarks == build(study).landmarks != build(other).landmarks


def test_way_points_landmarks_and_sun_of_the_study(glb, tmp_path):
    path = hall(glb).save(tmp_path / "hall.glb")
    way, discs = [[1, 1], [5, 1], [5, 3]], [[2, 3, 0.15, "white"], [4, 3, 0.1, "black"]]
    scene = build(study_of(path, tour=way, closed=False, landmarks=discs, sun_azimuth_deg=90.0))
    np.testing.assert_allclose(scene.tour.poses[0], [1, 1, 0], atol=1e-6)
    end = scene.tour.poses[-1]
    assert np.hypot(end[0] - 5, end[1] - 3) < 0.4 and end[2] == pytest.approx(np.pi / 2, abs=0.05)
    assert [(m.position, m.radius, m.white) for m in scene.landmarks] == [
        ((2, 3), 0.15, True),
        ((4, 3), 0.1, False),
    ]
    assert scene.suns[0].azimuth_deg == 90


def test_nodes_mark_way_points_and_landmarks(glb, tmp_path):
    hall(glb)
    for k, (x, y) in enumerate([(1, 1), (5, 1), (5, 3), (1, 3)]):
        glb.node(name=f"tour{k + 7}", translation=[x, 0.4, -y])
    glb.node(name="Landmark a", translation=[2, 0.4, -1])
    glb.node(name="landmark black", translation=[4, 0.4, -3], scale=[1.2, 1.2, 1.2])
    scene = build(study_of(glb.save(tmp_path / "hall.glb")))
    assert np.hypot(*(scene.tour.poses[0, :2] - (1, 1))) < 0.4
    assert [m.white for m in scene.landmarks] == [True, False]
    assert scene.landmarks[1].radius == pytest.approx(0.18)
    assert scene.landmarks[1].position == pytest.approx((4, 3))


def test_a_tour_through_a_box_says_where(glb, tmp_path):
    path = hall(glb).save(tmp_path / "hall.glb")
    with pytest.raises(SceneError, match=r"no room at \(2\.4\d, 2\.00\) m"):
        build(study_of(path, tour=[[1, 2], [5, 2]], closed=False))


def test_scene_option_takes_a_name_or_a_file(glb, tmp_path):
    path = hall(glb).save(tmp_path / "Great Hall 2.glb")
    study = in_scene(load("quick"), str(path))
    assert (study.scene.name, study.scene.file.path, study.scene.seed) == ("great-hall-2", str(path), 7)
    assert study.illuminations.bulb_lm[0] == pytest.approx(100 * 60 * 4 * np.pi / 800, rel=1e-3)
    assert in_scene(study, "corridor").scene.file is None
    assert in_scene(study, None) == in_scene(study, str(path)) == study


def with_missing_texture(glb, path):
    texture = glb.texture(np.zeros((2, 2, 3), dtype=np.uint8))
    glb.json["images"][0] = {"uri": "wood.png"}
    look = {"baseColorTexture": {"index": texture}}
    glb.quad("q", (0, 0, 0), (4, 0, 0), (0, 4, 0), glb.material(name="planks", pbrMetallicRoughness=look))
    return glb.save(path)


@pytest.mark.parametrize(
    "make, keys, says",
    [
        (None, {}, "scene.glb: not found"),
        (with_missing_texture, {}, "wood.png: not found"),
        (lambda glb, path: glb.save(path), {}, "holds no faces"),
        (lambda glb, path: hall(glb).save(path), {"floor": "cellar"}, "floor 'cellar' is none"),
        (lambda glb, path: hall(glb).save(path), {"tour": [[1, 2], [5, 2]]}, "no room at (2."),
        (lambda glb, path: hall(glb).save(path), {"tour": [[1, 2]]}, "two way-points"),
        (
            lambda glb, path: hall(glb).save(path),
            {"landmarks": [[9, 9, 0.1, "white"]]},
            "not lie on free floor",
        ),
        (lambda glb, path: hall(glb).save(path), {"landmarks": [[1, 1, 0.1, "red"]]}, "'white' or 'black'"),
        (lambda glb, path: hall(glb).save(path), {"colour": 1}, "unknown key"),
        (lambda glb, path: hall(glb, 0.3, 0.3).save(path), {}, "no floor"),
        (lambda glb, path: hall(glb, 1.2, 1.2).save(path), {}, "no room for a robot"),
    ],
)
def test_bad_scenes_are_one_line_and_exit_code_2(glb, tmp_path, capsys, make, keys, says):
    path = tmp_path / "scene.glb"
    if make:
        make(glb, path)
    study = tmp_path / "own.yaml"
    study.write_text(STUDY.format(file=json.dumps({"path": str(path), **keys})))
    out = tmp_path / "out"
    assert execute(["run", "--study", str(study), "--out", str(out)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and error.startswith("error: ") and says in error
    assert not out.exists() or not any(out.iterdir())


@pytest.mark.parametrize(
    "scene, says", [("hall.obj", "no .glb or .gltf"), ("coridor", "did you mean 'corridor'")]
)
def test_what_is_no_scene_is_refused(capsys, scene, says):
    assert execute(["generate", "--scene", scene, "--out", "never"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and says in error


def test_a_file_is_generated_end_to_end(glb, tmp_path, capsys):
    """One small frame: it shows floor and walls, the notices are said once, the names are the file's."""
    path = hall(glb).save(tmp_path / "hall.glb")
    study = tmp_path / "own.yaml"
    study.write_text(STUDY[: STUDY.index("scene:")].format())
    out = tmp_path / "out"
    arguments = ["generate", "--study", str(study), "--scene", str(path), "--frames", "1", "--out", str(out)]
    assert execute(arguments) == 0
    assert capsys.readouterr().err.count("lamps give") == 1
    assert [p.name for p in (out / "tum").iterdir()] == ["hall"]
    assert len(list(out.glob("tum/hall/*/rgb/*.png"))) == 1
