"""All textures of a scene in one array, each as a pyramid, and the look-up in it.

A pixel's footprint on the texture is taken as a row of round ones along its longer axis, each read from the
pyramid's level of its size (Williams 1983, Pyramidal parametrics; McCormack et al. 1999, Feline).
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenes.model import Surface
from scenes.textures import WRAPS, Texture

NO_TEXTURE = -1
MOST_TAPS = 8
"""Along a footprint's longer axis; a flatter view than this is blurred across too."""

F32 = NDArray[np.float32]
I32 = NDArray[np.int32]
U16 = NDArray[np.uint16]


@dataclass(frozen=True, eq=False)
class TextureStore:
    """Pyramids of linear values, one after the other.

    Attributes
    ----------
    texels : (n, 3) uint16
        0…65535 for 0…1; normals are unit vectors, from −1…1.
    levels : (t, l, 3) int64
        First texel, width and height of each level of each texture; width 0 beyond the last.
    wrap : (t, 2) int32
        Index into `scenes.textures.WRAPS` along u and v.
    base_color, metallic_roughness, normal : (surfaces,) int32
        Texture of each surface, `NO_TEXTURE` for none.
    normal_scale : (surfaces,) float32
    """

    texels: U16
    levels: NDArray[np.int64]
    wrap: I32
    base_color: I32
    metallic_roughness: I32
    normal: I32
    normal_scale: F32

    @property
    def empty(self) -> bool:
        """Whether no surface has a texture."""
        return len(self.wrap) == 0

    @property
    def textured(self) -> NDArray[np.bool_]:
        """(surfaces,) whether each has a texture of any kind."""
        return np.stack([self.base_color, self.metallic_roughness, self.normal]).max(axis=0) != NO_TEXTURE

    @staticmethod
    def of(surfaces: Sequence[Surface], more: int) -> TextureStore:
        """Build the pyramids of all surfaces' textures, each picture once.

        Parameters
        ----------
        more : int
            Surfaces without textures that follow.
        """
        pyramids: list[list[F32]] = []
        wraps: list[tuple[int, int]] = []
        known: dict[tuple[int, str, bool], int] = {}
        columns = np.full((3, len(surfaces) + more), NO_TEXTURE, dtype=np.int32)
        scale = np.ones(len(surfaces) + more, dtype=np.float32)
        for s, surface in enumerate(surfaces):
            look = surface.textures
            if look is None:
                continue
            scale[s] = look.normal_scale
            for row, texture in enumerate((look.base_color, look.metallic_roughness, look.normal)):
                if texture is None:
                    continue
                key = (id(texture.texels), "".join(texture.wrap), row == 2)
                if key not in known:
                    known[key] = len(pyramids)
                    pyramids.append(_pyramid(_normals(texture) if row == 2 else _linear(texture)))
                    wraps.append((WRAPS.index(texture.wrap[0]), WRAPS.index(texture.wrap[1])))
                columns[row, s] = known[key]
        texels, levels = _packed(pyramids)
        wrap = np.array(wraps, dtype=np.int32).reshape(-1, 2)
        return TextureStore(texels, levels, wrap, columns[0], columns[1], columns[2], scale)

    def digest(self) -> bytes:
        """Of the content: caches tell scenes apart by it."""
        digest = hashlib.blake2b(digest_size=16)
        for array in vars(self).values():
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.digest()

    def sample(self, which: I32, uv: F32, row_step: F32, column_step: F32) -> F32:
        """Mean of textures over pixels' footprints.

        Parameters
        ----------
        which : (n,) int32
            Texture of each pixel.
        uv, row_step, column_step : (n, 2) float32
            Texture coordinates at the pixel's centre, and how they change to the next row and column.

        Returns
        -------
        (n, 3) float32, 0…1
        """
        return _sample(self.texels, self.levels, self.wrap, which, uv, row_step, column_step)


def _linear(texture: Texture) -> F32:
    """(h, w, 3) float32 linear values of 0…1; sRGB decoded (IEC 61966-2-1)."""
    value = np.arange(256) / 255
    if texture.srgb:
        value = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    return value.astype(np.float32)[texture.texels]


def _normals(texture: Texture) -> F32:
    """(h, w, 3) float32 unit vectors, from −1…1 to 0…1."""
    vector = (np.arange(256) * 2 / 255 - 1).astype(np.float32)[texture.texels]
    vector /= np.maximum(np.linalg.norm(vector, axis=2, keepdims=True), 1e-6)
    return 0.5 * vector + np.float32(0.5)


