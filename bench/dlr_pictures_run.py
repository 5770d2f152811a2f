"""The real pictures: calibrate the mount, filter and search every picture, then SLAM over what was found."""

from __future__ import annotations

import functools
import pickle
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import nan
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench import replay
from bench.camera_choice import CameraChoice, calibration
from bench.data import dlr_folder
from bench.dlr_detection import Scores, score
from bench.dlr_overlay import draw, sheet
from bench.kinds.dlr_pictures import DlrPicturesStudy
from bench.options import RunOptions
from bench.perception import detector_settings, make_filter
from bench.pictures import write_png
from bench.progress import Progress
from bench.run_facts import RunFacts, empty_frame_row, landmark_csv, run_stem
from bench.score import Replay
from bench.sequences import dlr
from bench.sequences.dlr_camera import robot_camera
from bench.sequences.dlr_mount import Sighting, calibrated
from bench.sequences.dlr_pictures import mapped_discs, on_picture, read_picture, thinned
from bench.store import RunFolder
from bench.workers import Workers, workers
from vslam.detect import DiscDetector
from vslam.filters.apply import FilterFailureError, apply
from vslam.frame import Observations
from vslam.slam import SlamSettings

BATCH = 16
"""Pictures per task."""
SHOWN = 6
"""Pictures on a filter's contact sheet."""


@dataclass(frozen=True)
class Setup:
    """What a process needs to look at pictures."""

    folder: Path
    study: DlrPicturesStudy
    camera: CameraChoice


@dataclass(frozen=True, eq=False)
class Looked:
    """What one picture gave one filter."""

    observations: Observations
    scores: Scores
    masked: float
    filter_ms: float
    status: str = "ok"


class Looker:
    """Filters and searches recorded pictures; lives in a worker process."""

    def __init__(self, setup: Setup) -> None:
        self.log = thinned(dlr.load(setup.folder), setup.study.stride)
        self.folder = setup.folder
        self._filters = [(choice.label, make_filter(choice)) for choice in setup.study.filters]
        self._view, self._log_view = calibration(setup.camera), calibration(robot_camera(setup.folder))
        self._detect = DiscDetector(self._view, detector_settings(setup.study.discs))

    def look(self, step: int) -> dict[str, Looked]:
        """Each filter's answer to the picture of a step."""
        picture = read_picture(self.folder, self.log.image_names[step])
        rows, mapped = self.log.steps[step][1], mapped_discs(self.log, step)
        looks = {}
        for label, light_filter in self._filters:
            start = time.perf_counter()
            try:
                filtered = apply(light_filter, picture)
            except FilterFailureError as error:
                nothing = score(Observations.none(), rows, mapped, self._view, self._log_view)
                status = f"failed: {error.reason}"
                looks[label] = Looked(Observations.none(), nothing, nan, nan, status)
                continue
            milliseconds = 1e3 * (time.perf_counter() - start)
            found = self._detect(filtered.image)
            scores = score(found, rows, mapped, self._view, self._log_view)
            ids = np.where(scores.disc >= 0, self.log.landmark_ids[scores.disc], -1)
            seen = Observations(found.points, found.covariances, ids)
            looks[label] = Looked(seen, scores, float(filtered.mask.mean()), milliseconds)
        return looks

    def pixels_of(self, step: int) -> NDArray[np.float64]:
        """(n, 2) float64: the detections in the unfiltered picture of a step, pixels."""
        picture = read_picture(self.folder, self.log.image_names[step])
        return on_picture(self._view, self._detect(picture).points)

    def show(self, step: int, label: str, look: Looked) -> NDArray[np.uint8]:
        """The filtered picture with its detections, annotated rows and mapped discs."""
        picture = read_picture(self.folder, self.log.image_names[step])
        filtered = picture if look.status != "ok" else apply(dict(self._filters)[label], picture).image
        rows = self.log.steps[step][1]
        return draw(
            filtered,
            on_picture(self._view, look.observations.points),
            look.scores.disc >= 0,
            on_picture(self._log_view, rows.points[rows.ids >= 0]),
        )


def run(study: DlrPicturesStudy, folder: RunFolder, options: RunOptions, progress: Progress) -> RunFacts:
    """Run the study into a run folder; frames that calibrated the mount have no row in the frames table."""
    facts = RunFacts("none")
    data = dlr_folder(options.data).resolve()
    setup = Setup(data, study, robot_camera(data))
    with workers(options.workers) as pool:
        with facts.timed("calibrate"):
            setup = _calibrate(setup, pool, progress)
        with facts.timed("perceive"):
            log = thinned(dlr.load(data), study.stride)
            looks = _look(setup, len(log.steps), pool, progress)
        with facts.timed("localise"):
            replays = _localise(study, log, looks, pool, progress)
    scored = [k for k in range(len(looks)) if not _calibrates(study, k * study.stride)]
    stamps = study.stride * np.arange(len(log.steps), dtype=np.float64)
    folder.write_frames([_row(study, k, label, look) for k in scored for label, look in looks[k].items()])
    folder.write_runs([result.row for result in replays])
    folder.write_trajectory("truth--dlr", stamps, log.truth[1:])
    for result in replays:
        if result.row["status"] == "ok":
            stem = run_stem(result.row)
            folder.write_trajectory(stem, stamps, result.poses)
            folder.write_text(f"figures/landmarks--{stem}.csv", landmark_csv(result.landmark_table))
    folder.write_text("figures/dlr-pictures.csv", _pictures_csv(study, looks, scored))
    folder.write_text("figures/dlr-detections.csv", _detections_csv(study, looks, scored))
    folder.write_json("figures/dlr-camera.json", setup.camera.model_dump(mode="json"))
    _show(setup, looks, scored, folder)
    return facts


