"""The disc detector on pictures of an analytic floor: supersampled, shaded, noisy, 8-bit sRGB."""

from collections.abc import Callable

import cv2
import numpy as np
import pytest

from vslam.camera import mounted
from vslam.detect import DiscDetector, encoded_noise, linear_luminance
from vslam.errors import VslamError

CAMERA = mounted()
FACTOR = 5  # samples along each side of a pixel; odd, so that one lies at its centre
WHITE, BLACK, FLOOR = 0.80, 0.05, np.array([0.30, 0.27, 0.24])
Light = Callable[[np.ndarray, np.ndarray], np.ndarray]


def _floor_samples() -> np.ndarray:
    v, u = np.mgrid[0 : 240 * FACTOR, 0 : 320 * FACTOR]
    pixels = np.stack([u.ravel(), v.ravel()], axis=1) / FACTOR + (0.5 / FACTOR - 0.5)
    return CAMERA.floor_points(pixels)[0].reshape(240 * FACTOR, 320 * FACTOR, 2)


SAMPLES = _floor_samples()


def picture(
    discs: np.ndarray,
    rng: np.random.Generator,
    light: Light | None = None,
    specular: Light | None = None,
    gain: float = 1.0,
    staircase: bool = False,
    floor: np.ndarray = FLOOR,
) -> np.ndarray:
    """Photons of a floor with discs (x, y, radius, is white) as a camera of 8000 electrons records them."""
    x, y = SAMPLES[..., 0], SAMPLES[..., 1]
    reflectance = np.where(np.isnan(x)[..., None], 0.45, floor)
    for cx, cy, radius, white in discs:
        reflectance[np.hypot(x - cx, y - cy) <= radius] = WHITE if white else BLACK
    luminance = gain * reflectance
    if light is not None:
        luminance = luminance * np.nan_to_num(light(x, y), nan=1.0)[..., None]
    if specular is not None:
        luminance = luminance + np.nan_to_num(specular(x, y))[..., None]
    blocks = luminance.reshape(240, FACTOR, 320, FACTOR, 3)
    mean = (
        blocks[:, FACTOR // 2, :, FACTOR // 2]
        if staircase
        else cv2.GaussianBlur(blocks.mean((1, 3)), (0, 0), 0.35)
    )
    electrons = rng.poisson(8000.0 * mean) + rng.normal(0.0, 15.0, mean.shape)
    linear = np.clip(electrons / 8000.0, 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.round(255.0 * encoded).astype(np.uint8)


def layout(rng: np.random.Generator, count: int = 12, reach: float = 3.5) -> np.ndarray:
    """Discs apart from each other, whole in the picture, (count, 4)."""
    discs: list[tuple[float, float, float, bool]] = []
    while len(discs) < count:
        x, y, radius = rng.uniform(0.7, reach), rng.uniform(-2.5, 2.5), rng.uniform(0.10, 0.20)
        if np.hypot(x, y) > reach or abs(np.arctan2(y, x)) > np.radians(65.0):
            continue
        if all(np.hypot(x - a, y - b) > 0.7 for a, b, _, _ in discs):
            discs.append((x, y, radius, bool(rng.random() < 0.5)))
    return np.array(discs)


def lamp_pool(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return 0.2 + np.exp(-((x - 2.0) ** 2 + y**2) / 1.2)


@pytest.fixture(scope="module")
def detector() -> DiscDetector:
    return DiscDetector(CAMERA)


def score(
    detector: DiscDetector, pictures: int, seed: int, **how: object
) -> tuple[int, int, np.ndarray, np.ndarray]:
    """Missed and false discs, and error (m) and NEES of the found ones."""
    rng = np.random.default_rng(seed)
    missed = false = 0
    errors, nees = [], []
    for _ in range(pictures):
        discs = layout(rng)
        found = detector(picture(discs, rng, **how))
        distance = np.linalg.norm(found.points[:, None] - discs[None, :, :2], axis=2)
        false += int((distance.min(axis=1) > 0.1).sum())
        for k in range(len(discs)):
            near = np.flatnonzero(distance[:, k] <= 0.1)
            missed += len(near) == 0
            if len(near):
                e = found.points[near[0]] - discs[k, :2]
                errors.append(np.linalg.norm(e))
                nees.append(e @ np.linalg.solve(found.covariances[near[0]], e))
    return missed, false, np.array(errors), np.array(nees)


@pytest.mark.parametrize(
    ("how", "mean_error"),
    [
        ({}, 0.001),
        ({"floor": np.array([0.20, 0.25, 0.40])}, 0.001),
        ({"light": lamp_pool}, 0.002),
        ({"gain": 0.1}, 0.003),
        ({"staircase": True}, 0.008),
    ],
    ids=["even light", "blue floor", "lamp pool", "dark", "one sample per pixel"],
)
def test_all_discs_within_three_and_a_half_metres_and_no_others(detector, how, mean_error):
    missed, false, errors, nees = score(detector, 6, seed=1, **how)
    assert false == 0
    assert missed <= (0.04 * (missed + len(errors)) if "staircase" in how else 0)
    assert errors.mean() < mean_error
    # χ²₂ has mean 2; its covariance may be cautious by two (a staircase looks like noise), never bold.
    assert 0.4 < nees.mean() < 2.6


def test_radius_and_paint_are_recovered(detector):
    rng = np.random.default_rng(4)
    discs = np.array([[1.0, 0.3, 0.10, 1], [1.4, -0.6, 0.20, 0], [2.5, 0.8, 0.15, 1], [3.0, -0.9, 0.12, 0]])
    found = detector.discs(picture(discs, rng))
    assert len(found.points) == 4
    assert (np.diff(np.hypot(*found.points.T)) > 0).all(), "nearest first"
    np.testing.assert_allclose(found.radii, discs[:, 2], atol=0.005)
    np.testing.assert_array_equal(found.contrasts > 0, discs[:, 3] == 1)
    np.testing.assert_allclose(found.contrasts[0], WHITE - FLOOR @ [0.2126, 0.7152, 0.0722], atol=0.02)


@pytest.mark.parametrize("gain", [1.0, 0.1, 0.02])
def test_an_empty_floor_gives_none(detector, gain):
    rng = np.random.default_rng(5)
    assert sum(len(detector(picture(np.zeros((0, 4)), rng, gain=gain))) for _ in range(4)) == 0


def test_edges_of_sun_patches_are_no_discs(detector):
    rng = np.random.default_rng(6)

    def windows(x, y):
        return np.where((np.abs(y) < 1.2) & ((x + 0.4 * y) % 1.1 < 0.6), 1.0, 0.2)

    assert len(detector(picture(np.zeros((0, 4)), rng, light=windows))) == 0


def test_a_mirrored_lamp_is_no_disc(detector):
    """The image of a round lamp is round in the picture, so on the floor it is drawn out along the view."""
    rng = np.random.default_rng(7)

    def lamp(x, y):
        distance = np.hypot(x, y)
        stretch = 1.2 / np.hypot(distance, 1.2)  # sine of the angle at which the floor is seen
        return 2.0 * (np.hypot((x - 2.5) * stretch, y) < 0.12)

    assert len(detector(picture(np.zeros((0, 4)), rng, specular=lamp))) == 0


def test_squares_and_stripes_are_no_discs(detector):
    rng = np.random.default_rng(8)

    def tiles(x, y):
        square = (np.abs(x - 1.2) < 0.15) & (np.abs(y - 0.4) < 0.15)
        stripe = (np.abs(x - 1.5) < 0.06) & (np.abs(y + 0.5) < 0.4)
        return np.where(square | stripe, 2.5, 1.0)

    found = detector.discs(picture(np.zeros((0, 4)), rng, light=tiles))
    assert len(found.points) == 0


def test_a_disc_in_a_clipped_highlight_is_lost_and_the_others_stay(detector):
    rng = np.random.default_rng(9)
    discs = np.array([[1.5, 0.0, 0.15, 1], [1.5, 1.2, 0.15, 1]])

    def glare(x, y):
        return 1.5 * (np.hypot(x - 1.5, y) < 0.5)

    found = detector(picture(discs, rng, specular=glare))
    assert len(found) == 1
    np.testing.assert_allclose(found.points[0], discs[1, :2], atol=0.003)


def test_deterministic_and_input_unchanged(detector):
    image = picture(layout(np.random.default_rng(3)), np.random.default_rng(3))
    before = image.copy()
    first, second = detector(image), DiscDetector(CAMERA)(image)
    np.testing.assert_array_equal(image, before)
    np.testing.assert_array_equal(first.points, second.points)
    np.testing.assert_array_equal(first.covariances, second.covariances)
    assert (first.ids == -1).all() and first.ids.dtype == np.int64


def test_wrong_pictures_are_refused(detector):
    with pytest.raises(VslamError, match="detector: needs"):
        detector(np.zeros((240, 320), np.uint8))
    with pytest.raises(VslamError, match="detector: needs"):
        detector(np.zeros((240, 320, 3), np.float32))


def test_a_uniform_picture_gives_none(detector):
    for level in (0, 128, 255):
        assert len(detector(np.full((240, 320, 3), level, np.uint8))) == 0


@pytest.mark.parametrize("sigma", [0.5, 1.0, 4.0])
def test_noise_estimate(sigma):
    rng = np.random.default_rng(0)
    grey = np.round(120.0 + 40.0 * (np.arange(320) > 150) + rng.normal(0.0, sigma, (240, 320)))
    assert encoded_noise(grey.astype(np.uint8)) == pytest.approx(np.hypot(sigma, 12**-0.5), rel=0.05)


def test_luminance_is_linear():
    image = np.zeros((1, 3, 3), np.uint8)
    image[0, 0], image[0, 1] = 255, 188
    np.testing.assert_allclose(linear_luminance(image), [[1.0, 0.503, 0.0]], atol=0.001)