def _pyramid(base: F32) -> list[F32]:
    """The picture and its halves down to one texel."""
    import cv2

    levels = [base]
    while max(levels[-1].shape[:2]) > 1:
        height, width = levels[-1].shape[:2]
        half = (max(1, width // 2), max(1, height // 2))
        levels.append(np.asarray(cv2.resize(levels[-1], half, interpolation=cv2.INTER_AREA)))
    return levels


def _packed(pyramids: list[list[F32]]) -> tuple[U16, NDArray[np.int64]]:
    deepest = max((len(p) for p in pyramids), default=0)
    levels, at = np.zeros((len(pyramids), deepest, 3), dtype=np.int64), 0
    parts = [np.zeros((0, 3), dtype=np.uint16)]
    for t, pyramid in enumerate(pyramids):
        for k, picture in enumerate(pyramid):
            levels[t, k] = at, picture.shape[1], picture.shape[0]
            at += picture.shape[0] * picture.shape[1]
            parts.append(np.round(picture.reshape(-1, 3) * 65535).astype(np.uint16))
    return np.concatenate(parts), levels


@njit(cache=True)
def _sample(
    texels: U16, levels: NDArray[np.int64], wrap: I32, which: I32, uv: F32, row_step: F32, column_step: F32
) -> F32:
    values = np.zeros((len(which), 3), dtype=np.float32)
    for i in range(len(which)):
        k = which[i]
        width, height = levels[k, 0, 1], levels[k, 0, 2]
        du, dv = row_step[i, 0], row_step[i, 1]
        eu, ev = column_step[i, 0], column_step[i, 1]
        longer = np.hypot(du * width, dv * height)
        shorter = np.hypot(eu * width, ev * height)
        if shorter > longer:
            longer, shorter, du, dv = shorter, longer, eu, ev
        taps = min(max(int(np.ceil(longer / max(shorter, 1.0))), 1), MOST_TAPS)
        lod = np.log2(max(longer / taps, 1.0))
        for tap in range(taps):
            along = (tap + 0.5) / taps - 0.5
            r, g, b = _trilinear(
                texels, levels[k], wrap[k], uv[i, 0] + along * du, uv[i, 1] + along * dv, lod
            )
            values[i, 0] += r
            values[i, 1] += g
            values[i, 2] += b
        for c in range(3):
            values[i, c] /= taps * 65535
    return values


@njit(cache=True)
def _trilinear(
    texels: U16, levels: NDArray[np.int64], wrap: I32, u: float, v: float, lod: float
) -> tuple[float, float, float]:
    last = len(levels) - 1
    while last > 0 and levels[last, 1] == 0:
        last -= 1
    below = min(int(lod), last)
    r, g, b = _bilinear(texels, levels[below], wrap, u, v)
    share = lod - below
    if below < last and share > 0.0:
        r2, g2, b2 = _bilinear(texels, levels[below + 1], wrap, u, v)
        r, g, b = r + share * (r2 - r), g + share * (g2 - g), b + share * (b2 - b)
    return r, g, b


@njit(cache=True)
def _bilinear(
    texels: U16, level: NDArray[np.int64], wrap: I32, u: float, v: float
) -> tuple[float, float, float]:
    first, width, height = level
    x, y = u * width - 0.5, v * height - 0.5
    column, row = int(np.floor(x)), int(np.floor(y))
    s, t = x - column, y - row
    r = g = b = 0.0
    for j in range(2):
        at_row = first + width * _wrapped(row + j, height, wrap[1])
        for i in range(2):
            at = at_row + _wrapped(column + i, width, wrap[0])
            share = (s if i else 1.0 - s) * (t if j else 1.0 - t)
            r += share * texels[at, 0]
            g += share * texels[at, 1]
            b += share * texels[at, 2]
    return r, g, b


@njit(cache=True)
def _wrapped(i: int, n: int, mode: int) -> int:
    """Repeat, clamp, mirror: the order of `scenes.textures.WRAPS`."""
    if mode == 1:
        return min(max(i, 0), n - 1)
    if mode == 2:
        k = i % (2 * n)
        return k if k < n else 2 * n - 1 - k
    return i % n
