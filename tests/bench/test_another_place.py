"""Studies in other places: which scene is built, and how strong its lamps are."""

from __future__ import annotations

import pytest

from bench.another_place import in_scene
from bench.cli import execute
from bench.errors import BenchError
from bench.sequences.rendered import load_scene
from bench.study import load, parse
from scenes import library


@pytest.fixture(scope="module")
def quick():
    return load("quick")


def positions(scene):
    return [m.position for m in scene.landmarks]


def test_another_scene_keeps_the_study_and_its_lamps_in_proportion(quick):
    """The quick study has lamps of an eighth, half and twice the corridor's 800 lm."""
    there = in_scene(quick, "warehouse")
    assert there.illuminations.bulb_lm == (2500.0, 10_000.0, 40_000.0)  # of high bays of 20,000 lm
    assert there.illuminations.sun_lux == quick.illuminations.sun_lux
    assert there.scene.name == "warehouse" and there.scene.seed == quick.scene.seed
    same = {"scene", "illuminations"}
    assert there.model_dump(exclude=same) == quick.model_dump(exclude=same)


def test_the_same_scene_changes_nothing(quick):
    assert in_scene(quick, quick.scene.name) == quick == in_scene(quick)


def test_parameters_belong_to_their_scene(quick):
    study = quick.model_copy(
        update={"scene": quick.scene.model_copy(update={"name": "tabletop", "parameters": {"objects": 3}})}
    )
    assert in_scene(study, "tabletop").scene.parameters == {"objects": 3}
    assert in_scene(study, "office").scene.parameters == {}


def test_split_counts_its_own_scenes(quick):
    """Seeds 0, 1 … of the test split are the builder's 1, 4 …; without a split the seed is the builder's."""
    tested = in_scene(quick, "tabletop", "test", seed=1)
    assert positions(load_scene(tested)) == positions(library.load("tabletop", seed=4))
    plain = in_scene(quick, "tabletop", seed=4)
    assert positions(load_scene(plain)) == positions(library.load("tabletop", seed=4))
    trained = in_scene(quick, "tabletop", "train", seed=1)
    assert positions(load_scene(trained)) == positions(library.load("tabletop", seed=3))


def test_split_in_a_study_file():
    text = "sequence: rendered\nname: mine\nscene: {{name: office, split: {}}}\n"
    assert parse(text.format("validation"), "mine.yaml").scene.split == "validation"
    with pytest.raises(BenchError, match=r"mine.yaml: scene\.split"):
        parse(text.format("exam"), "mine.yaml")


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["run", "--scene", "atrum"], "unknown scene 'atrum': did you mean 'atrium'?"),
        (["run", "--split", "exam"], "'exam' is not one of"),
        (["run", "--study", "dlr", "--scene", "atrium"], "--scene: study 'dlr' has no scene to replace"),
        (["run", "--study", "backends", "--split", "test"], "--split: study 'backends' has no scene"),
        (["run", "--study", "drive", "--scene", "office"], "--scene: study 'drive' is made for its scene"),
        (
            ["generate", "--out", "x", "--study", "dlr", "--split", "test"],
            "study 'dlr' is not of one rendered scene",
        ),
        (["preview", "atrum"], "unknown scene 'atrum': did you mean 'atrium'?"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_wrong_places_end_in_one_line(capsys, arguments, expected):
    assert execute(arguments) == 2
    complaint = capsys.readouterr().err
    assert expected in complaint and complaint.count("\n") == 1


def test_scenes_are_listed_with_a_line_each(capsys):
    assert execute(["list", "scenes"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == library.names()
    assert all(line.endswith(".") for line in lines)
