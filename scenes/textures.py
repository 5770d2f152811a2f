"""Pictures that vary a surface's material from place to place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError

WRAPS = ("repeat", "clamp", "mirror")


@dataclass(frozen=True, eq=False)
class Texture:
    """A picture over texture coordinates u to the right and v down, whose corners lie at (0, 0) and (1, 1).

    Attributes
    ----------
    texels : (h, w, 3) uint8
    srgb : bool
        Whether the numbers are sRGB-encoded; linear otherwise.
    wrap : (str, str)
        What lies beyond 0…1 along u and along v: "repeat", "clamp" or "mirror".
    """

    texels: NDArray[np.uint8]
    srgb: bool = False
    wrap: tuple[str, str] = ("repeat", "repeat")

    def __post_init__(self) -> None:
        shape = self.texels.shape
        if self.texels.dtype != np.uint8 or len(shape) != 3 or shape[2] != 3 or 0 in shape:
            raise SceneError(f"texture: needs (h, w, 3) uint8, not {shape} {self.texels.dtype}")
        if not set(self.wrap) <= set(WRAPS):
            raise SceneError(f"texture: wrap {self.wrap}; known: {', '.join(WRAPS)}")


@dataclass(frozen=True, eq=False)
class Textures:
    """A material's textures, as glTF 2.0 has them (3.9); each is optional.

    Attributes
    ----------
    base_color : Texture
        Times the material's base colour.
    metallic_roughness : Texture
        Green times the material's roughness, blue times its metallic.
    normal : Texture
        The normal in tangent space, x along u, y against v, z off the surface, each from −1…1 to 0…255.
    normal_scale : float
        Of the normal's x and y.
    """

    base_color: Texture | None = None
    metallic_roughness: Texture | None = None
    normal: Texture | None = None
    normal_scale: float = 1.0
