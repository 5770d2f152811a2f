"""Times of day: sun and sky against the SPA, light that is only one sun's, names, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.errors import BenchError
from bench.kinds.rendered import RenderedStudy
from bench.rng import generator
from bench.sequences.lighting import load_scene
from bench.sequences.rendered import RenderedSequence, SequenceSetup
from bench.study import dump, parse
from bench.times_of_day import minutes
from renderers.basis import LightBasis, SceneRenderer, mean_white, relight
from renderers.camera import Mount, Pinhole
from renderers.illuminant import linear_srgb
from renderers.irradiance import BakeQuality
from renderers.truth import record
from scenes.model import Scene, Sky, Sun

HEAD = "sequence: rendered\nname: mine\nseed: 5\nscene: {parameters: {laps: 0.05}}\n"
PLACE = "latitude: 48.08, longitude: 11.28, altitude_m: 580, date: 2026-03-20"
QUALITY = BakeQuality(64, 16, 1)
CAMERA = Pinhole(48, 36, 90)


def study(times: str, more: str = "") -> RenderedStudy:
    parsed = parse(f"{HEAD}illuminations: {{bulb_lm: [0, 800], times: {{{times}}}{more}}}\n", "mine.yaml")
    assert isinstance(parsed, RenderedStudy)
    return parsed


def hours(value: str) -> tuple[str, ...]:
    times = study(f"{PLACE}, hours: {value}").illuminations.times
    assert times is not None
    return times.hours


def test_illuminations_are_named_by_hour_and_bulb():
    grid = study(
        f"{PLACE}, hours: ['09:00', 12:30]", ", lamps: [all, {name: half, broken: 0.5}]"
    ).illuminations
    names = [cell.name for cell in grid.grid()]
    assert names[:3] == ["t0900-bulb0", "t0900-bulb0-half", "t0900-bulb800"]
    assert names[4:] == [name.replace("t0900", "t1230") for name in names[:4]]
    assert [cell.labels()["time"] for cell in grid.grid()] == ["09:00"] * 4 + ["12:30"] * 4


def test_hours_may_be_written_in_every_way_that_yaml_reads():
    """Without quotes YAML 1.1 reads 12:30 as 750, and 09:30 as text."""
    assert hours("[9, '9:30', 09:45, 12:30, '23:59']") == ("09:00", "09:30", "09:45", "12:30", "23:59")
    assert hours("{from: 06:00, to: 18:00, steps: 4}") == ("06:00", "10:00", "14:00", "18:00")


@given(st.integers(0, 24 * 60 - 1), st.integers(2, 20))
def test_a_range_of_hours_is_even_to_the_minute(start, steps):
    end = 24 * 60 - 1
    if end - start < steps:
        return
    found = hours(f"{{from: '{start // 60}:{start % 60:02d}', to: '23:59', steps: {steps}}}")
    at = np.array([minutes(hour) for hour in found])
    assert at[0] == start and at[-1] == end and len(at) == steps
    assert np.abs(at - np.linspace(start, end, steps)).max() <= 0.5


def test_a_study_survives_a_round_trip():
    own = study(f"{PLACE}, time_zone: Europe/Berlin, hours: {{from: '06:00', to: '18:00', steps: 5}}")
    assert parse(dump(own), "again") == own
    assert parse(dump(parse(HEAD, "x")), "again") == parse(HEAD, "x")


def test_sun_and_sky_are_those_of_place_and_time():
    own = study(f"{PLACE}, time_zone: Europe/Berlin, hours: ['09:00', '15:00']")
    for cell in own.illuminations.grid():
        moment = datetime.fromisoformat(f"2026-03-20T{cell.time}+01:00")
        sun, sky = (kind.at(48.08, 11.28, moment, 580) for kind in (Sun, Sky))
        assert cell.sun == replace(sun, name=f"sun-{cell.name[:5]}")
        assert (cell.sun_lux, cell.sun_illuminant) == (sun.lux, sun.illuminant)
        assert (cell.sky_lux, cell.sky_illuminant) == (sky.lux, sky.illuminant)


@pytest.mark.parametrize("hour", [6, 9, 12, 15])
def test_the_sun_stands_where_pvlibs_spa_has_it(hour):
    import pandas as pd
    from pvlib import solarposition

    (cell, _) = study(f"{PLACE}, hours: [{hour}]").illuminations.grid()
    at = pd.DatetimeIndex([datetime(2026, 3, 20, hour, tzinfo=UTC)])
    truth = solarposition.spa_python(at, 48.08, 11.28, altitude=580)
    assert cell.sun is not None
    assert cell.sun.azimuth_deg == pytest.approx(float(truth["azimuth"].iloc[0]), abs=0.02)
    assert cell.sun.elevation_deg == pytest.approx(float(truth["apparent_elevation"].iloc[0]), abs=0.02)


def test_the_same_moment_in_two_zones_is_the_same_sun():
    """Kathmandu keeps UTC+05:45."""
    here = study(f"{PLACE}, hours: ['06:00']").illuminations.grid()[0]
    there = study(f"{PLACE}, time_zone: Asia/Kathmandu, hours: ['11:45']").illuminations.grid()[0]
    assert datetime(2026, 3, 20, 11, 45, tzinfo=timezone(timedelta(hours=5, minutes=45))).hour == 11
    assert here.sun is not None and there.sun is not None
    assert there.sun.direction == pytest.approx(here.sun.direction, abs=1e-12)


def test_turning_the_scene_turns_the_sun_against_it():
    """A scene whose y axis points east sees an eastern sun straight ahead."""
    plain = study(f"{PLACE}, hours: [9]").illuminations.grid()[0].sun
    turned = study(f"{PLACE}, y_axis_bearing_deg: 90, hours: [9]").illuminations.grid()[0].sun
    assert plain is not None and turned is not None
    x, y, z = plain.direction
    assert turned.direction == pytest.approx([-y, x, z], abs=1e-12)


def test_each_time_has_a_sun_layer_and_night_has_none():
    own = study(f"{PLACE}, hours: ['02:00', '09:00', '12:00', '22:00']")
    assert [sun.name for sun in load_scene(own).suns] == ["sun-t0900", "sun-t1200"]
    dark = own.illuminations.grid()[0]
    assert (dark.sun_lux, dark.sky_lux) == (0, 0)


def test_a_sun_that_is_always_dark_has_no_layer():
    assert (
        load_scene(
            RenderedStudy.model_validate(
                {"sequence": "rendered", "name": "night", "illuminations": {"sun_lux": [0]}}
            )
        ).suns
        == ()
    )


@pytest.fixture(scope="module")
def day() -> tuple[RenderedSequence, LightBasis]:
    own = study(f"{PLACE}, hours: ['02:00', '08:00', '09:00', '12:00', '15:00']")
    names = [n for c in own.illuminations.grid() for n in (c.sun_illuminant, c.sky_illuminant)]
    colours = {name: linear_srgb(name) for name in (*names, "LED-B3")}
    sequence = RenderedSequence(SequenceSetup(own, "raycast", colours, 1, None))
    return sequence, basis_of(sequence.scene)


def basis_of(scene: Scene) -> LightBasis:
    return SceneRenderer(scene, CAMERA, Mount(), threads=1, quality=QUALITY).render(scene.tour.poses[0])


def test_nine_oclock_is_the_picture_of_a_scene_with_that_sun_alone(day):
    sequence, basis = day
    moment = datetime(2026, 3, 20, 9, tzinfo=UTC)
    sun, sky = (kind.at(48.08, 11.28, moment, 580) for kind in (Sun, Sky))
    alone = basis_of(replace(sequence.scene, suns=(sun,)))
    intensity = {"sun": sun.lux, "sky": sky.lux, "bulbs": 800.0}
    colour = {
        "sun": linear_srgb(sun.illuminant),
        "sky": linear_srgb(sky.illuminant),
        "bulbs": linear_srgb("LED-B3"),
    }
    (cell,) = (c for c in sequence.study.illuminations.grid() if c.name == "t0900-bulb800")
    expected = relight(alone, intensity, colour)
    for ours, theirs in zip(sequence.relight(basis, cell), expected, strict=True):
        assert theirs.max() > 0
        np.testing.assert_array_equal(ours, theirs)
    noise = generator(5, "sensor", cell.name, 0)
    picture = record(sequence.sensor, *expected, mean_white(alone, intensity, colour), noise)
    np.testing.assert_array_equal(sequence.record(basis, cell, 0).image, picture.image)


def test_suns_of_other_hours_shed_no_light_and_night_is_dark(day):
    sequence, basis = day
    cells = {cell.name: cell for cell in sequence.study.illuminations.grid()}
    assert np.add(*sequence.relight(basis, cells["t0200-bulb0"])).max() == 0
    pictures = [np.add(*sequence.relight(basis, cells[f"t{t}-bulb0"])) for t in ("0800", "1200", "1500")]
    assert all(picture.max() > 0 for picture in pictures)
    lit = [picture / picture.mean() for picture in pictures]
    assert np.abs(lit[0] - lit[1]).max() > 0.5  # the sun's patches have moved
    assert np.abs(lit[1] - lit[2]).max() > 0.5


@pytest.mark.parametrize(
    ("times", "more", "expected"),
    [
        ("latitude: 91, longitude: 0, date: 2026-03-20, hours: [9]", "", "times.latitude: should be less"),
        (
            "latitude: .nan, longitude: 0, date: 2026-03-20, hours: [9]",
            "",
            "times.latitude: should be a finite",
        ),
        ("longitude: 0, date: 2026-03-20, hours: [9]", "", "times.latitude: is missing"),
        (PLACE, "", "times.hours: is missing"),
        (f"{PLACE}, hours: []", "", "times.hours: "),
        (f"{PLACE}, hours: ['25:00']", "", "times.hours: no such hour as '25:00'; write one from"),
        (f"{PLACE}, hours: [9:00:30]", "", "times.hours: no such hour as 32430; "),
        (f"{PLACE}, hours: [24]", "", "times.hours: no such hour as 24; "),
        (f"{PLACE}, hours: [-1]", "", "times.hours: no such hour as -1; "),
        (f"{PLACE}, hours: 9", "", "times.hours: should be a list"),
        (f"{PLACE}, hours: [9, '09:00']", "", "times: hours: 09:00 stands twice"),
        (f"{PLACE}, hours: {{from: 9, to: 8, steps: 3}}", "", "times.hours: should run from an earlier"),
        (f"{PLACE}, hours: {{from: 9, til: 18, steps: 3}}", "", "times.hours: unknown key 'til': "),
        (f"{PLACE}, hours: {{from: 9, to: 18}}", "", "times.hours: steps should be a whole number from 2"),
        (
            f"{PLACE}, hours: [9], time_zone: Europe/Berlim",
            "",
            "times.time_zone: unknown time zone 'Europe/Berlim': did you mean 'Europe/Berlin'",
        ),
        (f"{PLACE}, hours: [9], time_zone: ../x", "", "times.time_zone: unknown time zone '../x': "),
        (f"{PLACE}, hours: [9], timezone: UTC", "", "times.timezone: unknown key: did you mean 'time_zone'"),
        (
            "latitude: 0, longitude: 0, hours: [9], date: '2026-02-30'",
            "",
            "times.date: no such date as '2026-02-30'",
        ),
        ("latitude: 0, longitude: 0, hours: [9], date: 2026", "", "times.date: should be a date such as"),
        ("latitude: 0, longitude: 0, hours: [9], date: 1066-10-14", "", "times.date: 1066-10-14: the sun's"),
        (
            "latitude: 48, longitude: 11, date: 2026-03-29, time_zone: Europe/Berlin, hours: ['02:30']",
            "",
            "times: hours: Europe/Berlin skips 02:30 on 2026-03-29; choose another",
        ),
        (
            f"{PLACE}, hours: [9]",
            ", sun_lux: [5]",
            "illuminations: times says where and how bright sun and sky are; leave sun_lux out",
        ),
        (
            f"{PLACE}, hours: [9]",
            ", sky_per_sun: 0.2",
            "illuminations: times says where and how bright sun and sky are; leave sky_per_sun out",
        ),
        (f"{PLACE}, hours: [9]", ", sun_illuminant: A", "illuminations: times says where and how bright"),
    ],
)
def test_what_is_wrong_is_one_line(times, more, expected):
    with pytest.raises(BenchError) as caught:
        study(times, more)
    assert "\n" not in str(caught.value)
    assert str(caught.value).removeprefix("mine.yaml: ").removeprefix("illuminations.").startswith(expected)


def test_a_date_that_yaml_itself_refuses_is_one_line():
    with pytest.raises(
        BenchError, match=r"^mine.yaml: not valid YAML: line 5, column \d+: .*day is out of range"
    ):
        study("latitude: 0, longitude: 0, hours: [9], date: 2026-02-30")
