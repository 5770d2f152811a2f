"""Filters and detector on the DLR robot's own pictures with light composited onto them."""

from __future__ import annotations

import functools
import pickle
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bench import strips
from bench.camera_choice import calibration
from bench.data import dlr_folder
from bench.dlr_detection import GATE_M
from bench.illumination_grid import Illumination
from bench.kinds.dlr_light import DlrLightStudy
from bench.kinds.rendered import RenderedStudy
from bench.metrics import mask, restoration
from bench.metrics.detection import match
from bench.options import RunOptions
from bench.perception import detector_settings, make_filter
from bench.progress import Progress
from bench.rendered_run import prepared
from bench.run_facts import RunFacts, empty_frame_row
from bench.sequences import dlr
from bench.sequences.dlr_camera import robot_camera
from bench.sequences.dlr_light import Composite, FloorLight, study_of
from bench.sequences.dlr_pictures import read_picture, thinned
from bench.sequences.rendered import RenderedSequence, SequenceSetup
from bench.store import RunFolder
from bench.workers import workers
from renderers.engine import choose_engine
from vslam.detect import DiscDetector
from vslam.filters.apply import FilterFailureError, apply
from vslam.filters.base import Filtered, LightFilter

Row = dict[str, object]
RECORDED = "recorded"
"""The illumination of pictures as they are: nothing composited, nothing to find."""


@dataclass(frozen=True)
class Setup:
    """What a process needs."""

    study: DlrLightStudy
    folder: Path
    scene: SequenceSetup


class Looker:
    """Composites, filters and searches pictures; lives in a worker process."""

    def __init__(self, setup: Setup) -> None:
        study = setup.study
        self.study, self.folder = study, setup.folder
        self.log = thinned(dlr.load(setup.folder), study.stride)
        self._light = FloorLight(RenderedSequence(setup.scene), study.own_lamps_lm)
        self.illuminations = study.illuminations.grid()
        self.filters: dict[str, LightFilter] = {c.label: make_filter(c) for c in study.filters}
        camera = calibration(setup.scene.study.camera)
        self._detect = DiscDetector(camera, detector_settings(study.discs))

    def rows(self, step: int) -> list[Row]:
        """Every filter on the picture of a step as recorded and under every illumination."""
        rows = []
        for illumination, picture in self.pictures(step):
            target = restoration.Target(picture.original)
            for label, light_filter in self.filters.items():
                row = self._labels(step, illumination, label)
                rows.append(row | self._scores(step, picture, target, light_filter))
        return rows

    def pictures(self, step: int) -> list[tuple[Illumination | None, Composite]]:
        """The picture of a step as recorded (None), and under every illumination."""
        original = read_picture(self.folder, self.log.image_names[step])
        dark = Composite(original, original, np.zeros(original.shape[:2], dtype=np.bool_))
        basis = self._light.basis(step)
        lit = [
            (i, self._light.composite(original, basis, i, step, self.study.highlight_threshold))
            for i in self.illuminations
        ]
        return [(None, dark), *lit]

    def _labels(self, step: int, illumination: Illumination | None, label: str) -> Row:
        named = {"illumination": RECORDED, "lamps": "all"} if illumination is None else illumination.labels()
        place = {"scene": "dlr", "frame": step * self.study.stride, "filter": label, "engine": "composited"}
        return empty_frame_row() | named | place

    def _scores(
        self, step: int, picture: Composite, target: restoration.Target, light_filter: LightFilter
    ) -> Row:
        rows = self.log.steps[step][1]
        annotated = rows.points[rows.ids >= 0]
        known: Row = {
            "true_share": float(picture.highlight.mean()),
            "landmarks_visible": len(annotated),
        }
        start = time.perf_counter()
        try:
            filtered = apply(light_filter, picture.image)
        except FilterFailureError as error:
            return known | {"status": f"failed: {error.reason}"}
        seconds = time.perf_counter() - start
        found = self._detect(filtered.image)
        return (
            known
            | _picture_scores(filtered, picture, target)
            | {
                "landmarks_detected": len(found),
                "detections_true": len(match(annotated, found.points, GATE_M)),
                "filter_ms": 1e3 * seconds,
                "status": "ok",
            }
        )

    def strip(self, choice: strips.Choice) -> strips.Strip:
        """What a chosen row was made of."""
        step = int(choice.row["frame"]) // self.study.stride
        named = {(RECORDED if i is None else i.name): picture for i, picture in self.pictures(step)}
        picture = named[str(choice.row["illumination"])]
        filtered = apply(self.filters[str(choice.row["filter"])], picture.image)
        parts = (picture.image, picture.highlight, filtered.mask, filtered.image, picture.original)
        return strips.Strip(choice, dict(zip(strips.PICTURES, parts, strict=True)))


def _picture_scores(filtered: Filtered, picture: Composite, target: restoration.Target) -> Row:
    masks = mask.evaluate(filtered.mask, picture.highlight, filtered.score)
    return vars(masks) | vars(restoration.evaluate(filtered.image, target, picture.highlight))


def run(study: DlrLightStudy, folder: RunFolder, options: RunOptions, progress: Progress) -> RunFacts:
    """Run the study into a run folder; the table of SLAM runs stays empty."""
    data = dlr_folder(options.data).resolve()
    engine = choose_engine("raycast")
    facts = RunFacts(engine.name, engine.notice)
    base = RenderedStudy.model_validate({"sequence": "rendered", "name": study.name, "seed": study.seed})
    base = base.model_copy(update={"illuminations": study.illuminations, "camera": robot_camera(data)})
    building = study_of(base, data, study.stride, study.floor_roughness)
    with prepared(building, engine.name, facts, progress) as scene, workers(options.workers) as pool:
        setup = Setup(study, data, replace(scene, threads=0 if options.workers <= 1 else 1))
        steps = range(len(thinned(dlr.load(data), study.stride).steps))
        rows: list[Row] = []
        with facts.timed("perceive"), progress.stage("perceive", len(steps)) as advance:
            pickled = pickle.dumps(setup)
            for done in pool.map(_rows, [(pickled, k) for k in steps]):
                rows += done
                advance(1)
        with facts.timed("pictures"):
            choices = strips.choose([r for r in rows if r["illumination"] != RECORDED])
            shown = list(pool.map(_strip, [(pickled, choice) for choice in choices]))
    folder.write_frames(rows)
    folder.write_runs([])
    strips.write(folder.path / "figures", shown)
    return facts


@functools.lru_cache(maxsize=1)
def _looker(pickled_setup: bytes) -> Looker:
    return Looker(pickle.loads(pickled_setup))


def _rows(task: tuple[bytes, int]) -> list[Row]:
    pickled, step = task
    return _looker(pickled).rows(step)


def _strip(task: tuple[bytes, strips.Choice]) -> strips.Strip:
    pickled, choice = task
    return _looker(pickled).strip(choice)
