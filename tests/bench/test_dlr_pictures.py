"""The study of real pictures: matching, calibration and thinning by hand; a short run on the user's data."""

from __future__ import annotations

import numpy as np
import pytest

from bench.camera_choice import CameraChoice, IntrinsicsChoice, calibration
from bench.dlr_detection import score
from bench.errors import BenchError
from bench.kinds.dlr_pictures import DlrPicturesStudy
from bench.options import RunOptions
from bench.perception import detector_settings
from bench.progress import Silent
from bench.robot_choice import SlamChoice
from bench.runner import run
from bench.sequences import dlr
from bench.sequences.dlr_mount import PARAMETERS, calibrated
from bench.sequences.dlr_pictures import mapped_discs, on_picture, read_picture, thinned
from bench.study import load, parse
from reports import dlr_pictures, html
from reports.run import load as load_run
from vslam.detect import DiscDetector
from vslam.frame import Observations, Odometry
from vslam.motion import move

CAMERA = CameraChoice(
    model="pinhole",
    width=768,
    height=288,
    fov_deg=None,
    intrinsics=IntrinsicsChoice(fx=470.0, fy=257.0, cx=383.0, cy=144.0),
    distortion=(-0.25, 0.11, 0.0, 0.0),
    height_m=1.35,
    forward_m=-0.13,
    left_m=0.03,
    pitch_deg=24.0,
    roll_deg=0.4,
    yaw_deg=0.3,
)
"""About the robot's own: one PAL field, a wide lens, looking down."""
BIASED = CAMERA.model_copy(update={"height_m": 1.42, "forward_m": -0.08, "pitch_deg": 25.7, "yaw_deg": 0.6})


def seen(points, ids=None):
    points = np.array(points, dtype=float).reshape(-1, 2)
    covariances = np.tile(0.02**2 * np.eye(2), (len(points), 1, 1))
    return Observations(points, covariances, np.array(ids if ids is not None else [-1] * len(points)))


def test_recall_asks_for_rows_and_precision_for_the_map():
    view = calibration(CAMERA)
    mapped = np.array([[2.0, 0.0], [3.0, 1.0], [4.0, -1.0]])
    # on disc 0; on disc 1, which no row has; a second one on disc 0; on nothing, but at a row
    found = seen([[2.02, 0.0], [3.0, 1.1], [2.1, 0.0], [1.5, -1.0]])
    rows = seen([[2.0, 0.05], [1.5, -1.1], [4.0, -1.0], [2.5, 2.0]], ids=[7, 8, 9, -1])
    scores = score(found, rows, mapped, view, view)
    assert (scores.annotated, scores.found, scores.found_by_pixel) == (3, 2, 2)  # the row of id −1 is no disc
    assert (scores.detected, scores.true) == (4, 2)  # a disc has one detection
    np.testing.assert_array_equal(scores.disc, [0, 1, -1, -1])
    distance, bearing, range_error, bearing_error, squared = scores.errors[0]
    assert (distance, bearing, range_error, bearing_error) == pytest.approx((2.0, 0.0, 0.02, 0.0))
    assert squared == pytest.approx(1.0)  # 2 cm at σ = 2 cm
    assert scores.errors[1, 4] == pytest.approx(25.0)


@pytest.mark.parametrize("count", [0, 1])
def test_nothing_seen_and_nothing_annotated(count):
    view = calibration(CAMERA)
    scores = score(seen([[2.0, 0.0]] * count), seen([]), np.array([[9.0, 9.0]]), view, view)
    assert (scores.annotated, scores.found, scores.detected, scores.true) == (0, 0, count, 0)
    assert scores.errors.shape == (0, 5)


def test_a_row_of_another_calibration_is_found_by_its_pixel_alone():
    disc = np.array([[4.3, 0.4]])
    pixel = on_picture(calibration(CAMERA), disc)
    row = calibration(BIASED).floor_points(pixel)[0]
    assert np.hypot(*(row - disc)[0]) > 0.15
    scores = score(seen(disc), seen(row, ids=[3]), disc, calibration(CAMERA), calibration(BIASED))
    assert (scores.found, scores.found_by_pixel, scores.true) == (0, 1, 1)


def sightings(rng, pictures, outliers):
    """Pixels of discs through the true camera, with half a pixel of noise, and the discs."""
    view, made = calibration(CAMERA), []
    for _ in range(pictures):
        discs = np.column_stack([rng.uniform(1.0, 4.5, 6), rng.uniform(-1.5, 1.5, 6)])
        pixels = on_picture(view, discs) + rng.normal(0.0, 0.5, (6, 2))
        made.append((np.vstack([pixels, rng.uniform((50, 120), (700, 280), (outliers, 2))]), discs))
    return made


@pytest.mark.parametrize("outliers", [0, 1])
def test_the_mount_is_recovered_from_discs(outliers):
    found = calibrated(BIASED, sightings(np.random.default_rng(3), 40, outliers))
    errors = {name: getattr(found, name) - getattr(CAMERA, name) for name in PARAMETERS}
    assert max(abs(errors[n]) for n in ("height_m", "forward_m", "left_m")) < 0.01, errors
    assert max(abs(errors[n]) for n in ("pitch_deg", "roll_deg", "yaw_deg")) < 0.2, errors
    assert found.intrinsics == CAMERA.intrinsics and found.distortion == CAMERA.distortion


def test_too_few_discs_calibrate_nothing():
    with pytest.raises(BenchError, match="calibrate_every"):
        calibrated(BIASED, sightings(np.random.default_rng(3), 4, 0))


