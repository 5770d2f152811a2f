"""Light composited onto recorded pictures: what is added, where, and how it is scored."""

import numpy as np
import pytest

from bench.metrics.detection import match
from bench.sequences.dlr_light import composite
from vslam.filters.stages.srgb import decode


def grey(level: int, shape=(20, 30)) -> np.ndarray:
    return np.full((*shape, 3), level, dtype=np.uint8)


def test_light_is_added_in_proportion_to_the_own_lamps():
    # the floor is recorded as 0.2140 (code 127) and rendered as 10 cd/m²: 5 cd/m² more are half as much again
    picture, floor = grey(127), np.ones((20, 30), bool)
    diffuse, specular = np.full((20, 30), 10.0, np.float32), np.zeros((20, 30), np.float32)
    specular[5, 7] = 5.0
    found = composite(picture, diffuse, specular, floor)
    expected = 1.5 * decode(picture)[0, 0, 0]
    assert decode(found.image)[5, 7, 0] == pytest.approx(expected, abs=0.5 / 255)
    untouched = found.image.copy()
    untouched[5, 7] = picture[5, 7]
    np.testing.assert_array_equal(untouched, picture)
    assert found.highlight.sum() == 1 and found.highlight[5, 7]
    np.testing.assert_array_equal(found.original, picture)


def test_twice_the_light_adds_twice_as_much_until_the_sensor_clips():
    picture, floor = grey(90), np.ones((20, 30), bool)
    diffuse = np.full((20, 30), 4.0, np.float32)
    added = [
        decode(composite(picture, diffuse, np.full((20, 30), s, np.float32), floor).image)[0, 0, 0]
        - decode(picture)[0, 0, 0]
        for s in (2.0, 4.0, 1e6)
    ]
    assert added[1] == pytest.approx(2 * added[0], rel=0.02)
    assert added[2] == pytest.approx(1 - decode(picture)[0, 0, 0])


def test_nothing_lies_on_what_is_no_floor():
    picture = grey(100)
    floor = np.zeros((20, 30), bool)
    floor[10:] = True
    bright = np.full((20, 30), 50.0, np.float32)
    found = composite(picture, np.full((20, 30), 10.0, np.float32), bright, floor)
    np.testing.assert_array_equal(found.image[:10], picture[:10])
    assert not found.highlight[:10].any() and found.highlight[10:].all()


@pytest.mark.parametrize("floor", [np.zeros((20, 30), bool), np.ones((20, 30), bool)])
def test_without_floor_or_lamps_the_picture_stays(floor):
    picture, dark = grey(100), np.zeros((20, 30), np.float32)
    found = composite(picture, dark, np.full((20, 30), 9.0, np.float32), floor)
    np.testing.assert_array_equal(found.image, picture)
    assert not found.highlight.any()


def test_the_mask_is_what_exceeds_by_the_threshold():
    rng = np.random.default_rng(0)
    picture = np.repeat(rng.integers(0, 256, (20, 30, 1), dtype=np.uint8), 3, axis=2)
    specular = rng.gamma(0.5, 8.0, (20, 30)).astype(np.float32)
    found = composite(picture, np.full((20, 30), 10.0, np.float32), specular, np.ones((20, 30), bool), 24)
    rise = found.image.astype(int) - picture
    assert (rise >= 0).all()
    np.testing.assert_array_equal(found.highlight, (rise >= 24).any(axis=2))


def test_a_detection_counts_once_within_fifteen_centimetres():
    annotated = np.array([[2.0, 0.0], [3.0, 0.0]])
    assert len(match(annotated, np.array([[2.1, 0.0], [2.0, 0.1], [3.0, 0.2]]), 0.15)) == 1
