"""glTF materials: metallic-roughness with its textures, and what is transparent."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from scenes.gltf.document import Document
from scenes.gltf.images import Images, Picture
from scenes.model import FloatArray, Material
from scenes.textures import Textures

CLEAR = 0.5
"""What lets more light through than it holds back is left out: a ray meets a surface or does not."""


@dataclass(frozen=True, eq=False)
class Cutout:
    """Where a material is opaque: ``factor`` times the picture, at least ``cutoff``; all of 0…1."""

    factor: float
    cutoff: float
    picture: Picture | None


@dataclass(frozen=True, eq=False)
class Look:
    """A glTF material.

    Attributes
    ----------
    cutout : Cutout, optional
        None where the material is opaque all over.
    uv_set : int
        Which TEXCOORD its textures lie on.
    uv_transform : (3, 3) float64
        From TEXCOORD to texture coordinates, homogeneous (KHR_texture_transform).
    """

    name: str
    material: Material
    textures: Textures | None
    double_sided: bool
    cutout: Cutout | None
    uv_set: int
    uv_transform: FloatArray


DEFAULT = {"name": "default"}
"""glTF's material of a primitive that names none: white metal of roughness 1 (3.7.2.1)."""


class Looks:
    """Reads each material once, when a primitive first asks for it."""

    def __init__(self, document: Document, notices: list[str]) -> None:
        self._document, self._notices = document, notices
        self._images = Images(document, notices)
        self._known: dict[int | None, Look] = {}

    def look(self, index: int | None, user: str) -> Look:
        """The material of a primitive.

        Raises
        ------
        SceneError
            If it does not exist, one of its factors is out of range or a texture cannot be read.
        """
        if index not in self._known:
            content = DEFAULT if index is None else self._document.item("materials", index, user)
            self._known[index] = self._read(content, str(content.get("name", f"material {index}")))
        return self._known[index]

    def _read(self, content: dict[str, Any], name: str) -> Look:
        pbr, extensions = content.get("pbrMetallicRoughness", {}), content.get("extensions", {})
        *color, alpha = (float(v) for v in pbr.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0)))
        specular = extensions.get("KHR_materials_specular", {}).get("specularFactor", 1.0)
        material = Material(
            (color[0], color[1], color[2]),
            float(pbr.get("roughnessFactor", 1.0)),
            float(pbr.get("metallicFactor", 1.0)),
            float(specular),
        )
        references = [
            pbr.get("baseColorTexture"),
            pbr.get("metallicRoughnessTexture"),
            content.get("normalTexture"),
        ]
        base, orm, normal = references
        textures = Textures(
            self._images.texture(base, name, srgb=True),
            self._images.texture(orm, name),
            self._images.texture(normal, name),
            float((normal or {}).get("scale", 1.0)),
        )
        uv_set, transform = self._placing([r for r in references if r is not None], name)
        if any(content.get("emissiveFactor", ())):
            self._notices.append(
                f"material {name!r} glows; lamps need {'KHR_lights_punctual'}, so it does not here"
            )
        return Look(
            name,
            material,
            textures if any(r is not None for r in references) else None,
            bool(content.get("doubleSided", False)),
            self._cutout(content, alpha, base, name),
            uv_set,
            transform,
        )

    def _cutout(
        self, content: dict[str, Any], alpha: float, base: dict[str, Any] | None, name: str
    ) -> Cutout | None:
        clear = (
            content.get("extensions", {}).get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0)
        )
        if clear > CLEAR:
            return Cutout(0.0, CLEAR, None)
        mode = content.get("alphaMode", "OPAQUE")
        if mode == "OPAQUE":
            return None
        cutoff = float(content.get("alphaCutoff", 0.5)) if mode == "MASK" else CLEAR
        return Cutout(alpha, cutoff, self._images.alpha(base, name))

    def _placing(self, references: list[dict[str, Any]], name: str) -> tuple[int, FloatArray]:
        """The first texture's TEXCOORD and transform; the others must share them."""
        placings = []
        for reference in references:
            moved = reference.get("extensions", {}).get("KHR_texture_transform", {})
            uv_set = int(moved.get("texCoord", reference.get("texCoord", 0)))
            placings.append((uv_set, _transform(moved)))
        if not placings:
            return 0, np.eye(3)
        first = placings[0]
        if any(s != first[0] or not np.allclose(t, first[1]) for s, t in placings[1:]):
            self._notices.append(
                f"material {name!r}: its textures lie differently; all are laid as its first"
            )
        return first


def _transform(moved: dict[str, Any]) -> FloatArray:
    """Translation · rotation · scale of texture coordinates, as KHR_texture_transform multiplies them."""
    (x, y), (s, t) = moved.get("offset", (0.0, 0.0)), moved.get("scale", (1.0, 1.0))
    c, d = np.cos(moved.get("rotation", 0.0)), np.sin(moved.get("rotation", 0.0))
    return np.array([[1, 0, x], [0, 1, y], [0, 0, 1]]) @ np.array(
        [[c * s, d * t, 0], [-d * s, c * t, 0], [0, 0, 1]]
    )
