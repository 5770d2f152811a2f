"""Training samples: the pictures mirrored, smaller or larger, grey, off in white balance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from tools.guarded.pictures import Pictures
from vslam.filters.stages.light_network import MULTIPLE

Sample = tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.uint8], NDArray[np.bool_]]


@dataclass(frozen=True)
class Variation:
    """How much samples differ from the pictures.

    Attributes
    ----------
    scales : (float, float)
        Smallest and largest size.
    scaled : float
        Share of the samples that are scaled at all.
    matt : float
        Share that is shown without its specular light, with its own noise.
    permuted : float
        Share whose channels change places: other paints, the same neutral light.
    """

    scales: tuple[float, float] = (0.75, 1.35)
    scaled: float = 0.5
    matt: float = 0.0
    permuted: float = 0.0


def samples(pictures: list[Pictures], rng: np.random.Generator, variation: Variation) -> Iterator[Sample]:
    """Each picture once, in random order: image, full, diffuse, disc."""
    places = [(k, j) for k, scene in enumerate(pictures) for j in range(len(scene.image))]
    for at in rng.permutation(len(places)):
        yield _varied(*plain(pictures[places[at][0]], places[at][1]), rng, variation)


def plain(scene: Pictures, j: int) -> Sample:
    """A picture as it is, continued by its last row and column as the filter does."""
    parts = (scene.image[j], scene.full[j], scene.diffuse[j], scene.disc[j])
    return _framed(parts, 0, 0, _multiples(scene.disc.shape[1:]))


def _multiples(shape: tuple[int, ...]) -> tuple[int, int]:
    rows, columns = (side + -side % MULTIPLE for side in shape)
    return rows, columns


def _varied(
    image: NDArray[np.uint8],
    full: NDArray[np.uint8],
    diffuse: NDArray[np.uint8],
    disc: NDArray[np.bool_],
    rng: np.random.Generator,
    variation: Variation,
) -> Sample:
    shape = (disc.shape[0], disc.shape[1])
    if variation.matt and rng.random() < variation.matt:
        image, full = matt(image, full, diffuse), diffuse
    colours, mark = [image, full, diffuse], disc.view(np.uint8)
    if variation.permuted and rng.random() < variation.permuted:
        order = rng.permutation(3)
        colours = [np.ascontiguousarray(picture[..., order]) for picture in colours]
    if rng.random() < 0.15:
        colours = [_grey(picture) for picture in colours]
    elif rng.random() < 0.3:
        table = _balance(rng.uniform(0.93, 1.0, 3))
        colours = [cv2.LUT(picture, table) for picture in colours]
    if rng.random() < variation.scaled:
        scale = float(rng.uniform(*variation.scales))
        size = (round(shape[1] * scale), round(shape[0] * scale))
        colours = [cv2.resize(picture, size, interpolation=cv2.INTER_LINEAR) for picture in colours]
        mark = cv2.resize(mark, size, interpolation=cv2.INTER_NEAREST)
    if rng.random() < 0.5:
        colours, mark = [picture[:, ::-1] for picture in colours], mark[:, ::-1]
    spare = (max(has - wanted, 0) for has, wanted in zip(mark.shape, shape, strict=True))
    row, column = (int(rng.integers(s + 1)) for s in spare)
    return _framed((colours[0], colours[1], colours[2], mark > 0), row, column, shape)


def _framed(sample: Sample, row: int, column: int, shape: tuple[int, int]) -> Sample:
    """Cut out of what is larger, continue what is smaller."""
    framed = []
    for part in sample:
        cut = part[row : row + shape[0], column : column + shape[1]]
        rest = ((0, shape[0] - cut.shape[0]), (0, shape[1] - cut.shape[1]), (0, 0))
        framed.append(np.ascontiguousarray(np.pad(cut, rest[: cut.ndim], mode="edge")))
    image, full, diffuse, disc = framed
    return image, full, diffuse, disc


def matt(image: NDArray[np.uint8], full: NDArray[np.uint8], diffuse: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The picture without specular light, with the noise of the one with it."""
    return np.clip(image.astype(np.int16) - full + diffuse, 0, 255).astype(np.uint8)


def _grey(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return cv2.cvtColor(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), cv2.COLOR_GRAY2RGB)


def _balance(gains: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Look-up table (1, 256, 3) that scales each channel's codes."""
    return np.rint(np.arange(256)[None, :, None] * gains).astype(np.uint8)
