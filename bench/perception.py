"""Phases 1 to 3 and detection, frame by frame: render, record, filter, detect, score."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from math import nan

import numpy as np
from numpy.typing import NDArray

from bench.filter_choice import FilterChoice
from bench.illumination_grid import Illumination
from bench.metrics import detection, mask, restoration
from bench.robot_choice import DiscChoice
from bench.schema import FRAME_COLUMNS
from bench.sequences.rendered import RenderedSequence, calibration
from renderers.basis import LightBasis
from renderers.truth import Recording
from vslam.detect import DetectorSettings, DiscDetector
from vslam.filters import registry
from vslam.filters.apply import FilterFailureError, apply
from vslam.filters.base import Filtered, LightFilter
from vslam.frame import Observations
from vslam.scan import Scan, scan

VISIBLE_SHARE, VISIBLE_PIXELS = 0.5, 12
"""A landmark counts as visible if half of its area is in view and unoccluded and its picture has so many
pixels: an ellipse has five parameters, and a smaller blob leaves too few edge pixels to fit them."""


@dataclass(frozen=True, eq=False)
class Percept:
    """What one picture gave one filter variant.

    Attributes
    ----------
    observations : Observations
        The detector's, ids −1.
    landmark : (n,) int64
        True landmark of each observation (row in the scene's list), −1 for none. For scoring only.
    failed : str
        Why the filter failed on the picture; there are no observations then. Empty where it did not.
    """

    observations: Observations
    landmark: NDArray[np.int64]
    failed: str = ""


@dataclass(frozen=True, eq=False)
class FramePercepts:
    """All that one pose of the tour gave.

    Attributes
    ----------
    rows : list of dict
        Rows of the frames table.
    percepts : dict of (illumination name, filter label) to Percept
    scan : Scan
        The virtual laser scan from the depth image; light does not touch it.
    """

    frame: int
    rows: list[dict[str, object]]
    percepts: dict[tuple[str, str], Percept]
    scan: Scan


@dataclass(frozen=True, eq=False)
class Attempt:
    """What one filter made of one picture.

    Attributes
    ----------
    row : dict
        Its scores: a row of the frames table without labels.
    percept : Percept
    filtered : Filtered, optional
        None where it failed.
    """

    row: dict[str, object]
    percept: Percept
    filtered: Filtered | None = None


class Perception:
    """Runs the perception of a study's frames; lives in a worker process."""

    def __init__(self, sequence: RenderedSequence, engine: str) -> None:
        study = sequence.study
        self.sequence, self._engine = sequence, engine
        self.illuminations = study.illuminations.grid()
        self.filters = [(choice.label, make_filter(choice)) for choice in study.filters]
        self._calibration = calibration(study)
        self._detect: Callable[[NDArray[np.uint8]], Observations]
        self._detect = DiscDetector(self._calibration, detector_settings(study.discs))

    def frame(self, frame: int) -> FramePercepts:
        """Render one pose once, then record, filter, detect and score it under every illumination."""
        basis = self.sequence.basis(frame)
        visible = visible_landmarks(basis)
        rows, percepts = [], {}
        for illumination in self.illuminations:
            recording = self.sequence.record(basis, illumination, frame)
            target = restoration.Target(recording.diffuse)
            for label, light_filter in self.filters:
                tried = self.attempt(frame, recording, target, light_filter, visible)
                rows.append(tried.row | self.labels(illumination, frame, label))
                percepts[illumination.name, label] = tried.percept
        depth = self.sequence.measured_depth(basis, frame)
        return FramePercepts(frame, rows, percepts, scan(depth, self._calibration))

    def attempt(
        self,
        frame: int,
        recording: Recording,
        target: restoration.Target,
        light_filter: LightFilter,
        visible: NDArray[np.bool_],
    ) -> Attempt:
        """Filter and score; a filter that fails costs its own row, never the run."""
        start = time.perf_counter()
        try:
            filtered = apply(light_filter, recording.image)
        except FilterFailureError as error:
            return _failed(error.reason, recording, visible)
        seconds = time.perf_counter() - start
        row, percept = self.score(frame, recording, target, filtered, visible)
        return Attempt(row | {"filter_ms": 1e3 * seconds, "status": "ok"}, percept, filtered)

    def score(
        self,
        frame: int,
        recording: Recording,
        target: restoration.Target,
        filtered: Filtered,
        visible: NDArray[np.bool_],
    ) -> tuple[dict[str, object], Percept]:
        """Mask, repair and detected landmarks against the truth; and what was detected."""
        observations = self._detect(filtered.image)
        masks = mask.evaluate(filtered.mask, recording.highlight, filtered.score)
        repaired = restoration.evaluate(filtered.image, target, recording.highlight)
        discs = self._landmarks_from(frame)
        found = detection.evaluate(observations.points, discs[visible], discs)
        row = {
            **vars(masks),
            **vars(repaired),
            "landmarks_visible": found.visible,
            "landmarks_detected": found.detected,
            "detections_true": found.true,
        }
        return row, Percept(observations, found.assigned_ids)

    def labels(self, illumination: Illumination, frame: int, label: str) -> dict[str, object]:
        """The columns that say which picture and filter a row is about."""
        return {
            "scene": self.sequence.scene.name,
            **illumination.labels(),
            "frame": frame,
            "filter": label,
            "engine": self._engine,
        }

    def _landmarks_from(self, frame: int) -> NDArray[np.float64]:
        """The true landmarks in the robot's frame (eq. 3-6), (n, 2) metres."""
        x, y, theta = self.sequence.scene.tour.poses[frame]
        c, s = np.cos(theta), np.sin(theta)
        offset = self.sequence.scene.landmark_positions - (x, y)
        return np.asarray(offset @ np.array([[c, -s], [s, c]]))


def _failed(reason: str, recording: Recording, visible: NDArray[np.bool_]) -> Attempt:
    """What is known of a picture that a filter failed on: the truth, and nothing seen."""
    row = unmeasured() | {
        "true_share": float(recording.highlight.mean()),
        "landmarks_visible": int(visible.sum()),
        "landmarks_detected": 0,
        "detections_true": 0,
        "status": f"failed: {reason}",
    }
    return Attempt(row, Percept(Observations.none(), np.zeros(0, dtype=np.int64), reason))


def unmeasured() -> dict[str, object]:
    """NaN for every metric of the frames table."""
    return dict.fromkeys((name for name, kind in FRAME_COLUMNS.items() if kind == "float64"), nan)


def detector_settings(discs: DiscChoice) -> DetectorSettings:
    """The detector's settings with what a study says about its discs."""
    return DetectorSettings(**discs.model_dump())


def make_filter(choice: FilterChoice) -> LightFilter:
    """The light filter of a study's choice."""
    return registry.create(choice.name, **choice.parameters)


def visible_landmarks(basis: LightBasis) -> NDArray[np.bool_]:
    """(n,) bool: which of the scene's landmarks the picture shows well enough to be found."""
    pixels = np.bincount(basis.landmark[basis.landmark >= 0], minlength=len(basis.visible_share))
    return np.asarray((basis.visible_share >= VISIBLE_SHARE) & (pixels >= VISIBLE_PIXELS))
