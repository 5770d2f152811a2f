"""Pictures made with the dichromatic model (eq. 3-1), whose diffuse part is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Dichromatic:
    """A picture in linear light and its diffuse part, (H, W, 3) float32, 0…1, white light, nothing
    clipped."""

    picture: NDArray[np.float32]
    diffuse: NDArray[np.float32]

    def psnr(self, found: NDArray[np.float32]) -> float:
        """Of an estimate of the diffuse part, dB."""
        return float(-10 * np.log10(np.mean((found.astype(np.float64) - self.diffuse) ** 2)))

    @property
    def doing_nothing(self) -> float:
        """PSNR of the picture itself, dB."""
        return self.psnr(self.picture)


def spheres(
    colours: tuple[tuple[float, float, float], ...], gloss: float = 0.5, exponent: float = 40.0
) -> Dichromatic:
    """Lambert's cosine law under a Phong lobe, one sphere a colour, on black, 120 × 160."""
    height, width = 120, 160
    across = int(np.ceil(np.sqrt(len(colours))))
    down = int(np.ceil(len(colours) / across))
    radius = 0.46 * min(height / down, width / across)
    light = np.array([-0.4, -0.5, 0.77])
    light /= np.linalg.norm(light)
    half = light + np.array([0.0, 0.0, 1.0])
    half /= np.linalg.norm(half)
    rows, columns = np.mgrid[:height, :width]
    diffuse, specular = np.zeros((height, width, 3)), np.zeros((height, width))
    for k, colour in enumerate(colours):
        x = (columns - (k % across + 0.5) * width / across) / radius
        y = (rows - (k // across + 0.5) * height / down) / radius
        on = x**2 + y**2 < 1
        normal = np.stack([x, y, np.sqrt(np.maximum(1 - x**2 - y**2, 0))], axis=-1)
        shade = 0.05 + 0.95 * np.maximum(normal @ light, 0)
        diffuse[on] = (shade[..., None] * colour)[on]
        specular[on] = (gloss * np.maximum(normal @ half, 0) ** exponent * (normal @ light > 0))[on]
    picture = diffuse + specular[..., None]
    scale = max(picture.max(), 1.0)
    return Dichromatic((picture / scale).astype(np.float32), (diffuse / scale).astype(np.float32))


@pytest.fixture(scope="session")
def render_spheres() -> Callable[..., Dichromatic]:
    return spheres
