"""Illumination grids: lists, log ranges, lamps off, broken and flickering; what is refused; light adds up."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.errors import BenchError
from bench.illumination_grid import Illumination
from bench.kinds.rendered import RenderedStudy
from bench.sequences import lamps
from bench.sequences.lighting import light_colours, load_scene
from bench.sequences.rendered import RenderedSequence, SequenceSetup
from bench.study import dump, load, parse
from renderers.basis import LightBasis, SceneRenderer
from renderers.camera import Mount, Pinhole
from renderers.illuminant import linear_srgb
from renderers.irradiance import BakeQuality
from reports.illuminations import Illumination as ReportedLight

HEAD = "sequence: rendered\nname: mine\nseed: 5\nscene: {parameters: {laps: 0.1}}\n"
WHOLE = load_scene(RenderedStudy(sequence="rendered", name="whole"))
ALL = "{sun_lux: [0, 20000], bulb_lm: [400], lamps: [all, "


def study(illuminations: str) -> RenderedStudy:
    parsed = parse(f"{HEAD}illuminations: {illuminations}\n", "mine.yaml")
    assert isinstance(parsed, RenderedStudy)
    return parsed


def refusal(illuminations: str) -> str:
    with pytest.raises(BenchError) as caught:
        load_scene(study(illuminations))
    assert "\n" not in str(caught.value)
    return str(caught.value).removeprefix("mine.yaml: ").removeprefix("illuminations.")


def states(illuminations: str) -> dict[str, np.ndarray]:
    own = study(illuminations)
    return {light.lamps: lamps.burning(WHOLE, light, own.seed) for light in own.illuminations.grid()}


def test_a_log_range_has_equal_ratios():
    grid = study(
        "{sun_lux: {log: [100, 100000], steps: 4}, bulb_lm: {log: [100, 1e3], steps: 3}}"
    ).illuminations
    assert grid.sun_lux == (100, 1000, 10_000, 100_000)
    assert grid.bulb_lm == (100, 316.2, 1000)
    assert [cell.name for cell in grid.grid()][1] == "sun100-bulb316.2"


@given(
    low=st.floats(1e-3, 1e3),
    factor=st.floats(1.5, 100),
    steps=st.integers(2, 30),
)
def test_any_log_range_rises_from_end_to_end_and_survives_a_round_trip(low, factor, steps):
    own = study(f"{{sun_lux: {{log: [{low!r}, {low * factor!r}], steps: {steps}}}}}")
    values = own.illuminations.sun_lux
    assert len(values) == steps
    assert values[0] == low
    assert values[-1] == low * factor
    assert all(np.diff(values) > 0)
    ratios = np.log(values[1:]) - np.log(values[:-1])
    assert ratios == pytest.approx(math.log(factor) / (steps - 1), abs=2e-3)
    assert parse(dump(own), "again") == own


lamp = st.integers(0, 13).map(lambda k: f"lamp-{k}")
state = st.fixed_dictionaries(
    {},
    optional={
        "without": st.lists(lamp, min_size=1, max_size=3),
        "only": st.lists(lamp, min_size=1, max_size=3),
        "broken": st.floats(0.01, 1),
        "flicker": st.fixed_dictionaries({"frequency_hz": st.floats(0.01, 500), "depth": st.floats(0, 1)}),
    },
).filter(bool)


@settings(max_examples=30)
@given(st.lists(state, min_size=1, max_size=4))
def test_any_lamps_survive_a_round_trip_and_need_few_layers(chosen):
    named = [{"name": f"state-{k}", **s} for k, s in enumerate(chosen)]
    own = RenderedStudy.model_validate(
        {
            "sequence": "rendered",
            "name": "mine",
            "scene": {"parameters": {"laps": 0.05}},
            "illuminations": {"sun_lux": [0], "bulb_lm": [400], "lamps": ["all", *named]},
        }
    )
    assert parse(dump(own), "again") == own
    cells = own.illuminations.grid()
    assert len({cell.name for cell in cells}) == len(cells) == 1 + len(chosen)
    scene = load_scene(own)
    on = np.array([lamps.burning(WHOLE, cell, own.seed) for cell in cells])
    assert len({bulb.group for bulb in scene.bulbs}) == len(np.unique(on, axis=1).T)


def test_lamps_go_off_by_name_and_by_group():
    on = states(
        ALL + "{name: dark, without: [bulbs]}, {name: one, only: [lamp-2]}, "
        "{name: less, without: [lamp-0, lamp-3]}, {name: both, only: [lamp-1, lamp-2], without: [lamp-1]}]}"
    )
    assert on["all"].all()
    assert not on["dark"].any()
    assert np.flatnonzero(on["one"]).tolist() == [2]
    assert np.flatnonzero(~on["less"]).tolist() == [0, 3]
    assert np.flatnonzero(on["both"]).tolist() == [2]


def test_broken_lamps_are_drawn_once_from_the_seed():
    text = ALL + "{name: some, broken: 0.3}, {name: others, broken: 0.3}]}"
    on, again = states(text), states(text)
    count = len(on["all"])
    for name in ("some", "others"):
        assert (~on[name]).sum() == round(0.3 * count)
        assert (on[name] == again[name]).all()
    assert (on["some"] != on["others"]).any()
    light = Illumination("x", 0, 0, 400, "some", broken=0.3)
    draws = {tuple(lamps.burning(WHOLE, light, seed)) for seed in range(10)}
    assert len(draws) > 5


@given(frequency=st.floats(0.01, 200), depth=st.floats(0, 1), stamp=st.floats(0, 1000))
def test_flicker_stays_within_its_depth_about_the_mean(frequency, depth, stamp):
    light = Illumination("x", 0, 0, 400, flicker_hz=frequency, flicker_depth=depth)
    assert 1 - depth - 1e-9 <= lamps.flicker(light, stamp) <= 1 + depth + 1e-9
    assert lamps.flicker(light, 0.0) == pytest.approx(1 + depth)
    assert lamps.flicker(light, 0.5 / frequency) == pytest.approx(1 - depth)
    period = np.arange(32) / (32 * frequency)
    assert np.mean([lamps.flicker(light, t) for t in period]) == pytest.approx(1)


def test_a_study_that_switches_nothing_keeps_its_scene_and_names():
    quick = load("quick")
    assert isinstance(quick, RenderedStudy)
    assert {bulb.group for bulb in load_scene(quick).bulbs} == {"bulbs"}
    assert [cell.name for cell in quick.illuminations.grid()][:2] == ["sun0-bulb100", "sun0-bulb400"]


@pytest.fixture(scope="module")
def switched():
    """A study that switches lamps, its frame under every layer, and the sequence that weights them."""
    own = study(
        ALL + "{name: half, broken: 0.5}, {name: one, only: [lamp-1]}, {name: rest, without: [lamp-1]}, "
        "{name: flicker, flicker: {frequency_hz: 0.3, depth: 0.5}}]}"
    )
    scene = load_scene(own)
    colours = {name: np.ones(3) for name in ("D55", "D75", "LED-B3")}
    sequence = RenderedSequence(SequenceSetup(own, "raycast", colours, 1, None))
    renderer = SceneRenderer(scene, Pinhole(32, 24, 90), Mount(), threads=1, quality=BakeQuality(64, 16, 1))
    cells = {(cell.sun_lux, cell.lamps): cell for cell in own.illuminations.grid()}
    return sequence, renderer.render(scene.tour.poses[3]), cells


def luminance(
    sequence: RenderedSequence, basis: LightBasis, cell: Illumination, frame: int = 0
) -> np.ndarray:
    return np.add(*sequence.relight(basis, cell, frame)).astype(float)


def test_the_light_of_a_lamp_and_of_all_others_adds_up(switched):
    sequence, basis, cells = switched
    one, rest, everything = (luminance(sequence, basis, cells[0, name]) for name in ("one", "rest", "all"))
    assert one.sum() > 0
    assert rest.sum() > 0
    assert one + rest == pytest.approx(everything, rel=1e-4, abs=1e-6)
    half = luminance(sequence, basis, cells[0, "half"])
    assert 0 < half.sum() < everything.sum()


def test_lamps_do_not_touch_the_sun(switched):
    sequence, basis, cells = switched
    added = [
        luminance(sequence, basis, cells[20_000, name]) - luminance(sequence, basis, cells[0, name])
        for name in ("all", "one")
    ]
    assert added[0] == pytest.approx(added[1], rel=1e-3, abs=1e-2)


def test_flicker_follows_the_stamp(switched):
    sequence, basis, cells = switched
    steady = luminance(sequence, basis, cells[0, "all"])
    for frame in (0, 1, 4):
        factor = 1 + 0.5 * math.cos(2 * math.pi * 0.3 * sequence.scene.tour.stamps[frame])
        flickering = luminance(sequence, basis, cells[0, "flicker"], frame)
        assert flickering == pytest.approx(factor * steady, rel=1e-5)
    bright, dark = (sequence.record(basis, cells[0, "flicker"], frame) for frame in (0, 4))
    assert bright.exposure.seconds == dark.exposure.seconds  # the longest: neither is exposed as metered
    assert bright.full.mean() > 1.3 * dark.full.mean()


@pytest.mark.parametrize(
    ("illuminations", "expected"),
    [
        ("{sun_lux: [-1]}", "sun_lux.0: should be greater than or equal to 0, not -1"),
        ("{sun_lux: [.nan]}", "sun_lux.0: should be a finite number, not nan"),
        (
            "{bulb_lm: {log: [0, 10], steps: 3}}",
            "bulb_lm: log should rise from above 0, not",
        ),
        (
            "{bulb_lm: {log: [20, 10], steps: 3}}",
            "bulb_lm: log should rise from above 0, not",
        ),
        (
            "{bulb_lm: {log: [1, .nan], steps: 3}}",
            "bulb_lm: log should be two numbers, such as",
        ),
        ("{bulb_lm: {log: 5, steps: 3}}", "bulb_lm: log should be two numbers, such as"),
        ("{bulb_lm: {log: [1, 5]}}", "bulb_lm: steps should be a whole number from 2 to 1000"),
        (
            "{bulb_lm: {log: [1, 5], steps: 1}}",
            "bulb_lm: steps should be a whole number from 2",
        ),
        (
            "{bulb_lm: {log: [1, 5], step: 4}}",
            "bulb_lm: unknown key 'step': did you mean 'steps'?",
        ),
        ("{sun_lux: {log: [1, 1e6], steps: 2}}", "sun_lux.1: should be less than or equal to"),
        ("{lamp: []}", "lamp: unknown key: did you mean 'lamps'"),
        ("{lamps: []}", "lamps: "),
        (
            "{lamps: [{name: a, witout: [lamp-1]}]}",
            "lamps.0.witout: unknown key: did you mean 'w",
        ),
        (
            "{lamps: [{name: a}]}",
            "lamps.0: 'a' says nothing of its lamps; give it without, only",
        ),
        (
            "{lamps: [{name: all, broken: 0.5}]}",
            "lamps.0: the name 'all' is kept for lamps that",
        ),
        ("{lamps: [all, all]}", "illuminations: lamps: the name 'all' stands twice"),
        (
            "{lamps: [{name: a, broken: 1.5}]}",
            "lamps.0.broken: should be less than or equal to 1",
        ),
        (
            "{lamps: [{name: a, broken: -1}]}",
            "lamps.0.broken: should be greater than or equal to",
        ),
        (
            "{lamps: [{name: A b, broken: 1}]}",
            "lamps.0.name: should be a name of small letters",
        ),
        (
            "{lamps: [{name: a, flicker: {frequency_hz: 0, depth: 1}}]}",
            "lamps.0.flicker.frequency_hz: should be greater than 0, not 0",
        ),
        (
            "{lamps: [{name: a, flicker: {frequncy_hz: 1, depth: 1}}]}",
            "lamps.0.flicker.frequncy_hz: unknown key: did you mean 'frequency_hz'?",
        ),
        ("{lamps: [{name: a, without: [lamp-99]}]}", "unknown lamp 'lamp-99': did you mean 'lamp-9'"),
        ("{lamps: [{name: a, only: [bulb]}]}", "unknown lamp 'bulb': did you mean 'bulbs'?"),
    ],
)
def test_what_is_wrong_is_one_line(illuminations, expected):
    assert refusal(illuminations).startswith(expected)


def test_reports_name_the_lamps_where_they_do_not_all_burn():
    cells = study(ALL + "{name: half, broken: 0.5}]}").illuminations.grid()
    labels = [ReportedLight.of(cell.labels()).label for cell in cells]
    assert labels[2:] == ["sun 20 klx, bulbs 400 lm", "sun 20 klx, bulbs 400 lm, lamps half"]


def lamplit(lamps_of_scene: str, states: str = "all") -> tuple[RenderedSequence, LightBasis]:
    """A study with its lamps shaped or coloured, and its first frame under every layer, without bounces."""
    text = HEAD.replace("laps: 0.1}", f"laps: 0.02}}, lamps: {lamps_of_scene}")
    own = parse(f"{text}illuminations: {{sun_lux: [0], bulb_lm: [400], lamps: [{states}]}}\n", "x")
    assert isinstance(own, RenderedStudy)
    sequence = RenderedSequence(SequenceSetup(own, "raycast", light_colours(own), 1, None))
    renderer = SceneRenderer(
        sequence.scene, Pinhole(32, 24, 90), Mount(), threads=1, quality=BakeQuality(64, 16, -1)
    )
    return sequence, renderer.render(sequence.scene.tour.poses[0])


def test_a_states_colour_is_that_illuminants_and_no_layer_more():
    sequence, basis = lamplit("{}", "all, {name: warm, illuminant: 2700K}")
    assert basis.layers == ("sky", "bulbs")
    white, warm = (luminance(sequence, basis, cell) for cell in sequence.study.illuminations.grid())
    ratio = linear_srgb("2700K") / linear_srgb("LED-B3")
    assert white.max() > 0
    assert warm == pytest.approx(white * ratio, rel=1e-5)


def test_lamps_of_a_scene_take_a_studys_colour_and_shape(tmp_path):
    """A lamp that shines upwards alone lights no floor; an even one is the plain one."""
    ies = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 50\n{}\n0\n100 100 100\n"
    for name, angles in (("up", "91 135 180"), ("even", "0 90 180")):
        (tmp_path / f"{name}.ies").write_text(ies.format(angles))
    shown = {
        shape: lamplit(choice)
        for shape, choice in (
            ("bare", "{}"),
            ("even", f"{{ies: {tmp_path}/even.ies}}"),
            ("up", f"{{ies: {tmp_path}/up.ies}}"),
            ("spot", "{spot: {inner_deg: 5, outer_deg: 10}, illuminant: A, radius_m: 0.02}"),
        )
    }
    bulb = shown["spot"][0].scene.bulbs[0]
    assert (bulb.illuminant, bulb.radius) == ("A", 0.02)
    picture = {
        shape: luminance(sequence, basis, sequence.study.illuminations.grid()[0])
        for shape, (sequence, basis) in shown.items()
    }
    assert picture["even"] == pytest.approx(picture["bare"], rel=1e-4, abs=1e-5)
    floor = shown["bare"][1].surface == 0
    assert picture["bare"][floor].max() > 0
    assert picture["up"][floor].max() == 0
    assert picture["spot"][floor].max() > 3 * picture["bare"][floor].max()


def test_sun_and_sky_take_a_studys_colour():
    own = study("{sun_lux: [20000], bulb_lm: [0], sun_illuminant: A, sky_illuminant: D65}")
    sequence = RenderedSequence(SequenceSetup(own, "raycast", light_colours(own), 1, None))
    colour = sequence._lighting.colour(own.illuminations.grid()[0])
    assert colour["sun"] == pytest.approx(linear_srgb("A"))
    assert colour["sky"] == pytest.approx(linear_srgb("D65"))
