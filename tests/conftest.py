"""What all tests share: one thread per process for numeric libraries, steady hypothesis, the DLR log."""

from __future__ import annotations

import json
import os
import struct
from pathlib import Path
from typing import Any

# set before NumPy loads: two BLAS threads per test process slow each other down
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import cv2
import hypothesis
import numpy as np
import pytest

# a loaded machine is no failure, and a failure must come again
hypothesis.settings.register_profile("steady", deadline=None, derandomize=True)
hypothesis.settings.load_profile("steady")


@pytest.fixture(scope="session")
def dlr_folder() -> Path:
    """The folder of the real DLR log, or skip."""
    folder = Path(os.environ.get("BENCH_DATA", "")) / "dlr"
    if "BENCH_DATA" not in os.environ or not (folder / "map.circles").is_file():
        pytest.skip("needs the DLR log in $BENCH_DATA/dlr")
    return folder


class GlbWriter:
    """Writes glTF files by hand, apart from the code that reads them."""

    def __init__(self) -> None:
        kinds = ("nodes", "meshes", "accessors", "bufferViews", "materials", "textures", "images", "samplers")
        self.json: dict[str, Any] = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}
        self.json |= {kind: [] for kind in kinds} | {"buffers": [{"byteLength": 0}]}
        self.data = b""

    def _add(self, kind: str, item: dict[str, Any]) -> int:
        self.json[kind].append(item)
        return len(self.json[kind]) - 1

    def view(self, data: bytes) -> int:
        self.data += b"\0" * (-len(self.data) % 4)
        start = len(self.data)
        self.data += data
        return self._add("bufferViews", {"buffer": 0, "byteOffset": start, "byteLength": len(data)})

    def accessor(self, values: object) -> int:
        array = np.asarray(values)
        array = array.astype("<u4" if array.dtype.kind in "iu" else "<f4")
        kind = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[array.shape[1] if array.ndim == 2 else 1]
        number = 5125 if array.dtype.kind == "u" else 5126
        content = {"componentType": number, "count": len(array), "type": kind}
        return self._add("accessors", content | {"bufferView": self.view(array.tobytes())})

    def texture(self, picture: np.ndarray, wrap: int = 10497) -> int:
        """From (h, w, 3 or 4) uint8 RGB."""
        order = [2, 1, 0, 3][: picture.shape[2]]
        _, png = cv2.imencode(".png", np.ascontiguousarray(picture[..., order]))
        image = self._add("images", {"bufferView": self.view(png.tobytes()), "mimeType": "image/png"})
        sampler = self._add("samplers", {"wrapS": wrap, "wrapT": wrap})
        return self._add("textures", {"source": image, "sampler": sampler})

    def material(self, **content: object) -> int:
        return self._add("materials", content)

    def mesh(
        self, points: object, triangles: object, material: int | None = None, **attributes: object
    ) -> int:
        """Points in glTF's axes: x right, y up, z towards the viewer."""
        named = {"POSITION": self.accessor(np.asarray(points, dtype=float))}
        for name, values in attributes.items():
            named[name] = self.accessor(np.asarray(values, dtype=float))
        corners = self.accessor(np.asarray(triangles, dtype=int).reshape(-1))
        primitive: dict[str, Any] = {"attributes": named, "indices": corners}
        if material is not None:
            primitive["material"] = material
        return self._add("meshes", {"primitives": [primitive]})

    def node(self, root: bool = True, **content: object) -> int:
        index = self._add("nodes", content)
        if root:
            self.json["scenes"][0]["nodes"].append(index)
        return index

    def light(self, **content: object) -> dict[str, Any]:
        """The ``extensions`` of the node that carries it."""
        known = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})
        known["lights"].append(content)
        return {"KHR_lights_punctual": {"light": len(known["lights"]) - 1}}

    def quad(
        self, name: str, corner: object, u: object, v: object, material: int | None = None, root: bool = True
    ) -> int:
        """A rectangle in z-up axes that faces u × v; its picture stands upright along v."""
        at, along, up = (np.asarray(value, dtype=float) for value in (corner, u, v))
        points = np.array([at, at + along, at + along + up, at + up])
        turned = np.stack([points[:, 0], points[:, 2], -points[:, 1]], axis=-1)
        uv = [[0, 1], [1, 1], [1, 0], [0, 0]]
        mesh = self.mesh(turned, [[0, 1, 2], [0, 2, 3]], material, TEXCOORD_0=uv)
        return self.node(root, name=name, mesh=mesh)

    def save(self, path: Path) -> Path:
        self.json["buffers"][0]["byteLength"] = len(self.data)
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        data = self.data + b"\0" * (-len(self.data) % 4)
        head = struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(data))
        first, second = (len(text), 0x4E4F534A), (len(data), 0x004E4942)
        path.write_bytes(head + struct.pack("<II", *first) + text + struct.pack("<II", *second) + data)
        return path


@pytest.fixture
def glb() -> GlbWriter:
    """An empty glTF file to write into."""
    return GlbWriter()
