"""Closed loop in little: rooms out of hand-made files, small pictures, and what a drive can come to."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench import runner
from bench.drive import scores
from bench.drive.closed_loop import ClosedLoop, Drive
from bench.drive.episode import Episode, draw
from bench.drive.world import TrueWorld, arc
from bench.drive_run import only
from bench.errors import BenchError
from bench.kinds.drive import ClosedLoopStudy
from bench.options import RunOptions
from bench.progress import Silent
from bench.schema import DRIVE_COLUMNS
from bench.sequences.lighting import light_colours
from bench.sequences.rendered import RenderedSequence, SequenceSetup
from bench.study import parse
from renderers.irradiance import BakeQuality
from reports import html, terminal
from scenes.occupancy import TrueOccupancy, true_occupancy
from vslam.follower import Command
from vslam.motion import move

pytestmark = pytest.mark.usefixtures("cache_home")

QUIET = dict.fromkeys(
    (
        f"sigma_{part}"
        for part in ("forward_m_per_m", "lateral_m_per_m", "heading_rad_per_rad", "heading_rad_per_m")
    ),
    0.0,
)


def room(glb: Any, path: Path, width: float, depth: float, box: bool = False) -> Path:
    """Four walls, a lamp, and a box in the middle if wanted."""

    def wall(name: str, start: tuple[float, float], along: tuple[float, float], height: float = 2.5) -> None:
        glb.quad(name, (*start, 0.0), (*along, 0.0), (0.0, 0.0, height))

    glb.quad("ground", (0, 0, 0), (width, 0, 0), (0, depth, 0))
    wall("south", (width, 0), (-width, 0))
    wall("north", (0, depth), (width, 0))
    wall("west", (0, 0), (0, depth))
    wall("east", (width, depth), (0, -depth))
    if box:
        x, y = width / 2, depth / 2
        wall("box south", (x - 0.5, y - 0.5), (1.0, 0), 1.0)
        wall("box east", (x + 0.5, y - 0.5), (0, 1.0), 1.0)
        wall("box north", (x + 0.5, y + 0.5), (-1.0, 0), 1.0)
        wall("box west", (x - 0.5, y + 0.5), (0, -1.0), 1.0)
    glb.node(
        name="lamp",
        translation=[width / 2, 2.2, -depth / 2],
        extensions=glb.light(type="point", intensity=90.0),
    )
    return glb.save(path / "room.glb")


def study_of(file: Path, tour: list[list[float]], **changes: Any) -> ClosedLoopStudy:
    content = {
        "sequence": "drive",
        "name": "little",
        "seed": 5,
        "engine": "raycast",
        "scene": {"file": {"path": str(file), "tour": tour, "landmarks": []}},
        "camera": {"width": 80, "height": 60},
        "illuminations": {"sun_lux": [0], "bulb_lm": [1000]},
        "navigation": {"pairs": 1},
        "seeds": 1,
        "drive": {"min_distance_m": 3.0, "explorations": 1, "explore_s": 40},
    }
    return ClosedLoopStudy.model_validate(content | changes)


def loop_of(study: ClosedLoopStudy, cache: Path) -> ClosedLoop:
    light = study.lights()[0]
    setup = SequenceSetup(
        only(study, light),
        "raycast",
        light_colours(study),
        1,
        cache,
        BakeQuality(16, 4, 0),
        cached_shadows=True,
    )
    sequence = RenderedSequence(setup)
    return ClosedLoop(sequence, true_occupancy(sequence.scene, 0.1), light)


def episode(
    start: tuple[float, float, float], *places: tuple[float, float], optimum_m: float = 10.0
) -> Episode:
    pose = np.array(start)
    return Episode("goal", 0, pose, pose, np.array(places, dtype=float).reshape(-1, 2), optimum_m)


def row(study: ClosedLoopStudy, one: Episode, drive: Drive) -> dict[str, object]:
    return scores.row(study, "room", study.lights()[0], "none", one, drive)


@pytest.fixture
def boxed(glb: Any, tmp_path: Path) -> ClosedLoopStudy:
    """A room of 7 m × 5 m with a box in its middle."""
    return study_of(room(glb, tmp_path, 7, 5, box=True), [[1, 1], [6, 1], [6, 4], [1, 4]])


def test_an_empty_room_without_noise_is_crossed_there_and_back_on_the_shortest_way(
    glb: Any, tmp_path: Path
) -> None:
    study = study_of(
        room(glb, tmp_path, 7, 4),
        [[1, 1], [6, 1], [6, 3], [1, 3]],
        odometry=QUIET,
        depth={"sigma_m_at_1m": 0.0},
    )
    one = episode((1.0, 1.0, 2.0), (6.0, 3.0), (1.0, 1.0), optimum_m=2 * float(np.hypot(5, 2)))
    drive = loop_of(study, tmp_path).drive(one, study.filters[0])
    assert drive.outcome == "arrived" and len(drive.goal_errors_m) == 2
    assert max(drive.goal_errors_m) < 0.1
    told = row(study, one, drive)
    assert told["success"] == 1 and told["collision"] == 0
    assert 0.97 < float(str(told["spl"])) <= 1.0
    assert float(str(told["error_max_m"])) < 1e-6  # without noise odometry is the truth
    assert list(told) == list(DRIVE_COLUMNS)


def test_a_kidnapped_robot_is_a_scored_failure(glb: Any, tmp_path: Path) -> None:
    study = study_of(room(glb, tmp_path, 7, 4), [[1, 1], [6, 1], [6, 3], [1, 3]])
    one = replace(episode((1.5, 2.0, 0.0), (5.0, 2.0)), believed_start=np.array([3.0, 2.0, 0.0]))
    drive = loop_of(study, tmp_path).drive(one, study.filters[0])
    assert drive.outcome == "lost"
    assert drive.goal_errors_m[0] == pytest.approx(1.5, abs=0.3)
    told = row(study, one, drive)
    assert told["success"] == 0 and told["spl"] == 0.0


def test_twenty_metres_without_a_landmark_are_driven_by_odometry(glb: Any, tmp_path: Path) -> None:
    study = study_of(
        room(glb, tmp_path, 24, 3), [[1, 1], [23, 1], [23, 2], [1, 2]], camera={"width": 48, "height": 36}
    )
    one = episode((1.5, 1.5, 0.0), (22.5, 1.5), optimum_m=21.0)
    drive = loop_of(study, tmp_path).drive(one, study.filters[0])
    assert drive.landmarks_mapped == 0 and drive.driven_m > 20
    sigma = np.array([m.sigma_m for m in drive.moments])
    assert (np.diff(sigma) >= 0).all() and sigma[0] == 0
    # 56 steps of 0.372 m: heading 0.0047 rad/m, so sideways σ = 0.00175 · 21 · √(56 / 3), and 2.3 % each way
    sideways, step = 0.0047 * 0.372 * 21 * np.sqrt(56 / 3), 0.372 * np.sqrt(56)
    assert sigma[-1] == pytest.approx(np.hypot(sideways, np.hypot(0.023, 0.024) * step), rel=0.15)
    error = np.hypot(*(drive.moments[-1].true - drive.moments[-1].believed)[:2])
    assert 0 < error < 3 * sigma[-1]
    assert drive.outcome == ("arrived" if drive.goal_errors_m[0] <= 0.3 else "lost")


def test_a_goal_in_the_box_leaves_the_robot_stuck_and_unhurt(boxed: ClosedLoopStudy, tmp_path: Path) -> None:
    one = episode((1.0, 1.0, 0.5), (3.5, 2.5))
    drive = loop_of(boxed, tmp_path).drive(one, boxed.filters[0])
    assert drive.outcome == "stuck"
    assert row(boxed, one, drive)["goal_error_m"] is not None


def test_a_start_in_a_wall_is_a_collision_before_the_first_picture(
    boxed: ClosedLoopStudy, tmp_path: Path
) -> None:
    one = episode((3.5, 2.5, 0.0), (1.0, 1.0))
    drive = loop_of(boxed, tmp_path).drive(one, boxed.filters[0])
    told = row(boxed, one, drive)
    assert (drive.outcome, told["pictures"], told["path_m"], told["spl"]) == ("collision", 0, 0.0, 0.0)


def test_the_box_is_met_by_a_robot_that_is_deceived_about_where_it_stands(
    boxed: ClosedLoopStudy, tmp_path: Path
) -> None:
    """Its depth shows the box where it is from the robot, so it goes round it, wherever it believes to be."""
    one = replace(episode((1.5, 2.5, 0.0), (5.5, 2.5)), believed_start=np.array([1.5, 2.6, 0.0]))
    drive = loop_of(boxed, tmp_path).drive(one, boxed.filters[0])
    assert drive.outcome == "arrived" and drive.driven_m > 4.05


def test_a_map_without_free_space_is_one_line(boxed: ClosedLoopStudy) -> None:
    full = TrueOccupancy(np.ones((50, 50), dtype=bool), np.zeros(2), 0.1)
    with pytest.raises(BenchError, match="no free cell in the true map"):
        draw(boxed, full)


def test_episodes_are_the_same_for_a_study_with_more_of_them(boxed: ClosedLoopStudy) -> None:
    free = np.zeros((50, 70), dtype=bool)
    free[[0, -1]] = free[:, [0, -1]] = True
    place = TrueOccupancy(free, np.zeros(2), 0.1)
    more = boxed.model_copy(update={"navigation": boxed.navigation.model_copy(update={"pairs": 3})})
    few, many = draw(boxed, place), draw(more, place)
    assert [e.task for e in few] == ["goal", "explore"] and len(many) == 4
    np.testing.assert_array_equal(few[0].start, many[0].start)
    np.testing.assert_array_equal(few[1].start, many[3].start)
    assert few[0].optimum_m >= 2 * 3.0
    np.testing.assert_array_equal(few[0].places[1], few[0].start[:2])


def test_the_same_study_gives_the_same_bytes_for_any_number_of_workers(
    boxed: ClosedLoopStudy, tmp_path: Path
) -> None:
    changes = {
        "camera": boxed.camera.model_copy(update={"width": 48, "height": 36}),
        "drive": boxed.drive.model_copy(update={"home": False, "explore_s": 6.0}),
    }
    study = boxed.model_copy(update=changes)
    one, two = (
        runner.run(study, RunOptions(out=tmp_path / str(count), workers=count), Silent()) for count in (1, 2)
    )
    kept = sorted(
        p.relative_to(one) for p in one.rglob("*") if p.suffix in (".parquet", ".tum", ".csv", ".pgm")
    )
    assert len(kept) == 3 + 4 + 1 + 2  # tables, tracks, a curve of what was explored, maps
    for name in kept:
        assert (one / name).read_bytes() == (two / name).read_bytes(), name
    page = html.build(one).read_text()
    assert "Without a filter" in page and "drives reached the goal" in page
    assert terminal.summary(one) is not None


def test_the_true_motion_scatters_about_the_command_as_the_study_says(boxed: ClosedLoopStudy) -> None:
    place, noise = TrueOccupancy(np.zeros((400, 400), dtype=bool), np.full(2, -20.0), 0.1), boxed.odometry
    increments = []
    for stream in range(400):
        world = TrueWorld(boxed, place, np.zeros(3), stream)
        for _ in range(4):
            world.apply(Command(0.93, 0.0), 0.1)
        odometry = world.odometry()
        np.testing.assert_allclose(odometry.delta, [0.372, 0, 0], atol=1e-12)
        increments.append(world.pose - odometry.delta)
    expected = 0.372 * np.array(
        [noise.sigma_forward_m_per_m, noise.sigma_lateral_m_per_m, noise.sigma_heading_rad_per_m]
    )
    np.testing.assert_allclose(np.sqrt(np.diag(odometry.covariance)), expected, rtol=1e-9)
    np.testing.assert_allclose(np.std(increments, axis=0), expected, rtol=0.15)


def test_a_command_is_an_arc_of_a_circle() -> None:
    quarter = arc(Command(np.pi / 2, np.pi / 2), 1.0)
    np.testing.assert_allclose(quarter, [1.0, 1.0, np.pi / 2], atol=1e-12)
    halves = move(arc(Command(0.5, 0.8), 0.5), arc(Command(0.5, 0.8), 0.5))
    np.testing.assert_allclose(arc(Command(0.5, 0.8), 1.0), halves, atol=1e-12)


def test_spl_by_hand() -> None:
    assert scores.spl(True, 12.0, 9.0) == 0.75
    assert scores.spl(True, 8.5, 9.0) == 1.0  # it stops short of the goal's centre
    assert scores.spl(False, 9.0, 9.0) == 0.0
    assert np.isnan(scores.spl(True, 9.0, np.nan))


@pytest.mark.parametrize(
    ("keys", "reason"),
    [
        ("drive: {lights: [sun5-bulb5]}", "'sun5-bulb5' is not in the grid; it has sun0-bulb200"),
        ("camera: {optics: {motion_blur: true}}", "motion_blur: is for tours"),
        ("drive: {tasks: [fly]}", "tasks"),
    ],
)
def test_what_does_not_fit_is_one_line(keys: str, reason: str) -> None:
    text = f"sequence: drive\nname: wrong\nilluminations: {{sun_lux: [0], bulb_lm: [200]}}\n{keys}\n"
    with pytest.raises(BenchError) as raised:
        parse(text, "wrong.yaml")
    assert reason in str(raised.value) and "\n" not in str(raised.value)
