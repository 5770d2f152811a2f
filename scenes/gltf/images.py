"""Pictures of a glTF file, decoded."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError
from scenes.gltf.document import Document
from scenes.textures import Texture

LARGEST = 4096
"""Texels along the longer side; a robot's camera sees no finer ones."""

_WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}  # 5.26
Picture = NDArray[np.uint8]


class Images:
    """Decodes each picture once. ``notices`` gets a line for each that had to be reduced."""

    def __init__(self, document: Document, notices: list[str]) -> None:
        self._document, self._notices = document, notices
        self._decoded: dict[int, Picture] = {}

    def texture(self, reference: dict[str, Any] | None, material: str, srgb: bool = False) -> Texture | None:
        """The texture that a material refers to by ``{"index": …}``, or None without a reference.

        Raises
        ------
        SceneError
            If the picture is missing or cannot be decoded; the line names file and material.
        """
        if reference is None:
            return None
        texture = self._document.item("textures", reference.get("index", -1), f"material {material!r}")
        sampler = {}
        if "sampler" in texture:
            sampler = self._document.item("samplers", texture["sampler"], f"material {material!r}")
        u, v = (_WRAPS.get(sampler.get(key, 10497), "repeat") for key in ("wrapS", "wrapT"))
        return Texture(np.ascontiguousarray(self._picture(texture, material)[..., :3]), srgb, (u, v))

    def alpha(self, reference: dict[str, Any] | None, material: str) -> Picture | None:
        """(h, w) uint8 opacity of a texture, None where it has none."""
        if reference is None:
            return None
        texture = self._document.item("textures", reference.get("index", -1), f"material {material!r}")
        picture = self._picture(texture, material)
        return picture[..., 3] if picture.shape[2] == 4 else None

    def _picture(self, texture: dict[str, Any], material: str) -> Picture:
        source = texture.get(
            "source", texture.get("extensions", {}).get("EXT_texture_webp", {}).get("source")
        )
        if source is None:
            raise self._document.error(f"material {material!r}: a texture has no PNG or JPEG picture")
        if source not in self._decoded:
            image = self._document.item("images", source, f"material {material!r}")
            self._decoded[source] = self._decode(image, str(image.get("uri", f"image {source}")), material)
        return self._decoded[source]

    def _decode(self, image: dict[str, Any], name: str, material: str) -> Picture:
        import cv2

        name = "an embedded image" if name.startswith("data:") else name
        who = f"texture of material {material!r}"
        if "uri" in image:
            data = self._document.resource(image["uri"], who)
        else:
            data = self._document.view(image.get("bufferView", -1), who)
        flags = cv2.IMREAD_UNCHANGED
        try:
            decoded = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), flags) if data else None
        except cv2.error:  # such as one beyond OpenCV's own limit of 2³⁰ pixels
            decoded = None
        if decoded is None:
            raise SceneError(
                f"{self._document.path}: {who}: {name} cannot be decoded; save it as an 8-bit PNG or JPEG"
            )
        picture = _rgb_or_rgba(np.asarray(decoded))
        height, width = picture.shape[:2]
        if max(height, width) > LARGEST:
            shrink = LARGEST / max(height, width)
            size = (max(1, round(width * shrink)), max(1, round(height * shrink)))
            picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
            self._notices.append(f"{who}: {width} × {height} texels, reduced to {size[0]} × {size[1]}")
        return picture


def _rgb_or_rgba(decoded: NDArray[Any]) -> Picture:
    """(h, w, 3 or 4) uint8 RGB from what OpenCV decodes: grey or BGR, 8 or 16 bit."""
    if decoded.dtype == np.uint16:
        decoded = decoded // 257
    decoded = decoded.astype(np.uint8)
    if decoded.ndim == 2:
        decoded = decoded[..., None]
    if decoded.shape[2] <= 2:  # grey, grey with alpha
        return np.concatenate([np.repeat(decoded[..., :1], 3, axis=2), decoded[..., 1:]], axis=2)
    return np.ascontiguousarray(decoded[..., [2, 1, 0, 3][: decoded.shape[2]]])
