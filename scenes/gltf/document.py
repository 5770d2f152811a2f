"""A glTF 2.0 file as it is stored: its JSON, its buffers, and typed arrays out of them.

Section numbers are those of the glTF 2.0 specification (Khronos, 2021).
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError

SUPPORTED = {
    "KHR_lights_punctual",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
}
"""Extensions that a file may require; those that it merely uses are left out where they are not known."""

_JSON, _BINARY = 0x4E4F534A, 0x004E4942  # types of chunks, 4.4.3
_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}  # 3.6.2.2
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


@dataclass(eq=False)
class Document:
    """A file that was read.

    Attributes
    ----------
    path : Path
    content : dict
        The JSON.
    embedded : bytes
        The GLB's binary chunk; empty in a .gltf.
    """

    path: Path
    content: dict[str, Any]
    embedded: bytes
    _files: dict[str, bytes] = field(default_factory=dict)

    def items(self, kind: str) -> list[dict[str, Any]]:
        """A top-level list such as "nodes", empty where the file has none."""
        return list(self.content.get(kind, []))

    def item(self, kind: str, index: int, user: str) -> dict[str, Any]:
        """One entry of a top-level list.

        Raises
        ------
        SceneError
            If there is no such entry; ``user`` says who refers to it.
        """
        entries = self.content.get(kind, [])
        if not (isinstance(index, int) and 0 <= index < len(entries)):
            raise self.error(f"{user} refers to {kind} {index!r}, of which there are {len(entries)}")
        found: dict[str, Any] = entries[index]
        return found

    def error(self, message: str) -> SceneError:
        """An error about this file."""
        return SceneError(f"{self.path}: {message}; export the file again")

    def accessor(self, index: int, user: str) -> NDArray[Any]:
        """The numbers of an accessor, (count,) or (count, components); normalised integers as −1…1.

        Raises
        ------
        SceneError
            If it, its buffer view or its buffer is missing, or shorter than it says.
        """
        accessor = self.item("accessors", index, user)
        kind, width = accessor.get("componentType"), _COMPONENTS.get(accessor.get("type", ""), 0)
        if kind not in _TYPES or not width:
            raise self.error(f"{user}: accessor {index} has an unknown type")
        dtype, count = np.dtype(_TYPES[kind]), int(accessor.get("count", 0))
        if "bufferView" in accessor:
            data, stride = self._view(accessor["bufferView"], user)
            values = self._strided(data, stride, accessor.get("byteOffset", 0), count, width, dtype, user)
        else:
            values = np.zeros((count, width), dtype)
        if "sparse" in accessor:
            values = self._with_sparse(values, accessor["sparse"], dtype, user)
        if accessor.get("normalized") and dtype.kind != "f":
            values = np.maximum(values / np.iinfo(dtype).max, -1.0)  # 3.6.2.2
        return values[:, 0] if width == 1 else values

    def view(self, index: int, user: str) -> bytes:
        """The bytes of a buffer view."""
        return self._view(index, user)[0]

    def resource(self, uri: str, user: str) -> bytes:
        """The bytes behind a URI: embedded in it, or a file beside this one."""
        if uri.startswith("data:"):
            try:
                return base64.b64decode(uri.partition(",")[2], validate=True)
            except binascii.Error:
                raise self.error(f"{user}: its embedded data is no base64") from None
        if uri not in self._files:
            place = self.path.parent / unquote(uri)
            try:
                self._files[uri] = place.read_bytes()
            except OSError as error:
                reason = "not found" if isinstance(error, FileNotFoundError) else error.strerror
                raise SceneError(f"{self.path}: {user}: {place}: {reason}; put the file there") from None
        return self._files[uri]

    def _view(self, index: int, user: str) -> tuple[bytes, int]:
        view = self.item("bufferViews", index, user)
        buffer = self.item("buffers", view.get("buffer", -1), user)
        who = f"buffer {view['buffer']} (of {user})"
        data = self.resource(buffer["uri"], who) if "uri" in buffer else self.embedded
        start, length = view.get("byteOffset", 0), view.get("byteLength", 0)
        if start + length > len(data):
            raise self.error(f"{who} has {len(data)} bytes, of which {start + length} are asked for")
        return data[start : start + length], view.get("byteStride", 0)

    def _strided(
        self, data: bytes, stride: int, start: int, count: int, width: int, dtype: np.dtype[Any], user: str
    ) -> NDArray[Any]:
        stride = stride or width * dtype.itemsize
        if count and start + (count - 1) * stride + width * dtype.itemsize > len(data):
            raise self.error(f"{user}: its buffer view is too short for {count} values")
        values = np.ndarray((count, width), dtype, data, start, (stride, dtype.itemsize))
        return np.ascontiguousarray(values)

    def _with_sparse(
        self, values: NDArray[Any], sparse: dict[str, Any], dtype: np.dtype[Any], user: str
    ) -> NDArray[Any]:
        """3.6.2.3: other values at some places."""
        count, where, what = sparse["count"], sparse["indices"], sparse["values"]
        data, _ = self._view(where["bufferView"], user)
        offset, index_type = where.get("byteOffset", 0), np.dtype(_TYPES[where["componentType"]])
        at = self._strided(data, 0, offset, count, 1, index_type, user)[:, 0]
        data, _ = self._view(what["bufferView"], user)
        changed = values.copy()
        changed[at] = self._strided(data, 0, what.get("byteOffset", 0), count, values.shape[1], dtype, user)
        return changed

    def files(self) -> tuple[str, ...]:
        """The files that its buffers and images refer to, relative to its folder, sorted."""
        uris = {
            str(item["uri"]) for kind in ("buffers", "images") for item in self.items(kind) if "uri" in item
        }
        return tuple(sorted(unquote(uri) for uri in uris if not uri.startswith("data:")))


def read(path: Path) -> Document:
    """Read a .glb or .gltf file.

    Raises
    ------
    SceneError
        If it cannot be read, is no glTF 2, or needs an extension that is not supported.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        reason = "not found" if isinstance(error, FileNotFoundError) else f"cannot be read ({error.strerror})"
        raise SceneError(f"scene file {path}: {reason}; give the path of a .glb or .gltf file") from None
    text, embedded = _unpack(data, path) if data[:4] == b"glTF" else (data, b"")
    try:
        content = json.loads(text)
        version = str(content["asset"]["version"])
    except (ValueError, KeyError, TypeError, RecursionError):
        raise SceneError(f"{path}: no glTF file; export the scene as glTF 2.0 (.glb)") from None
    if not version.startswith("2."):
        raise SceneError(f"{path}: glTF version {version}; export the scene as glTF 2.0")
    unknown = sorted(set(content.get("extensionsRequired", [])) - SUPPORTED)
    if unknown:
        raise SceneError(
            f"{path}: requires the extension {unknown[0]}; export without compression and extras"
        )
    return Document(path, content, embedded)


def _unpack(data: bytes, path: Path) -> tuple[bytes, bytes]:
    """The JSON and the binary chunk of a GLB (4.4)."""
    chunks, at = {_JSON: b"", _BINARY: b""}, 12
    if len(data) < 12 or struct.unpack_from("<I", data, 8)[0] > len(data):
        raise SceneError(f"{path}: is cut short at {len(data)} bytes; copy or export it again")
    while at + 8 <= len(data):
        length, kind = struct.unpack_from("<II", data, at)
        if kind in chunks and not chunks[kind]:
            chunks[kind] = data[at + 8 : at + 8 + length]
        at += 8 + length
    return chunks[_JSON], chunks[_BINARY]
