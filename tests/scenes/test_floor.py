"""Which level face is the floor."""

from __future__ import annotations

import numpy as np
import pytest

from scenes.errors import SceneError
from scenes.floor import laid
from scenes.geometry import box, rectangle, surface
from scenes.model import Material

GREY = Material((0.5, 0.5, 0.5), 1.0)


def house(level=0.7):
    """A room of 6 m × 4 m on a plot of 60 m × 60 m, with a table, a ceiling and a flat roof."""

    def at(x, y, z):
        return (x, y, z + level)

    return (
        surface("plot", GREY, rectangle(at(-30, -30, -0.4), (60, 0, 0), (0, 60, 0), 60)),
        surface("tiles", GREY, rectangle(at(0, 0, 0), (4, 0, 0), (0, 4, 0), 4)),
        surface("carpet", GREY, rectangle(at(4, 0, 0.01), (2, 0, 0), (0, 4, 0), 4)),
        surface("west", GREY, box(at(-0.2, -0.2, -0.4), at(0, 4.2, 2.5))),
        surface("east", GREY, box(at(6, -0.2, -0.4), at(6.2, 4.2, 2.5))),
        surface("table", GREY, box(at(2, 1, 0.5), at(4, 3, 0.8), bottom=True)),
        surface("ceiling", GREY, rectangle(at(0, 0, 2.5), (0, 4, 0), (6, 0, 0), 6)),
        surface("roof", GREY, rectangle(at(-0.2, -0.2, 2.6), (6.4, 0, 0), (0, 4.4, 0), 7)),
    )  # fmt: skip


def test_the_room_is_the_floor_and_not_the_plot_the_table_or_the_roof():
    found = laid(house())
    assert found.floor == ("tiles", "carpet")
    assert found.level_m == pytest.approx(0.7)
    assert found.surfaces[0].vertices[:, 2] == pytest.approx(0)


def test_a_name_decides_otherwise():
    assert laid(house(), "plot").floor == ("plot",)
    with pytest.raises(SceneError, match="floor 'cellar' is none of the surfaces; they are plot, tiles"):
        laid(house(), "cellar")


def test_a_mesh_of_floor_and_walls_is_parted():
    shell = surface(
        "shell",
        GREY,
        rectangle((0, 0, 0), (4, 0, 0), (0, 4, 0), 1),
        rectangle((0, 4, 0), (4, 0, 0), (0, 0, 2), 1),
    )
    found = laid((shell,))
    assert found.floor == ("shell (floor)",)
    assert [s.name for s in found.surfaces] == ["shell (floor)", "shell"]
    areas = []
    for part in found.surfaces:
        a, b, c = (part.vertices[part.triangles[:, k]] for k in range(3))
        areas.append(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)
    assert areas == pytest.approx([16, 8])


def test_without_a_level_face_there_is_no_floor():
    wall = surface("wall", GREY, rectangle((0, 0, 0), (4, 0, 0), (0, 0, 2), 1))
    with pytest.raises(SceneError, match=r"no floor: .* in 4 × 0 × 2 m .*in metres"):
        laid((wall,))
