"""One pose of a study of filters: every filter on the picture with its light, and on the same without."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bench.illumination_grid import Illumination
from bench.metrics import mask, restoration
from bench.perception import Attempt, Perception, unmeasured, visible_landmarks
from renderers.basis import LightBasis
from renderers.truth import Recording
from vslam.filters.base import Filtered

Row = dict[str, object]
ORACLE = "oracle"
"""Not a filter: it is given the true mask and the true diffuse picture, and so shows what can be gained."""


@dataclass(frozen=True)
class Trial:
    """Rows of the frames table (`bench.schema.FRAME_COLUMNS`).

    Attributes
    ----------
    lit : list of dict
        Of the pictures as the sensor records them.
    highlight_free : list of dict
        Of the same pictures without specular light: whatever is masked there is masked wrongly.
    neutral : list of dict
        Of ``lit``, over the pixels of white and grey objects alone.
    oracle : list of dict
        Of ``lit``, masked and repaired from the truth.
    """

    lit: list[Row] = field(default_factory=list)
    highlight_free: list[Row] = field(default_factory=list)
    neutral: list[Row] = field(default_factory=list)
    oracle: list[Row] = field(default_factory=list)


def try_filters(perception: Perception, frame: int, neutral_objects: tuple[str, ...] = ()) -> Trial:
    """Put every filter of a study to the test at one pose, at every level of light."""
    trial, sequence = Trial(), perception.sequence
    basis = sequence.basis(frame)
    visible = visible_landmarks(basis)
    neutral = pixels_of(neutral_objects, perception, basis)
    for light in perception.illuminations:
        lit = sequence.record(basis, light, frame)
        without = sequence.record(basis, light, frame, highlights=False)
        target = restoration.Target(lit.diffuse)  # of both: they differ by specular light alone
        for label, light_filter in perception.filters:
            labels = perception.labels(light, frame, label)
            tried = perception.attempt(frame, lit, target, light_filter, visible)
            trial.lit.append(tried.row | labels)
            free = perception.attempt(frame, without, target, light_filter, visible)
            trial.highlight_free.append(free.row | labels)
            if neutral.any():
                trial.neutral.append(_over(neutral, tried, lit) | labels)
        trial.oracle.append(_oracle(perception, frame, light, lit, target, visible))
    return trial


def pixels_of(names: tuple[str, ...], perception: Perception, basis: LightBasis) -> NDArray[np.bool_]:
    """(H, W) bool: where a basis shows surfaces of these names."""
    surfaces = perception.sequence.scene.surfaces
    return np.isin(basis.surface, [k for k, surface in enumerate(surfaces) if surface.name in names])


def exact(recording: Recording) -> Filtered:
    """What a filter would answer that knew the truth: the picture with the diffuse one in the true mask."""
    inside = recording.highlight
    image = np.where(inside[..., None], recording.diffuse, recording.image)
    return Filtered(image, inside, inside.astype(np.float32))


def _oracle(
    perception: Perception,
    frame: int,
    light: Illumination,
    recording: Recording,
    target: restoration.Target,
    visible: NDArray[np.bool_],
) -> Row:
    row, _ = perception.score(frame, recording, target, exact(recording), visible)
    return row | {"filter_ms": 0.0, "status": "ok"} | perception.labels(light, frame, ORACLE)


def _over(pixels: NDArray[np.bool_], tried: Attempt, recording: Recording) -> Row:
    """Mask and repair over some pixels of a picture; no landmarks, no structure."""
    counts = {"landmarks_visible": 0, "landmarks_detected": 0, "detections_true": 0}
    row = unmeasured() | counts | {"status": tried.row["status"]}
    if tried.filtered is None:
        return row
    made = tried.filtered
    scores = mask.evaluate(
        made.mask[pixels][None], recording.highlight[pixels][None], made.score[pixels][None]
    )
    error = made.image[pixels].astype(np.float64) - recording.diffuse[pixels]
    psnr = restoration.psnr_db(float(np.mean(error**2)))
    return row | vars(scores) | {"psnr_db": psnr, "filter_ms": tried.row["filter_ms"]}
