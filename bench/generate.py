"""Rendered pictures with their ground truth, as TUM RGB-D folders that other tools open as they are."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path

import numpy as np

from bench.disk import require_free
from bench.errors import BenchError, unknown_name
from bench.options import GenerateOptions
from bench.pictures import write_png
from bench.progress import Progress
from bench.provenance import version
from bench.rendered_run import prepared
from bench.run_facts import RunFacts
from bench.sequences.lighting import load_scene
from bench.sequences.rendered import RenderedSequence, calibration
from bench.study_model import Illumination, RenderedStudy
from renderers.basis import LightBasis
from renderers.camera import T_world_robot
from renderers.colour_matrix import correction
from renderers.engine import choose_engine
from renderers.metering import Exposure
from renderers.sensor import mean_electrons
from renderers.truth import Recording

DEPTH_FACTOR = 5000
"""Grey levels per metre in depth pictures, as TUM RGB-D has them."""

BYTES_PER_PIXEL = 11
"""What a frame's six PNG files take, for the check of free disk; 9.0 in the corridor at noon."""


def generate(study: RenderedStudy, options: GenerateOptions, progress: Progress) -> list[Path]:
    """Write ``OUT/<scene>/<illumination>/`` for the chosen illuminations.

    Each folder is written aside and renamed when it is whole; one that exists is refused beforehand.

    Returns
    -------
    list of Path
        The folders written.

    Raises
    ------
    BenchError
        For an unknown illumination, a folder that exists or cannot be written, or too little disk.
    """
    illuminations = _chosen(study, options.illuminations)
    folders = [options.out / study.scene.name / i.name for i in illuminations]
    _check(folders, options.out)
    length = len(load_scene(study).tour.stamps)
    frames = range(min(options.frames or length, length))
    pixels = len(folders) * len(frames) * study.camera.width * study.camera.height
    require_free(options.out, pixels * BYTES_PER_PIXEL, "take fewer with --frames or --illumination")
    choice = choose_engine(study.engine)
    if choice.notice:
        progress.notice(choice.notice)
    facts = RunFacts(choice.name, choice.notice)
    with prepared(study, choice.name, facts, progress) as setup, ExitStack() as stack:
        sequence = RenderedSequence(setup)
        writers = [
            stack.enter_context(_Folder(folder, illumination, sequence, facts))
            for folder, illumination in zip(folders, illuminations, strict=True)
        ]
        with progress.stage("generate", len(frames)) as advance:
            for frame in frames:
                basis = sequence.basis(frame)
                for writer in writers:
                    writer.add(frame, basis)
                advance(1)
        for writer in writers:
            writer.finish()
    return folders


def _chosen(study: RenderedStudy, names: Sequence[str]) -> list[Illumination]:
    grid = {i.name: i for i in study.illuminations.grid()}
    for name in names:
        if name not in grid:
            raise unknown_name("illumination", name, grid)
    return [grid[name] for name in dict.fromkeys(names)] or list(grid.values())


def _check(folders: Sequence[Path], out: Path) -> None:
    for folder in folders:
        if folder.exists():
            raise BenchError(f"{folder}: exists already; move it away or choose another --out")
    try:
        folders[0].parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BenchError(f"{out}: cannot be written ({error.strerror}); choose another with --out") from None


def _tum_line(stamp: float, T_world_camera: np.ndarray) -> str:
    """A pose of the camera as TUM RGB-D writes it: stamp, position, quaternion (x y z w)."""
    from scipy.spatial.transform import Rotation

    numbers = [*T_world_camera[:3, 3], *Rotation.from_matrix(T_world_camera[:3, :3]).as_quat(canonical=True)]
    return " ".join([f"{stamp:.6f}", *(f"{number:.9f}" for number in numbers)])


