"""Every layout, read back with other people's code, holds the numbers that were rendered."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
import yaml
from evo.core import metrics, sync
from evo.tools import file_interface
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bench.camera_choice import camera
from bench.generate import generate
from bench.illumination_grid import Illumination
from bench.kinds.rendered import RenderedStudy
from bench.options import GenerateOptions
from bench.progress import Silent
from bench.sequences import pairs
from bench.sequences.lighting import light_colours
from bench.sequences.rendered import RenderedSequence, SequenceSetup
from renderers.basis import LightBasis
from renderers.camera import pixel_grid, pixel_rays
from renderers.truth import Recording

NAME = "sun20000-bulb800"
FRAMES = 3
LAYOUTS = ("tum", "euroc", "coco", "exr", "exr-float", "raw", "pairs")

pytestmark = pytest.mark.usefixtures("cache_home")


@pytest.fixture(scope="module")
def root(short_study: RenderedStudy, cache_home: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("pictures")
    generate(short_study, GenerateOptions(out, (NAME,), FRAMES, LAYOUTS), Silent())
    return out


@pytest.fixture(scope="module")
def sequence(short_study: RenderedStudy, cache_home: Path) -> RenderedSequence:
    colours = light_colours(short_study)
    return RenderedSequence(SequenceSetup(short_study, "raycast", colours, 0, cache_home / "glarebench"))


@pytest.fixture(scope="module")
def illumination(short_study: RenderedStudy) -> Illumination:
    return next(i for i in short_study.illuminations.grid() if i.name == NAME)


@pytest.fixture(scope="module")
def taken(
    sequence: RenderedSequence, illumination: Illumination
) -> list[tuple[LightBasis, Recording, NDArray, NDArray]]:
    """What each frame is, rendered here once more: basis, recording, diffuse and specular luminance."""
    bases = [sequence.basis(frame) for frame in range(FRAMES)]
    return [
        (basis, sequence.record(basis, illumination, k), *sequence.relight(basis, illumination, k))
        for k, basis in enumerate(bases)
    ]


def _folder(root: Path, layout: str) -> Path:
    return root / layout / "corridor" / NAME


def _read(path: Path) -> np.ndarray:
    picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert picture is not None, path
    return cv2.cvtColor(picture, cv2.COLOR_BGR2RGB) if picture.ndim == 3 else picture


def _associations(path: Path) -> dict[float, str]:
    lines = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    return {float(stamp): name for stamp, name in lines}


def test_tum_lists_name_every_picture_at_the_time_of_its_pose(root):
    folder = _folder(root, "tum")
    rgb, depth = _associations(folder / "rgb.txt"), _associations(folder / "depth.txt")
    track = np.loadtxt(folder / "groundtruth.txt")
    assert list(rgb) == list(depth) == track[:, 0].tolist() == [0.0, 0.5, 1.0]
    for name in (*rgb.values(), *depth.values()):
        assert (folder / name).is_file()


def test_tum_pictures_are_those_of_the_run(root, taken):
    folder = _folder(root, "tum")
    for frame, (basis, recording, *_) in enumerate(taken):
        np.testing.assert_array_equal(_read(folder / f"rgb/{frame:06d}.png"), recording.image)
        np.testing.assert_array_equal(_read(folder / f"mask/{frame:06d}.png") > 0, recording.highlight)
        depth = _read(folder / f"depth/{frame:06d}.png")
        assert depth.dtype == np.uint16
        near = (basis.depth > 0) & (basis.depth < 13)
        assert (basis.depth > 13.2).any() and (depth[basis.depth > 13.2] == 0).all()  # no number for it
        np.testing.assert_allclose(depth[near] / 5000, basis.depth[near], atol=1.01e-4)
        assert (depth[basis.depth == 0] == 0).all()


def test_tum_diffuse_and_specular_add_up_to_the_recorded_light(root):
    """Independent of our sensor code: linear light, white balance and the sRGB curve, written out here."""
    folder, table = _folder(root, "tum"), pd.read_csv(root / "frames.csv")
    for frame in range(FRAMES):
        parts = [_read(folder / f"{p}/{frame:06d}.png").astype(float) for p in ("diffuse", "specular")]
        linear = sum(parts) / 65535.0
        gains = table.loc[frame, ["white_r", "white_g", "white_b"]].to_numpy(dtype=float)
        balanced = np.clip(linear * gains, 0, 1)
        curve = np.where(balanced <= 0.0031308, 12.92 * balanced, 1.055 * balanced ** (1 / 2.4) - 0.055)
        recorded = _read(folder / f"rgb/{frame:06d}.png").astype(float)
        difference = (recorded - 255 * curve)[(linear < 0.99).all(axis=-1)]
        assert abs(np.median(difference)) < 1.0  # noise has no bias in the middle
        assert np.percentile(np.abs(difference), 99) < 40


def test_tum_landmarks_are_the_scene_s(root, sequence):
    rows = pd.read_csv(_folder(root, "tum") / "landmarks.csv")
    np.testing.assert_allclose(rows[["x_m", "y_m"]], sequence.scene.landmark_positions, atol=1e-6)


def test_tum_depth_and_poses_put_the_floor_at_zero(root, sequence, taken):
    """Depth, back-projected through the poses on disk alone: z, not the distance along the ray."""
    folder = _folder(root, "tum")
    track = np.loadtxt(folder / "groundtruth.txt")
    np.testing.assert_allclose(track[:, 1:3], sequence.scene.tour.poses[:FRAMES, :2], atol=1e-8)
    np.testing.assert_allclose(track[:, 3], sequence.study.camera.height_m)
    rays = pixel_rays(camera(sequence.study.camera))
    for frame, (basis, *_) in enumerate(taken):
        rotation = Rotation.from_quat(track[frame, 4:8]).as_matrix()
        z = _read(folder / f"depth/{frame:06d}.png") / 5000
        on_floor = (basis.surface == 0) & (z > 0) & (rays[..., 2] > 0.2)
        points = rays[on_floor] / rays[on_floor][:, 2:] * z[on_floor][:, None]
        height = points @ rotation[2] + track[frame, 3]
        assert on_floor.sum() > 5000 and np.abs(height).max() < 0.01


def test_euroc_pictures_stand_in_the_list_in_order(root, taken):
    folder = _folder(root, "euroc") / "mav0" / "cam0"
    listed = pd.read_csv(folder / "data.csv", dtype={"filename": str})
    assert listed["#timestamp [ns]"].tolist() == [0, 500_000_000, 1_000_000_000]
    assert sorted(p.name for p in (folder / "data").iterdir()) == listed["filename"].tolist()
    for name, (_, recording, *_) in zip(listed["filename"], taken, strict=True):
        np.testing.assert_array_equal(_read(folder / "data" / name), recording.image)


def test_euroc_calibration_is_the_camera_s_for_opencv(root, sequence):
    """Kalibr's pinhole-equidistant is OpenCV's fisheye."""
    sheet = yaml.safe_load((_folder(root, "euroc") / "mav0/cam0/sensor.yaml").read_text())
    assert (sheet["camera_model"], sheet["distortion_model"]) == ("pinhole", "equidistant")
    assert sheet["resolution"] == [320, 240] and sheet["rate_hz"] == 2
    fu, fv, cu, cv = sheet["intrinsics"]
    K = np.array([[fu, 0, cu], [0, fv, cv], [0, 0, 1]])
    pixels = pixel_grid(camera(sequence.study.camera))[60:180, 80:240].reshape(-1, 1, 2)
    flat = cv2.fisheye.undistortPoints(pixels, K, np.array(sheet["distortion_coefficients"]))[:, 0]
    rays = pixel_rays(camera(sequence.study.camera))[60:180, 80:240].reshape(-1, 3)
    np.testing.assert_allclose(flat, rays[:, :2] / rays[:, 2:], atol=1e-6)


def test_euroc_body_poses_and_extrinsics_give_tum_s_camera_poses(root, sequence):
    mav0 = _folder(root, "euroc") / "mav0"
    T_BS = np.reshape(yaml.safe_load((mav0 / "cam0/sensor.yaml").read_text())["T_BS"]["data"], (4, 4))
    truth = pd.read_csv(mav0 / "state_groundtruth_estimate0/data.csv").to_numpy(dtype=float)
    assert truth.shape == (FRAMES, 17)
    tum = np.loadtxt(_folder(root, "tum") / "groundtruth.txt")
    np.testing.assert_allclose(truth[:, 0] * 1e-9, tum[:, 0])
    body = Rotation.from_quat(truth[:, [5, 6, 7, 4]])
    np.testing.assert_allclose(truth[:, 1:4] + body.apply(T_BS[:3, 3]), tum[:, 1:4], atol=1e-8)
    turned = body * Rotation.from_matrix(T_BS[:3, :3])
    assert (turned.inv() * Rotation.from_quat(tum[:, 4:8])).magnitude().max() < 1e-8
    # straight ahead at the tour's speed
    np.testing.assert_allclose(np.hypot(truth[:, 8], truth[:, 9]), sequence.study.tour.speed_mps, rtol=1e-9)
    assert (truth[:, 10:] == 0).all()


def test_evo_reads_one_trajectory_from_both_layouts(root, sequence):
    """The robot's ground truth in EuRoC, times the camera's place on it, is TUM's: in evo's own numbers."""
    mav0 = _folder(root, "euroc") / "mav0"
    T_BS = np.reshape(yaml.safe_load((mav0 / "cam0/sensor.yaml").read_text())["T_BS"]["data"], (4, 4))
    camera_track = file_interface.read_tum_trajectory_file(_folder(root, "tum") / "groundtruth.txt")
    body_track = file_interface.read_euroc_csv_trajectory(mav0 / "state_groundtruth_estimate0/data.csv")
    for track in (camera_track, body_track):
        valid, details = track.check()
        assert valid, details
    body_track, camera_track = sync.associate_trajectories(body_track, camera_track, max_diff=1e-6)
    assert body_track.num_poses == FRAMES
    np.testing.assert_allclose(
        body_track.positions_xyz[:, :2], sequence.scene.tour.poses[:FRAMES, :2], atol=1e-8
    )
    yaw = body_track.get_orientations_euler("sxyz")[:, 2]
    np.testing.assert_allclose(
        np.exp(1j * yaw), np.exp(1j * sequence.scene.tour.poses[:FRAMES, 2]), atol=1e-8
    )
    body_track.transform(T_BS, right_mul=True)
    apart = metrics.APE(metrics.PoseRelation.full_transformation)
    apart.process_data((camera_track, body_track))
    assert apart.get_statistic(metrics.StatisticsType.max) < 1e-7


def test_euroc_odometry_adds_up_to_the_way_driven(root, sequence):
    steps = pd.read_csv(_folder(root, "euroc") / "mav0/odom0/data.csv").to_numpy(dtype=float)
    driven = 0.93 * 0.5  # m a frame, straight
    assert (steps[0, 1:] == 0).all()
    sigma = np.sqrt(steps[1:, 4:])
    assert (np.abs(steps[1:, 1:4] - [driven, 0, 0]) < 4 * sigma).all()
    np.testing.assert_allclose(sigma[:, 0], sequence.study.odometry.sigma_forward_m_per_m * driven, rtol=1e-6)


@pytest.mark.parametrize(("layout", "kind", "epsilon"), [("exr", "f2", 2**-11), ("exr-float", "f4", 2**-24)])
def test_exr_layers_hold_the_light(root, taken, layout, kind, epsilon):
    import OpenEXR

    for frame, (basis, _, diffuse, specular) in enumerate(taken):
        with OpenEXR.File(str(_folder(root, layout) / f"{frame:06d}.exr"), separate_channels=True) as file:
            pixels = {name: channel.pixels for name, channel in file.channels().items()}
            white = file.header()["whiteLuminance"]
        colours = {f"{part}.{c}" for part in ("diffuse", "specular") for c in "RGB"}
        assert set(pixels) == {*"RGB", *colours, "depth.Z"}
        np.testing.assert_array_equal(pixels["depth.Z"], basis.depth)
        for name, light in (("diffuse", diffuse), ("specular", specular)):
            stored = np.stack([pixels[f"{name}.{c}"] for c in "RGB"], axis=-1)
            assert stored.dtype == kind
            # half of the last place, and of the smallest number there is
            least = white * np.finfo(stored.dtype).smallest_subnormal
            assert (np.abs(white * stored.astype(float) - light) <= epsilon * light + least / 2).all()


@pytest.mark.parametrize(("layout", "epsilon"), [("exr", 2**-11), ("exr-float", 2**-24)])
def test_exr_parts_add_up_for_another_reader(root, layout, epsilon):
    """Mitsuba's reader; the manifest's largest error is the one found here, and three roundings bound it."""
    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    largest = 0.0
    for frame in range(FRAMES):
        parts = dict(mitsuba.Bitmap(str(_folder(root, layout) / f"{frame:06d}.exr")).split())
        full, diffuse, specular = (
            np.array(parts[name].convert(component_format=mitsuba.Struct.Type.Float64))
            for name in ("<root>", "diffuse", "specular")
        )
        normal = np.finfo("f2" if layout == "exr" else "f4").smallest_normal
        error = np.abs(full - diffuse - specular) / np.maximum(full, normal)
        largest = max(largest, float(error.max()))
    stated = json.loads((root / "dataset.json").read_text())["layouts"][layout]
    assert stated["largest_error_of_full_minus_diffuse_plus_specular"]["value"] == pytest.approx(largest)
    assert 0 < largest <= 2.01 * epsilon  # of the sum itself, and of both parts together


def test_the_manifest_states_the_largest_error_of_tum(root, taken, sequence):
    sensor, largest = sequence.sensor, 0.0
    for frame, (_, recording, diffuse, specular) in enumerate(taken):
        gain = sensor.electrons_per_luminance * recording.exposure.seconds / sensor.full_well_e
        full = (diffuse.astype(float) + specular) * gain
        parts = [_read(_folder(root, "tum") / f"{p}/{frame:06d}.png") for p in ("diffuse", "specular")]
        error = np.abs(full - sum(part.astype(float) / 65535 for part in parts))
        largest = max(largest, float(error[full < 1].max()))
    stated = json.loads((root / "dataset.json").read_text())["layouts"]["tum"]
    value = stated["largest_error_of_full_minus_diffuse_plus_specular"]["value"]
    assert value == pytest.approx(largest, rel=1e-2)  # float32 luminance against float64
    assert value < 1.01 / 65535  # half a step for each part


def test_coco_masks_decode_to_the_true_masks(root, taken, capsys):
    from pycocotools.coco import COCO

    folder = _folder(root, "coco")
    data = COCO(str(folder / "annotations.json"))
    assert [c["name"] for c in data.loadCats(data.getCatIds())] == ["highlight", "saturated"]
    for frame, (_, recording, *_) in enumerate(taken):
        (image,) = data.loadImgs([frame])
        np.testing.assert_array_equal(_read(folder / image["file_name"]), recording.image)
        assert (image["height"], image["width"]) == recording.highlight.shape
        for category, mask in ((1, recording.highlight), (2, recording.saturated)):
            (mark,) = data.loadAnns(data.getAnnIds(imgIds=[frame], catIds=[category]))
            np.testing.assert_array_equal(data.annToMask(mark) > 0, mask)
            assert mark["area"] == mask.sum() and mark["iscrowd"] == 1


def test_raw_numbers_are_the_sensor_s(root, taken, sequence):
    folder = _folder(root, "raw")
    sheet = json.loads((folder / "sensor.json").read_text())
    assert sheet["largest_dn"] == 2 ** sheet["bit_depth"] - 1
    for frame, (_, recording, diffuse, specular) in enumerate(taken):
        stored = _read(folder / f"raw/{frame:06d}.png")
        assert stored.dtype == np.uint16
        np.testing.assert_array_equal(stored, recording.raw)
        electrons = (stored.astype(float) - sheet["black_level_dn"]) / sheet["gain_dn_per_e"]
        expected = (diffuse + specular) * sequence.sensor.electrons_per_luminance * sheet["exposure"]
        dim = expected < 0.9 * sheet["full_well_e"]
        assert electrons[dim].mean() == pytest.approx(expected[dim].mean(), rel=0.01)


def test_a_mosaic_on_disk_develops_to_the_picture(short_study, tmp_path):
    """By OpenCV and what stands beside it: black, white balance, demosaicing, colour matrix, sRGB."""
    sensor = {"preset": "machine-vision", "sensitivities": "nikon-5100", "exposure": 0.002, "gain_db": 6}
    study = RenderedStudy.model_validate(short_study.model_dump(mode="json") | {"sensor": sensor})
    out = tmp_path / "set"
    generate(study, GenerateOptions(out, (NAME,), 1, ("tum", "raw")), Silent())
    raw = _read(_folder(out, "raw") / "raw/000000.png")
    assert raw.dtype == np.uint16 and raw.shape == (240, 320)
    sheet = json.loads((_folder(out, "raw") / "sensor.json").read_text())
    row = pd.read_csv(out / "frames.csv").iloc[0]
    assert row["gain_db"] == 6 and sheet["colour_filter_array"] == "RGGB"
    planes = cv2.demosaicing(raw, cv2.COLOR_BayerBG2RGB)  # OpenCV's name for RGGB
    black = sheet["black_level_dn"]
    linear = (planes.astype(float) - black) / (sheet["largest_dn"] - black)
    gains = row[["white_r", "white_g", "white_b"]].to_numpy(dtype=float)
    light = np.clip(np.clip(linear * gains, 0, 1) @ np.transpose(sheet["colour_matrix"]), 0, 1)
    encoded = 255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    difference = encoded - _read(_folder(out, "tum") / "rgb/000000.png")
    assert np.median(np.abs(difference)) < 4  # bilinear there, Malvar here
    assert np.abs(np.median(difference, axis=(0, 1))).max() < 1


def test_the_table_agrees_with_the_pictures(root, taken, sequence):
    table = pd.read_csv(root / "frames.csv")
    assert table["frame"].tolist() == [0, 1, 2] and set(table["split"]) == {"all"}
    np.testing.assert_allclose(table[["x_m", "y_m", "heading_rad"]], sequence.scene.tour.poses[:FRAMES])
    assert table["exposure_s"].tolist() == [0.002] * FRAMES
    assert table["highlight_share"].tolist() == pytest.approx([t[1].highlight.mean() for t in taken])
    assert table["saturated_share"].tolist() == pytest.approx([t[1].saturated.mean() for t in taken])
    for layout in LAYOUTS:
        assert all((root / path).is_file() for path in table[layout])


def test_croissant_is_valid_and_gives_the_records_of_the_table(root, caplog):
    import mlcroissant

    data = mlcroissant.Dataset(str(root / "croissant.json"))
    assert not data.metadata.ctx.issues.errors
    records = list(data.records("pictures"))
    table = pd.read_csv(root / "frames.csv")
    assert [r["pictures/tum"].decode() for r in records] == table["tum"].tolist()
    assert [r["pictures/stamp_s"] for r in records] == table["stamp_s"].tolist()
    globs = {
        d.id: list(root.glob(d.includes[0]))
        for d in data.metadata.distribution
        if hasattr(d, "includes") and d.includes
    }
    assert set(globs) == {f"{layout}-pictures" for layout in LAYOUTS}
    assert len(globs["exr-pictures"]) == len(globs["raw-pictures"]) == FRAMES


def test_pairs_are_what_the_study_of_pairs_reads(root: Path, taken: list) -> None:
    found = pairs.find(_folder(root, "pairs"))
    assert [files.name for files in found] == [f"{k:06d}" for k in range(FRAMES)]
    for files, (_, recording, _, _) in zip(found, taken, strict=True):
        pair = pairs.load(files)
        np.testing.assert_array_equal(pair.picture, recording.image)
        np.testing.assert_array_equal(np.rint(255 * pair.diffuse), recording.diffuse)
        np.testing.assert_array_equal(pair.mask, recording.highlight)
