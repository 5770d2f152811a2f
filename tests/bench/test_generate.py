"""Generated data sets: read back with other code, equal to what was rendered, whole or not there at all."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bench.camera_choice import camera
from bench.errors import BenchError
from bench.generate import generate
from bench.options import GenerateOptions
from bench.progress import Silent
from bench.sequences.lighting import light_colours
from bench.sequences.rendered import RenderedSequence, SequenceSetup
from bench.study_model import RenderedStudy
from renderers.camera import pixel_grid

NAME = "sun20000-bulb800"
FRAMES = 3

pytestmark = pytest.mark.usefixtures("cache_home")


@pytest.fixture(scope="module")
def folder(short_study: RenderedStudy, cache_home: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("pictures")
    (written,) = generate(short_study, GenerateOptions(out, (NAME,), FRAMES), Silent())
    assert written == out / "corridor" / NAME
    assert list((out / "corridor").iterdir()) == [written]
    return written


@pytest.fixture(scope="module")
def sequence(short_study: RenderedStudy, cache_home: Path) -> RenderedSequence:
    colours = light_colours(short_study)
    return RenderedSequence(SequenceSetup(short_study, "raycast", colours, 0, cache_home / "glarebench"))


def _read(path: Path) -> np.ndarray:
    picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert picture is not None, path
    return cv2.cvtColor(picture, cv2.COLOR_BGR2RGB) if picture.ndim == 3 else picture


def _associations(path: Path) -> dict[float, str]:
    lines = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    return {float(stamp): name for stamp, name in lines}


def test_the_lists_name_every_picture_at_the_time_of_its_pose(folder: Path) -> None:
    rgb, depth = _associations(folder / "rgb.txt"), _associations(folder / "depth.txt")
    track = np.loadtxt(folder / "groundtruth.txt")
    assert list(rgb) == list(depth) == track[:, 0].tolist() == [0.0, 0.5, 1.0]
    for name in (*rgb.values(), *depth.values()):
        assert (folder / name).is_file()


def test_the_pictures_are_those_of_the_run(folder: Path, sequence: RenderedSequence) -> None:
    illumination = next(i for i in sequence.study.illuminations.grid() if i.name == NAME)
    for frame in range(FRAMES):
        basis = sequence.basis(frame)
        recording = sequence.record(basis, illumination, frame)
        np.testing.assert_array_equal(_read(folder / f"rgb/{frame:06d}.png"), recording.image)
        raw = _read(folder / f"raw/{frame:06d}.png")
        assert raw.dtype == np.uint16
        np.testing.assert_array_equal(raw, recording.raw)
        np.testing.assert_array_equal(_read(folder / f"mask/{frame:06d}.png") > 0, recording.highlight)
        depth = _read(folder / f"depth/{frame:06d}.png")
        assert depth.dtype == np.uint16
        near = (basis.depth > 0) & (basis.depth < 13)
        assert (basis.depth > 13.2).any() and (depth[basis.depth > 13.2] == 0).all()  # no number for it
        np.testing.assert_allclose(depth[near] / 5000, basis.depth[near], atol=1.01e-4)
        assert (depth[basis.depth == 0] == 0).all()


def test_diffuse_and_specular_add_up_to_the_recorded_light(folder: Path, sequence: RenderedSequence) -> None:
    """Independent of our sensor code: linear light, white balance and the sRGB curve, written out here."""
    meta = json.loads((folder / "meta.json").read_text())
    full_scale = 65535.0
    for frame in range(FRAMES):
        linear = sum(
            _read(folder / f"{part}/{frame:06d}.png").astype(float) / full_scale
            for part in ("diffuse", "specular")
        )
        balanced = np.clip(linear * np.array(meta["white_balance"][frame]), 0, 1)
        encoded = 255 * np.where(
            balanced <= 0.0031308, 12.92 * balanced, 1.055 * balanced ** (1 / 2.4) - 0.055
        )
        recorded = _read(folder / f"rgb/{frame:06d}.png").astype(float)
        unclipped = (linear < 0.99).all(axis=-1)
        difference = (recorded - encoded)[unclipped]
        assert abs(np.median(difference)) < 1.0  # noise has no bias in the middle
        assert np.percentile(np.abs(difference), 99) < 40


def test_a_mosaic_on_disk_develops_to_the_picture_beside_it(
    short_study: RenderedStudy, tmp_path: Path
) -> None:
    """By OpenCV and what meta.json says: black, white balance, demosaicing, colour matrix, sRGB."""
    sensor = {"preset": "machine-vision", "sensitivities": "nikon-5100", "exposure": 0.002, "gain_db": 6}
    study = RenderedStudy.model_validate(short_study.model_dump(mode="json") | {"sensor": sensor})
    (written,) = generate(study, GenerateOptions(tmp_path, (NAME,), 1), Silent())
    meta, raw = json.loads((written / "meta.json").read_text()), _read(written / "raw/000000.png")
    assert raw.dtype == np.uint16 and raw.shape == (240, 320)
    assert meta["gain_db"] == [6.0] and meta["sensor"]["colour_filter_array"] == "RGGB"
    black, white = meta["sensor"]["black_level_dn"], 2 ** meta["sensor"]["bit_depth"] - 1
    planes = cv2.demosaicing(raw, cv2.COLOR_BayerBG2RGB)  # OpenCV's name for RGGB
    linear = (planes.astype(float) - black) / (white - black)
    balanced = np.clip(linear * meta["white_balance"][0], 0, 1) @ np.transpose(meta["colour_matrix"])
    light = np.clip(balanced, 0, 1)
    encoded = 255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    difference = encoded - _read(written / "rgb/000000.png")
    assert np.median(np.abs(difference)) < 4  # bilinear there, Malvar here
    assert np.abs(np.median(difference, axis=(0, 1))).max() < 1


def test_landmarks_and_poses_are_the_scene_s(folder: Path, sequence: RenderedSequence) -> None:
    rows = np.genfromtxt(folder / "landmarks.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    np.testing.assert_allclose(
        np.column_stack([rows["x_m"], rows["y_m"]]), sequence.scene.landmark_positions, atol=1e-6
    )


def test_the_ground_truth_is_the_camera_s_pose(folder: Path, sequence: RenderedSequence) -> None:
    """Depth, back-projected through the poses on disk alone, puts the floor at z = 0."""
    track = np.loadtxt(folder / "groundtruth.txt")
    np.testing.assert_allclose(track[:, 1:3], sequence.scene.tour.poses[:FRAMES, :2], atol=1e-8)
    np.testing.assert_allclose(track[:, 3], sequence.study.camera.height_m)
    eye = camera(sequence.study.camera)
    rays = eye.unproject(pixel_grid(eye))
    for frame in range(FRAMES):
        rotation = Rotation.from_quat(track[frame, 4:8]).as_matrix()
        z = _read(folder / f"depth/{frame:06d}.png") / 5000
        on_floor = (sequence.basis(frame).surface == 0) & (z > 0) & (rays[..., 2] > 0.2)
        points = rays[on_floor] / rays[on_floor][:, 2:] * z[on_floor][:, None]
        height = points @ rotation[2] + track[frame, 3]
        assert on_floor.sum() > 5000 and np.abs(height).max() < 0.01


def test_an_existing_folder_is_refused_and_kept(folder: Path, short_study: RenderedStudy) -> None:
    before = sorted(folder.rglob("*"))
    with pytest.raises(BenchError, match="exists already"):
        generate(short_study, GenerateOptions(folder.parent.parent, (NAME,), 1), Silent())
    assert sorted(folder.rglob("*")) == before


def test_an_unknown_illumination_suggests_the_near_one(short_study: RenderedStudy, tmp_path: Path) -> None:
    with pytest.raises(BenchError, match="did you mean 'sun20000-bulb800'"):
        generate(short_study, GenerateOptions(tmp_path, ("sun20000-bulb80",), 1), Silent())
    assert list(tmp_path.iterdir()) == []


def test_an_interrupted_job_leaves_no_half_written_folder(short_study: RenderedStudy, tmp_path: Path) -> None:
    class Interrupts(Silent):
        def stage(self, title: str, total: int):  # type: ignore[no-untyped-def]
            if title == "generate":
                raise KeyboardInterrupt
            return super().stage(title, total)

    with pytest.raises(KeyboardInterrupt):
        generate(short_study, GenerateOptions(tmp_path, (NAME,), 2), Interrupts())
    assert [p for p in tmp_path.rglob("*") if p.is_file()] == []
    assert list((tmp_path / "corridor").iterdir()) == []


def test_too_little_disk_is_said_before_anything_is_written(
    short_study: RenderedStudy, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import shutil

    full = shutil.disk_usage(tmp_path)._replace(free=1000)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: full)
    with pytest.raises(BenchError, match="MB needed"):
        generate(short_study, GenerateOptions(tmp_path, (NAME,), 2), Silent())
    assert [p for p in tmp_path.rglob("*") if p.is_file()] == []
