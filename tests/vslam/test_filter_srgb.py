"""The transfer function against IEC 61966-2-1 in float64."""

import numpy as np

from vslam.filters.stages.srgb import decode, encode


def encode_in_float64(linear: np.ndarray) -> np.ndarray:
    linear = linear.astype(np.float64)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def test_every_code_survives_the_round_trip() -> None:
    codes = np.arange(256, dtype=np.uint8)
    np.testing.assert_array_equal(encode(decode(codes)), codes)


def test_known_values() -> None:
    # black, white, and code 188 = 0.737 which is nearly half the light
    values = decode(np.array([0, 255, 188], dtype=np.uint8))
    np.testing.assert_allclose(values, [0.0, 1.0, 0.5028864], atol=1e-6)


def test_encoding_rounds_to_the_nearest_code() -> None:
    linear = np.linspace(0, 1, 200_001, dtype=np.float32)
    exact = encode_in_float64(linear) * 255
    # half a code off at most; the standard's own two branches meet only to 1e-4 of a code
    assert np.abs(encode(linear) - exact).max() <= 0.5 + 1e-3


def test_out_of_range_is_clipped() -> None:
    values = np.array([-1.0, -0.0, 1.0, 7.0, np.inf, -np.inf, np.nan], dtype=np.float32)
    np.testing.assert_array_equal(encode(values), [0, 0, 255, 255, 255, 0, 0])


def test_shape_is_kept() -> None:
    picture = np.random.default_rng(0).integers(0, 256, (4, 5, 3), dtype=np.uint8)
    np.testing.assert_array_equal(encode(decode(picture)[:, ::2]), picture[:, ::2])
