"""nav2's map files: written as its documentation says, read back with equal cells."""

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bench import map_server
from bench.errors import BenchError
from vslam.occupancy import OccupancyGrid


def grid_of(log_odds: list[list[float]]) -> OccupancyGrid:
    return OccupancyGrid(np.array([-1.5, 2.0]), 0.05, np.array(log_odds, dtype=np.float32))


def write(folder, grid):
    for name, content in map_server.files(grid, "map").items():
        (folder / name).write_bytes(content)
    return folder / "map.yaml"


def test_the_picture_is_what_nav2_expects(tmp_path):
    path = write(tmp_path, grid_of([[1.0, -1.0, 0.0], [-1.0, -1.0, -1.0]]))
    keys = yaml.safe_load(path.read_text())
    assert keys["image"] == "map.pgm" and keys["mode"] == "trinary" and keys["negate"] == 0
    assert keys["resolution"] == 0.05 and keys["origin"] == [-1.5, 2.0, 0.0]
    assert keys["occupied_thresh"] == 0.65 and keys["free_thresh"] == 0.196
    picture = cv2.imread(str(tmp_path / "map.pgm"), cv2.IMREAD_UNCHANGED)
    assert keys["free_thresh"] < 1 - 205 / 255  # unknown is not free
    # y points up: the map's first row is the picture's last
    np.testing.assert_array_equal(picture, [[254, 254, 254], [0, 254, 205]])


@given(arrays(np.float32, (4, 5), elements=st.sampled_from([-1.5, -0.25, 0.0, 0.5, 3.0])))
def test_cells_survive_a_round_trip(tmp_path_factory, log_odds):
    grid = OccupancyGrid(np.array([3.25, -7.0]), 0.1, log_odds)
    again = map_server.read(write(tmp_path_factory.mktemp("map"), grid))
    np.testing.assert_array_equal(again.occupied, grid.occupied)
    np.testing.assert_array_equal(again.free, grid.free)
    np.testing.assert_array_equal(again.origin, grid.origin)
    assert again.resolution == grid.resolution


def test_a_map_of_another_tool_is_read(tmp_path):
    # as ROS 1's map_saver writes it: other thresholds, more keys, PNG
    cv2.imwrite(str(tmp_path / "hall.png"), np.array([[0, 100, 254]], dtype=np.uint8))
    text = "image: hall.png\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\n"
    (tmp_path / "hall.yaml").write_text(text + "occupied_thresh: 0.65\nfree_thresh: 0.196\nauthor: me\n")
    grid = map_server.read(tmp_path / "hall.yaml")
    assert grid.occupied.tolist() == [[True, False, False]] and grid.free.tolist() == [[False, False, True]]
    (tmp_path / "hall.yaml").write_text(text.replace("negate: 0", "negate: 1"))
    assert map_server.read(tmp_path / "hall.yaml").occupied.tolist() == [[False, False, True]]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("image: no.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n", "no.pgm is missing"),
        ("image: map.pgm\nresolution: 0\norigin: [0, 0, 0]\n", "resolution: Input should be greater than 0"),
        ("image: map.pgm\norigin: [0, 0, 0]\n", "resolution: Field required"),
        ("image: map.pgm\nresolution: 0.1\norigin: [0, 0, 0.5]\n", "turned by 0.5 rad"),
        ("image: [map.pgm\n", "cannot be read"),
        ("- 1\n", "the file"),
    ],
)
def test_what_is_wrong_is_one_line(tmp_path, text, expected):
    path = write(tmp_path, grid_of([[1.0]]))
    path.write_text(text)
    with pytest.raises(BenchError, match=r"map\.yaml") as error:
        map_server.read(path)
    assert expected in str(error.value) and "\n" not in str(error.value)


def test_a_missing_file_is_one_line(tmp_path):
    with pytest.raises(BenchError, match="cannot be read"):
        map_server.read(tmp_path / "map.yaml")
