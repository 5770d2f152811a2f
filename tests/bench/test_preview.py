"""Previews: the sheet shows the recorded pictures where it says so, the plan shows the place as built."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from bench.cli import execute
from bench.errors import BenchError
from bench.kinds.rendered import RenderedStudy
from bench.options import PreviewOptions
from bench.preview import plan, sheet
from bench.preview.preview import evenly, preview
from bench.preview.sheet import Cell
from bench.progress import Silent
from bench.sequences.rendered import load_scene
from renderers.develop import encode
from scenes.model import Scene


@pytest.fixture(scope="module")
def place(short_study: RenderedStudy) -> Scene:
    return load_scene(short_study)


def _pixel(place: Scene, picture: np.ndarray, x: float, y: float) -> list[int]:
    x0, y0, x1, y1 = place.bounds
    step = max(x1 - x0, y1 - y0) / plan.LONG_SIDE
    return [int(v) for v in picture[int((y - y0) / step), int((x - x0) / step)]]


def test_views_are_spread_evenly_and_a_round_does_not_show_its_start_twice() -> None:
    assert evenly(range(9), 3) == [0, 4, 8]
    assert evenly(range(100), 4, closed=True) == [0, 25, 50, 75]
    assert evenly(range(2), 4) == [0, 1]
    assert evenly("abc", 1) == ["a"]


def test_a_block_holds_recorded_diffuse_specular_and_mask() -> None:
    plain = [np.full((24, 32, 3), value, dtype=np.uint8) for value in (200, 150, 50)]
    mask = np.zeros((24, 32), dtype=bool)
    mask[12:] = True
    cell = Cell(plain[0], plain[1], plain[2], mask)
    page = sheet.compose([[cell, cell], [cell, cell]])
    block_y, block_x = 2 * 24 + sheet.GAP, 2 * 32 + sheet.GAP
    assert page.shape == (
        2 * (block_y + sheet.LABEL + sheet.LARGE_GAP) + sheet.LARGE_GAP + sheet.LABEL,
        2 * (block_x + sheet.LARGE_GAP) + sheet.LARGE_GAP,
        3,
    )
    y, x = sheet.LARGE_GAP + sheet.LABEL, sheet.LARGE_GAP
    right, below = x + 32 + sheet.GAP, y + 24 + sheet.GAP
    assert page[y, x, 0] == 200 and page[y, right, 0] == 150 and page[below, x, 0] == 50
    assert page[below, right, 0] == 0 and page[below + 23, right, 0] == 255
    assert page[0, 0, 0] == 255


def test_a_large_picture_is_reduced_and_keeps_its_aspect() -> None:
    big = np.zeros((480, 640, 3), dtype=np.uint8)
    page = sheet.compose([[Cell(big, big, big, big[..., 0] > 0)]])
    assert page.shape[1] == 2 * sheet.SHOWN_WIDTH + sheet.GAP + 2 * sheet.LARGE_GAP


def test_the_plan_shows_the_floor_where_the_robot_drives(place: Scene) -> None:
    seen = plan.from_above(place)
    floor = next(s for s in place.surfaces if s.name == place.floor).material.base_color
    expected = encode(np.array(floor)).tolist()
    for x, y, _ in place.tour.poses:
        assert _pixel(place, seen, x, y) == pytest.approx(expected, abs=1)


def test_preview_writes_a_sheet_and_a_plan(
    short_study: RenderedStudy, cache_home: Path, tmp_path: Path
) -> None:
    names = ("sun0-bulb800", "sun20000-bulb200")
    written = preview(short_study, PreviewOptions(tmp_path, 2, names), Silent())
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(p.name for p in written)
    opened = cv2.imread(str(written[0]))
    assert opened is not None
    blocks = (2 * 240 + sheet.GAP, 2 * 320 + sheet.GAP)
    assert opened.shape[:2] == (
        2 * (blocks[0] + sheet.LABEL + sheet.LARGE_GAP) + sheet.LARGE_GAP + sheet.LABEL,
        2 * (blocks[1] + sheet.LARGE_GAP) + sheet.LARGE_GAP,
    )
    night, day = (
        opened[sheet.LARGE_GAP + sheet.LABEL :][:240, sheet.LARGE_GAP + k * (blocks[1] + sheet.LARGE_GAP) :][
            :, :320
        ]
        for k in (0, 1)
    )
    assert night.mean() > 1 and day.mean() > night.mean()


def test_unknown_names_are_refused(short_study: RenderedStudy, tmp_path: Path) -> None:
    with pytest.raises(BenchError, match=r"unknown illumination 'sun0-bulb80'.*sun0-bulb800"):
        preview(short_study, PreviewOptions(tmp_path, 1, ("sun0-bulb80",)), Silent())


@pytest.mark.parametrize(
    "arguments, complaint",
    [
        (["preview", "corridr"], "did you mean 'corridor'"),
        (["preview", "corridor", "--study", "filters"], "'filters' is not of one rendered scene"),
        (["preview", "corridor", "--views", "0"], "--views"),
        (["preview"], "SCENE"),
    ],
)
def test_a_wrong_command_line_is_one_line_and_code_2(
    arguments: list[str], complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert execute(arguments) == 2
    said = capsys.readouterr().err
    assert complaint in said and said.count("\n") == 1
