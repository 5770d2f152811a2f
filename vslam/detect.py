"""Landmark detection: painted discs on the floor, found in one picture and located on the floor plane."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from vslam.camera import Calibration
from vslam.detect_fit import fit_disc, spread_samples
from vslam.detect_seeds import Seed, find_seeds, ring_tables
from vslam.errors import VslamError
from vslam.frame import Observations
from vslam.mount_noise import mount_covariances

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class DetectorSettings:
    """What a landmark looks like and when a fit is believed.

    Attributes
    ----------
    min_radius_m, max_radius_m : float
        Of the painted discs.
    max_range_m, half_angle_deg : float
        Table 4-1's sensor: 12 m, ±75°. The resolution ends earlier, where a disc is thinner than a pixel.
    min_contrast : float
        Paint and floor differ by at least this share of the brighter of the two, in linear light: what an eye
        takes for a patch of paint and not for the floor's own unevenness.
    blur_px : float
        Standard deviation of the lens's point spread, pixels; 0.35 is a lens matched to its pixels.
    max_misfit : float
        Root mean square residual beyond noise over the contrast. The edge of a disc sampled once per pixel is
        off by ±½ evenly (0.29) in the fifth of the window's pixels that it crosses: 0.29 · √0.2 = 0.13.
    min_significance : float
        Contrast over its standard deviation. The search looks at some 10⁶ places, sizes and polarities and
        fits four numbers; noise alone exceeds χ²₄ = 7² there once in a thousand pictures.
    max_sigma_m : float
        A centre less certain than this is no landmark; half the smallest disc.
    tilt_sigma_deg : float
        By how much the camera nods and rolls from picture to picture (standard deviation, degrees).
    position_sigma_m : float
        What else shifts a floor point, whatever its distance: unevenness, a picture late by some ms.
    """

    min_radius_m: float = 0.10
    max_radius_m: float = 0.20
    max_range_m: float = 12.0
    half_angle_deg: float = 75.0
    min_contrast: float = 0.15
    blur_px: float = 0.35
    max_misfit: float = 0.15
    min_significance: float = 7.0
    max_sigma_m: float = 0.05
    tilt_sigma_deg: float = 0.0
    position_sigma_m: float = 0.0


@dataclass(frozen=True, eq=False)
class Discs:
    """All fits that were believed, nearest first.

    Attributes
    ----------
    points : (n, 2) float64
        Centre on the floor in the robot's frame, metres.
    covariances : (n, 2, 2) float64
        Of the centre, m²: the fit's and the mount's.
    radii : (n,) float64
        Metres.
    contrasts : (n,) float64
        Paint minus floor in linear light, full scale 1: positive = white.
    misfits : (n,) float64
        Root mean square residual over contrast.
    """

    points: FloatArray
    covariances: FloatArray
    radii: FloatArray
    contrasts: FloatArray
    misfits: FloatArray


class DiscDetector:
    """White and black discs on a floor, by a ring test and a fit of the disc's image.

    Every pixel asks whether a small ring on the floor around it is brighter (or darker) throughout than a
    larger one (`detect_seeds`). Each answer is refined by fitting the picture that a disc of free centre,
    radius and contrast under evenly sloping light would give, integrated over the pixels (`detect_fit`). So
    near discs of 20 pixels and far ones of 2 × 6 take the same way, and the covariance is the fit's own.

    Parameters
    ----------
    calibration : Calibration
    settings : DetectorSettings, optional
    """

    def __init__(self, calibration: Calibration, settings: DetectorSettings | None = None) -> None:
        self.calibration = calibration
        self.settings = settings or DetectorSettings()
        floor, jacobian = calibration.floor_points(calibration.pixel_grid())
        shape = (calibration.height, calibration.width)
        self._floor = floor.reshape(*shape, 2)
        self._jacobian = jacobian.reshape(*shape, 2, 2)
        # [0]: the full point spread; [1]: where the smallest disc has a radius of 3 pixels or more.
        self._spread = [spread_samples(self.settings.blur_px, resolved) for resolved in (False, True)]
        metres_per_pixel = np.linalg.norm(self._jacobian, axis=(2, 3))
        self._resolved = np.nan_to_num(metres_per_pixel, nan=np.inf) <= self.settings.min_radius_m / 3.0
        self._tables = ring_tables(
            calibration,
            self.settings.min_radius_m,
            self.settings.max_radius_m,
            self._searched(floor),
        )

    def __call__(self, image: NDArray[np.uint8]) -> Observations:
        """Landmarks of one picture.

        Parameters
        ----------
        image : (H, W, 3) uint8
            sRGB-encoded RGB; not changed.

        Returns
        -------
        Observations
            Robot frame, metres, nearest first; every id is −1.

        Raises
        ------
        VslamError
            When the picture is not uint8 RGB of the calibration's size.
        """
        discs = self.discs(image)
        return Observations(discs.points, discs.covariances, np.full(len(discs.points), -1, dtype=np.int64))

    def discs(self, image: NDArray[np.uint8]) -> Discs:
        """Landmarks with the rest of what the fit says about them; see `__call__`."""
        expected = (self.calibration.height, self.calibration.width, 3)
        if image.shape != expected or image.dtype != np.uint8:
            raise VslamError(
                f"detector: needs a uint8 picture of {expected}, not {image.dtype} {image.shape}"
            )
        encoded = np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), dtype=np.uint8)
        linear = linear_luminance(image)
        seeds = find_seeds(encoded, self._tables, self._floor, 0.5 * self._encoded_contrast)
        found: list[_Fit] = []
        noise = encoded_noise(encoded)
        for seed in seeds:
            if not self._taken(self._place(seed), found):
                fit = self._fit(linear, seed, noise)
                if fit is not None and not self._taken(fit.point, found):
                    found.append(fit)
        return _nearest_first(found)

    def _searched(self, floor: FloatArray) -> NDArray[np.bool_]:
        """Floor points within range and bearing that the mount locates well enough."""
        s = self.settings
        with np.errstate(invalid="ignore"):
            near = np.hypot(*floor.T) <= s.max_range_m
            ahead = np.abs(np.arctan2(floor[:, 1], floor[:, 0])) <= np.radians(s.half_angle_deg)
        searched = near & ahead
        searched[searched] = _sigma(self._mount(floor[searched])) <= s.max_sigma_m
        return searched

    def _mount(self, points: FloatArray) -> FloatArray:
        """(n, 2, 2) float64: the mount's share of the covariance, m²."""
        s = self.settings
        tilt = float(np.radians(s.tilt_sigma_deg))
        return mount_covariances(self.calibration, points, tilt, s.position_sigma_m)

    def _place(self, seed: Seed) -> FloatArray:
        """(2,) float64: a seed's floor point, metres."""
        place: FloatArray = self._floor.reshape(-1, 2)[seed.pixel]
        return place

    def _taken(self, point: FloatArray, found: list[_Fit]) -> bool:
        """Whether a disc around this point would overlap one that is already found."""
        apart = self.settings.min_radius_m
        return any(np.hypot(*(point - fit.point)) < fit.radius + apart for fit in found)

    @cached_property
    def _encoded_contrast(self) -> float:
        """The least contrast as a share of an encoded level (sRGB's exponent is 2.4)."""
        return 1.0 - (1.0 - self.settings.min_contrast) ** (1.0 / 2.4)

    def _fit(self, linear: NDArray[np.float32], seed: Seed, noise: float) -> _Fit | None:
        """The disc at a seed, or None where it is not believed."""
        row, col = divmod(seed.pixel, self.calibration.width)
        try:
            ok, q, cov, misfit = fit_disc(
                linear,
                self._floor,
                self._jacobian,
                row,
                col,
                seed.ring_m,
                *self._spread[int(self._resolved[row, col])],
                noise / 255.0,
                self.settings.max_misfit,
            )
        except np.linalg.LinAlgError:  # the few pixels of a small picture may leave a parameter open
            return None
        if not ok or (q[3] * q[4] > 0.0) != seed.white:
            return None
        moved = np.hypot(*(q[:2] - self._floor[row, col]))
        contrast = q[3] * q[4]
        brighter = max(q[4], q[4] + contrast)
        covariance = cov[:2, :2] + self._mount(q[None, :2])[0]
        s = self.settings
        slack = 0.1 * q[2] + 2.0 * np.sqrt(cov[2, 2])
        believed = (
            moved <= seed.ring_m
            and s.min_radius_m - slack <= q[2] <= s.max_radius_m + slack
            and abs(contrast) >= s.min_contrast * brighter
            and misfit <= s.max_misfit
            and abs(q[3]) >= s.min_significance * np.sqrt(cov[3, 3])
            and _sigma(covariance) <= s.max_sigma_m
            and np.hypot(q[0], q[1]) <= s.max_range_m
        )
        return _Fit(q[:2], covariance, q[2], contrast, misfit) if believed else None