class _Folder:
    """One illumination's folder while it is written."""

    def __init__(
        self, final: Path, illumination: Illumination, sequence: RenderedSequence, facts: RunFacts
    ) -> None:
        self._final, self._illumination, self._sequence, self._facts = final, illumination, sequence, facts
        self._aside = final.with_name(f".{final.name}.partial-{os.getpid()}")
        self._frames: list[int] = []
        self._exposures: list[Exposure] = []
        try:
            for name in ("rgb", "raw", "depth", "mask", "diffuse", "specular"):
                (self._aside / name).mkdir(parents=True)
        except OSError as error:
            raise BenchError(f"{final}: cannot be written ({error.strerror}); choose another --out") from None

    def add(self, frame: int, basis: LightBasis) -> None:
        recording = self._sequence.record(basis, self._illumination, frame)
        diffuse, specular = self._sequence.relight(basis, self._illumination, frame)
        grey = np.round(basis.depth * DEPTH_FACTOR)
        depth = np.where(grey <= 65535, grey, 0).astype(np.uint16)  # beyond 13.1 m there is no number for it
        for name, picture in (
            ("rgb", recording.image),
            ("raw", recording.raw),
            ("depth", depth),
            ("mask", recording.highlight),
            ("diffuse", self._linear(diffuse, recording)),
            ("specular", self._linear(specular, recording)),
        ):
            write_png(self._aside / name / f"{frame:06d}.png", picture)
        self._frames.append(frame)
        self._exposures.append(recording.exposure)

    def _linear(self, luminance: np.ndarray, recording: Recording) -> np.ndarray:
        """Luminance behind the colour filters as 16-bit linear numbers, saturation = 65535; clipped there."""
        sensor, exposure = self._sequence.sensor, recording.exposure
        electrons = mean_electrons(sensor, luminance, exposure.seconds)
        share = electrons / sensor.amplified(exposure.gain_db).saturation_e
        return np.asarray(np.round(np.clip(share, 0, 1) * 65535).astype(np.uint16))

    def finish(self) -> None:
        tour = self._sequence.scene.tour
        stamps = tour.stamps[self._frames]
        for name in ("rgb", "depth"):
            lines = [f"{t:.6f} {name}/{k:06d}.png\n" for t, k in zip(stamps, self._frames, strict=True)]
            self._text(f"{name}.txt", f"# timestamp filename\n{''.join(lines)}")
        mount = calibration(self._sequence.study).T_robot_camera
        track = [
            _tum_line(stamp, T_world_robot(tour.poses[frame]) @ mount)
            for stamp, frame in zip(stamps, self._frames, strict=True)
        ]
        self._text("groundtruth.txt", "# timestamp tx ty tz qx qy qz qw\n" + "\n".join(track) + "\n")
        marks = [
            f"{m.id},{m.position[0]:.6f},{m.position[1]:.6f},{m.radius:.6f},{colour}\n"
            for m in self._sequence.scene.landmarks
            for colour in ("white" if m.white else "black",)
        ]
        self._text("landmarks.csv", f"id,x_m,y_m,radius_m,colour\n{''.join(marks)}")
        self._text("meta.json", json.dumps(self._meta(), indent=2) + "\n")
        self._aside.rename(self._final)

    def __enter__(self) -> _Folder:
        return self

    def __exit__(self, *_: object) -> None:
        shutil.rmtree(self._aside, ignore_errors=True)  # there only if it was not finished

    def _text(self, name: str, text: str) -> None:
        (self._aside / name).write_text(text, encoding="utf-8", newline="\n")

    def _meta(self) -> dict[str, object]:
        study, view = self._sequence.study, calibration(self._sequence.study)
        return {
            "scene": self._sequence.scene.name,
            "illumination": asdict(self._illumination),
            "frames": len(self._frames),
            "glarebench": version("glarebench"),
            "engine": self._facts.engine,
            "seed": study.seed,
            "camera": {
                "model": view.model,
                "width": view.width,
                "height": view.height,
                "fx": view.fx,
                "fy": view.fy,
                "cx": view.cx,
                "cy": view.cy,
                "distortion": list(view.distortion),
                "T_robot_camera": view.T_robot_camera.tolist(),
            },
            "poses": "groundtruth.txt holds T_world_camera = T_world_robot · T_robot_camera",
            "depth": {
                "factor": DEPTH_FACTOR,
                "meaning": "z in the camera frame, exact, without noise; 0 = none, or beyond 13.1 m",
            },
            "linear": (
                "diffuse + specular: 65535 = saturation, behind the colour filters, noise-free, clipped; "
                "times white_balance, then colour_matrix, it is linear sRGB"
            ),
            "mask": f"255 where specular light adds {study.sensor.highlight_threshold} grey levels or more",
            "sensor": study.sensor.model_dump(mode="json"),
            "raw": "the sensor's own numbers, a mosaic behind a colour filter array; black_level_dn is dark",
            "exposure_s": [exposure.seconds for exposure in self._exposures],
            "gain_db": [exposure.gain_db for exposure in self._exposures],
            "white_balance": [exposure.white_balance.tolist() for exposure in self._exposures],
            "colour_matrix": correction(study.sensor.sensitivities).tolist(),
        }
