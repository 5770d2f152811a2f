"""A study with motion blur: what the shutter changes, and what it leaves as it was."""

from __future__ import annotations

import numpy as np
import pytest

from bench.camera_choice import camera
from bench.kinds.rendered import RenderedStudy
from bench.sequences.lighting import light_colours
from bench.sequences.rendered import RenderedSequence, SequenceSetup
from renderers.basis import SceneRenderer
from renderers.camera import Mount
from renderers.irradiance import BakeQuality

STUDY = {
    "sequence": "rendered",
    "name": "moving",
    "engine": "raycast",
    "scene": {"parameters": {"laps": 0.05}},
    "illuminations": {"sun_lux": [0, 20_000], "bulb_lm": [200]},
    "tour": {"frame_interval_s": 0.5},
}


def sequence(**lens):
    study = RenderedStudy.model_validate({**STUDY, "camera": {"width": 96, "height": 72, **lens}})
    return RenderedSequence(SequenceSetup(study, "raycast", light_colours(study), 1, None))


@pytest.fixture(scope="module")
def pair():
    """One frame's basis, and the sequence without and with motion blur."""
    still, moving = sequence(), sequence(optics={"motion_blur": True})
    eye, mount = camera(still.study.camera), Mount()
    renderer = SceneRenderer(
        still.scene, eye, mount, threads=1, quality=BakeQuality(16, 16, 0), mirrored=True
    )
    return [renderer.render(still.scene.tour.poses[k]) for k in (0, 2)], still, moving


def test_exposure_is_metered_on_light_that_stands_still(pair):
    (_, basis), still, moving = pair
    for light in still.study.illuminations.grid():
        sharp, blurred = still.record(basis, light, 2), moving.record(basis, light, 2)
        assert blurred.exposure.seconds == sharp.exposure.seconds


def test_a_long_exposure_blurs_and_keeps_the_light(pair):
    (_, basis), still, moving = pair
    night = still.study.illuminations.grid()[0]
    assert still.record(basis, night, 2).exposure.seconds > 0.01
    for sharp, blurred in zip(still.relight(basis, night, 2), moving.relight(basis, night, 2), strict=True):
        assert blurred.mean() == pytest.approx(sharp.mean(), rel=0.02)
    sharp, blurred = still.relight(basis, night, 2)[0], moving.relight(basis, night, 2)[0]
    assert np.abs(np.diff(blurred, axis=0)).sum() < np.abs(np.diff(sharp, axis=0)).sum()


def test_the_same_picture_again_and_in_another_order(pair):
    """The kept velocities are those of the basis at hand."""
    (other, basis), _, moving = pair
    night, day = moving.study.illuminations.grid()
    first = moving.record(basis, night, 2).image
    moving.record(other, day, 0)
    np.testing.assert_array_equal(moving.record(basis, night, 2).image, first)
