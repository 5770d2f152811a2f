"""Blocks of pixels that share a shadow ray: the same shadows, far fewer rays, and what is missed."""

from __future__ import annotations

import numpy as np

from renderers.shadows import _sparsely


def asked(mask: np.ndarray, facing: np.ndarray) -> tuple[np.ndarray, int]:
    """What is found, as a picture, and how many rays it took."""
    rays = 0

    def free_at(which: np.ndarray) -> np.ndarray:
        nonlocal rays
        rays += len(which)
        return np.float32(~mask.reshape(-1)[which])

    found = np.zeros(mask.size, dtype=bool)
    found[facing] = _sparsely(facing, mask.shape, free_at) == 0
    return found.reshape(mask.shape), rays


def test_large_shadows_are_the_same_to_the_pixel() -> None:
    rows, cols = np.mgrid[:97, :130]  # no multiple of a block
    mask = (np.hypot(rows - 50, cols - 60) < 30) | (3 * rows + cols > 340)  # no corner where they meet
    found, rays = asked(mask, np.arange(mask.size))
    np.testing.assert_array_equal(found, mask)
    assert rays < mask.size / 3


def test_pixels_that_face_away_are_never_asked() -> None:
    mask = np.zeros((40, 40), dtype=bool)
    mask[:, 20:] = True
    facing = np.flatnonzero(np.arange(1600) % 7 < 3)
    found, _ = asked(mask, facing)
    np.testing.assert_array_equal(found.reshape(-1)[facing], mask.reshape(-1)[facing])


def test_a_gap_between_the_rays_is_missed_and_that_is_the_price() -> None:
    mask = np.zeros((40, 40), dtype=bool)
    mask[18, 18] = True  # no first pixel of a block
    found, rays = asked(mask, np.arange(1600))
    assert not found.any() and rays == 100