@dataclass(frozen=True, eq=False)
class _Fit:
    point: FloatArray
    covariance: FloatArray
    radius: float
    contrast: float
    misfit: float


def _sigma(covariances: FloatArray) -> FloatArray:
    """Largest standard deviation of (…, 2, 2) covariances in any direction."""
    return np.asarray(np.sqrt(np.linalg.eigvalsh(covariances)[..., 1]))


def _nearest_first(fits: list[_Fit]) -> Discs:
    kept = sorted(fits, key=lambda fit: float(np.hypot(*fit.point)))
    return Discs(
        np.array([f.point for f in kept]).reshape(-1, 2),
        np.array([f.covariance for f in kept]).reshape(-1, 2, 2),
        np.array([f.radius for f in kept]),
        np.array([f.contrast for f in kept]),
        np.array([f.misfit for f in kept]),
    )


def linear_luminance(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Relative luminance (Rec. 709 weights) of an sRGB-encoded picture.

    Parameters
    ----------
    image : (H, W, 3) uint8

    Returns
    -------
    (H, W) float32
        0…1.
    """
    return _weigh(np.ascontiguousarray(image), _RED, _GREEN, _BLUE)


def _decoded() -> FloatArray:
    level = np.arange(256) / 255.0
    return np.where(level <= 0.04045, level / 12.92, ((level + 0.055) / 1.055) ** 2.4)


def encoded_noise(grey: NDArray[np.uint8]) -> float:
    """Noise of a picture, grey levels: Immerkær (1996), with the median for the mean against edges.

    Parameters
    ----------
    grey : (H, W) uint8
    """
    counts = _curvature_counts(grey)
    total = int(counts.sum())
    # The levels are whole numbers: the median is interpolated within its own.
    below = np.concatenate([[0], np.cumsum(counts)])
    level = int(np.searchsorted(below, 0.5 * total, side="right")) - 1
    median = level - 0.5 + (0.5 * total - below[level]) / counts[level]
    return max(float(median), 0.0) / (0.6745 * 6.0)


_RED, _GREEN, _BLUE = ((w * _decoded()).astype(np.float32) for w in (0.2126, 0.7152, 0.0722))


@njit(cache=True)
def _weigh(image, red, green, blue):  # type: ignore[no-untyped-def]
    out = np.empty(image.shape[:2], dtype=np.float32)
    for v in range(image.shape[0]):
        for u in range(image.shape[1]):
            out[v, u] = red[image[v, u, 0]] + green[image[v, u, 1]] + blue[image[v, u, 2]]
    return out


@njit(cache=True)
def _curvature_counts(grey):  # type: ignore[no-untyped-def]
    """How often each absolute value of (1, −2, 1) ⊗ (1, −2, 1) occurs at every second row and column."""
    counts = np.zeros(8 * 255 + 1, dtype=np.int64)
    for v in range(1, grey.shape[0] - 1, 2):
        for u in range(1, grey.shape[1] - 1, 2):
            value = 0
            for k in range(-1, 2):
                row = int(grey[v + k, u - 1]) - 2 * int(grey[v + k, u]) + int(grey[v + k, u + 1])
                value += row if k != 0 else -2 * row
            counts[abs(value)] += 1
    return counts