def test_discs_seen_through_this_camera_are_found_where_they_are():
    """Half-dense rows, distortion: an analytic floor, 3 × 5 samples per pixel around each disc."""
    view = calibration(CAMERA)
    discs = np.array([[1.3, 0.3], [1.8, -0.7], [2.6, 0.8], [3.4, -0.5], [4.2, 0.2]])
    white = np.array([True, False, True, True, False])
    linear = np.full((288, 768), 0.15)
    for disc, is_white in zip(discs, white, strict=True):
        u, v = on_picture(view, disc[None])[0].round().astype(int)
        rows, columns = slice(v - 25, min(v + 26, 288)), slice(u - 50, u + 51)
        y, x = np.mgrid[rows.start * 5 : rows.stop * 5, columns.start * 3 : columns.stop * 3]
        samples = np.stack([(x.ravel() + 0.5) / 3 - 0.5, (y.ravel() + 0.5) / 5 - 0.5], axis=1)
        floor = view.floor_points(samples)[0]
        covered = (np.hypot(*(floor - disc).T) <= 0.0945).reshape(rows.stop - rows.start, 5, 101, 3)
        linear[rows, columns] += covered.mean(axis=(1, 3)) * ((0.7 if is_white else 0.02) - 0.15)
    grey = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    noise = np.random.default_rng(0).normal(0.0, 1.5, grey.shape)
    picture = np.repeat(np.clip(255 * grey + noise, 0, 255).round().astype(np.uint8)[..., None], 3, axis=2)
    found = DiscDetector(view, detector_settings(load("dlr_pictures").discs)).discs(picture)
    np.testing.assert_allclose(found.points, discs, atol=0.01)
    np.testing.assert_allclose(found.radii, 0.0945, atol=0.004)
    np.testing.assert_array_equal(found.contrasts > 0, white)


def made_up_log(count):
    rng = np.random.default_rng(5)
    steps, poses = [], [np.zeros(3)]
    for _ in range(count):
        A = rng.normal(0.0, 0.02, (3, 3))
        steps.append((Odometry(rng.normal((0.2, 0.0, 0.1), 0.05), A @ A.T), seen([])))
        poses.append(move(poses[-1], steps[-1][0].delta))
    return dlr.DlrLog(
        tuple(steps),
        np.array(poses),
        None,
        np.array([4]),
        np.array([[3.0, 1.0]]),
        tuple(f"{k}.jpg" for k in range(count)),
    )


def test_thinned_steps_end_where_the_whole_ones_do():
    log = made_up_log(11)
    thin = thinned(log, 4)
    assert thin.image_names == ("0.jpg", "4.jpg", "8.jpg")
    pose = np.zeros(3)
    for k, (odometry, _) in enumerate(thin.steps):
        pose = move(pose, odometry.delta)
        np.testing.assert_allclose(pose, thin.truth[k + 1], atol=1e-12)
        np.testing.assert_allclose(mapped_discs(thin, k), mapped_discs(log, 4 * k))


def test_chained_covariance_is_that_of_many_drawn_drives():
    log = made_up_log(5)
    rng = np.random.default_rng(6)
    draws = []
    for _ in range(3000):
        pose = np.zeros(3)
        for odometry, _ in log.steps[1:]:
            pose = move(pose, odometry.delta + rng.multivariate_normal(np.zeros(3), odometry.covariance))
        draws.append(pose)
    chained = thinned(log, 4).steps[1][0]
    expected = np.cov(np.array(draws).T)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    np.testing.assert_allclose(chained.covariance / scale, expected / scale, atol=0.08)


def test_a_stride_that_leaves_nothing_to_score_is_refused():
    with pytest.raises(BenchError, match="stride 40 takes only pictures that calibrate_every 20"):
        parse("{sequence: dlr_pictures, name: mine, stride: 40}", "mine.yaml")
    assert isinstance(load("dlr_pictures"), DlrPicturesStudy)


def test_a_missing_or_damaged_picture_is_one_line(tmp_path):
    with pytest.raises(BenchError, match="no such picture; get them with"):
        read_picture(tmp_path, "a.jpg")
    (tmp_path / "images").mkdir()
    (tmp_path / "images" / "a.jpg").write_bytes(b"no picture")
    with pytest.raises(BenchError, match="not a whole picture of 768 × 288"):
        read_picture(tmp_path, "a.jpg")


def test_real_pictures_reach_recall_and_precision(dlr_folder, tmp_path):
    """Every 67th picture scored, every 60th calibrates: the whole chain from pictures to page."""
    if not ((dlr_folder / "images").is_dir() and (dlr_folder / "camera.json").is_file()):
        pytest.skip("the log's folder has no pictures or no camera.json")
    study = load("dlr_pictures").model_copy(
        update={"stride": 67, "calibrate_every": 60, "slam": (SlamChoice(association="annotated"),)}
    )
    folder = run(study, RunOptions(out=tmp_path, data=dlr_folder), Silent(), report=html.build)
    stored = load_run(folder)
    raw = dlr_pictures.of_filter(stored, "none")
    assert set(stored.frames["frame"] % 60) - {0} and not (stored.frames["frame"] % 60 == 0).any()
    assert raw.recall.value >= 0.85 and raw.recall_by_pixel.value >= 0.9 and raw.precision.value >= 0.9
    assert abs(raw.range_bias_m) < 0.015 and 0.5 < raw.nees < 3.0
    assert "real" in (folder / "report.html").read_text(encoding="utf-8")