def _calibrates(study: DlrPicturesStudy, step: int) -> bool:
    return bool(study.calibrate_every) and step % study.calibrate_every == 0


@functools.lru_cache(maxsize=2)
def _looker(pickled_setup: bytes) -> Looker:
    return Looker(pickle.loads(pickled_setup))


def _look_at(task: tuple[bytes, tuple[int, ...]]) -> list[dict[str, Looked]]:
    pickled_setup, steps = task
    return [_looker(pickled_setup).look(k) for k in steps]


def _pixels(task: tuple[bytes, tuple[int, ...]]) -> list[NDArray[np.float64]]:
    pickled_setup, steps = task
    return [_looker(pickled_setup).pixels_of(k) for k in steps]


def _batches(setup: Setup, steps: range) -> Iterator[tuple[bytes, tuple[int, ...]]]:
    pickled = pickle.dumps(setup)
    for start in range(0, len(steps), BATCH):
        yield pickled, tuple(steps[start : start + BATCH])


def _calibrate(setup: Setup, pool: Workers, progress: Progress) -> Setup:
    study = setup.study
    if not study.calibrate_every:
        return setup
    whole = replace(setup, study=study.model_copy(update={"stride": 1}))
    log = dlr.load(setup.folder)
    steps = range(0, len(log.steps), study.calibrate_every)
    sightings: list[Sighting] = []
    with progress.stage("calibrate", len(steps)) as advance:
        for batch in pool.map(_pixels, _batches(whole, steps)):
            for pixels in batch:
                sightings.append((pixels, mapped_discs(log, steps[len(sightings)])))
                advance(1)
    return replace(setup, camera=calibrated(setup.camera, sightings))


def _look(setup: Setup, count: int, pool: Workers, progress: Progress) -> list[dict[str, Looked]]:
    looks = []
    with progress.stage("perceive", count) as advance:
        for batch in pool.map(_look_at, _batches(setup, range(count))):
            looks += batch
            advance(len(batch))
    return looks


def _replay(task: tuple[dlr.DlrLog, SlamSettings, str]) -> list[Replay]:
    log, settings, label = task
    done = replay.replays(log, settings, settings.backend, settings.seed)
    return [replace(one, row=one.row | {"filter": label}) for one in done]


def _localise(
    study: DlrPicturesStudy,
    log: dlr.DlrLog,
    looks: list[dict[str, Looked]],
    pool: Workers,
    progress: Progress,
) -> list[Replay]:
    tasks = []
    for choice in study.filters:
        steps = tuple(
            (odometry, look[choice.label].observations)
            for (odometry, _), look in zip(log.steps, looks, strict=True)
        )
        for slam in study.slam:
            settings = SlamSettings(
                slam.backend, slam.association, slam.observation, slam.gate, seed=study.seed
            )
            tasks.append((replace(log, steps=steps), settings, choice.label))
    done: list[Replay] = []
    with progress.stage("localise", len(tasks)) as advance:
        for results in pool.map(_replay, tasks):
            done += results
            advance(1)
    return done


def _row(study: DlrPicturesStudy, step: int, label: str, look: Looked) -> dict[str, object]:
    return empty_frame_row() | {
        "scene": "dlr",
        "illumination": "recorded",
        "frame": step * study.stride,
        "filter": label,
        "engine": "none",
        "masked_share": look.masked,
        "landmarks_visible": look.scores.annotated,
        "landmarks_detected": look.scores.detected,
        "detections_true": look.scores.true,
        "filter_ms": look.filter_ms,
        "status": look.status,
    }


def _pictures_csv(study: DlrPicturesStudy, looks: list[dict[str, Looked]], scored: list[int]) -> str:
    lines = ["frame,filter,annotated,found,found_by_pixel,detected,true"]
    for k in scored:
        for label, look in looks[k].items():
            s = look.scores
            counts = (s.annotated, s.found, s.found_by_pixel, s.detected, s.true)
            lines.append(f"{k * study.stride},{label},{','.join(map(str, counts))}")
    return "\n".join(lines) + "\n"


def _detections_csv(study: DlrPicturesStudy, looks: list[dict[str, Looked]], scored: list[int]) -> str:
    lines = ["frame,filter,range_m,bearing_rad,range_error_m,bearing_error_rad,squared_mahalanobis"]
    for k in scored:
        for label, look in looks[k].items():
            for error in look.scores.errors:
                lines.append(f"{k * study.stride},{label},{','.join(f'{value:.6g}' for value in error)}")
    return "\n".join(lines) + "\n"


def _show(setup: Setup, looks: list[dict[str, Looked]], scored: list[int], folder: RunFolder) -> None:
    looker = _looker(pickle.dumps(setup))
    chosen = [scored[i] for i in np.linspace(0, len(scored) - 1, min(SHOWN, len(scored))).round().astype(int)]
    for label in looks[0]:
        shown = sheet([looker.show(k, label, looks[k][label]) for k in chosen])
        write_png(folder.path / "figures" / f"dlr-pictures--{label}.png", shown)
