"""The scene as one triangle mesh with material tables, and the ray caster over it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from renderers.texture_store import TextureStore
from scenes.model import Bulb, Material, Scene

NOTHING = -1
"""Triangle, surface or landmark index of a pixel that shows the sky, or no landmark."""

OPAL = Material((0.75, 0.75, 0.75), roughness=1.0, specular=0.0)
"""A lamp's globe of opal glass by other light: a wall that reflects ρ = 0.5 and lets τ = 0.4 through (typical
values, not measured) gives back ρ + τ² / (1 − ρ) = 0.8, less what the lamp inside takes."""


@dataclass(frozen=True, eq=False)
class MaterialTable:
    """Materials by surface index, float32: base_color (n, 3), roughness, metallic, specular (n,)."""

    base_color: NDArray[np.float32]
    roughness: NDArray[np.float32]
    metallic: NDArray[np.float32]
    specular: NDArray[np.float32]

    @staticmethod
    def of(materials: list[Material]) -> MaterialTable:
        """Stack materials into columns."""
        columns = [(*m.base_color, m.roughness, m.metallic, m.specular) for m in materials]
        table = np.array(columns, dtype=np.float32)
        return MaterialTable(
            np.ascontiguousarray(table[:, :3]),
            table[:, 3].copy(),
            table[:, 4].copy(),
            table[:, 5].copy(),
        )


@dataclass(frozen=True, eq=False)
class SceneMesh:
    """All surfaces of a scene merged, the bulbs' luminous spheres after them.

    Attributes
    ----------
    vertices : (n, 3) float32, metres
    triangles : (m, 3) int32
    normals : (m, 3) float32
        Unit geometric normal of each triangle.
    vertex_normals : (n, 3) float32
        Unit normals at the vertices of curved surfaces, zero elsewhere.
    curved : (m,) bool
        Triangles that are shaded with the normal between their vertices'.
    uv : (n, 2) float32
        Texture coordinates, zero where there are none.
    surface : (m,) int32
        Index into ``surface_names`` and ``materials``.
    bulb : (m,) int32
        Index of the bulb whose sphere the triangle belongs to, −1 elsewhere.
    """

    vertices: NDArray[np.float32]
    triangles: NDArray[np.int32]
    normals: NDArray[np.float32]
    vertex_normals: NDArray[np.float32]
    curved: NDArray[np.bool_]
    uv: NDArray[np.float32]
    surface: NDArray[np.int32]
    bulb: NDArray[np.int32]
    surface_names: tuple[str, ...]
    materials: MaterialTable
    textures: TextureStore


class RayCaster:
    """Open3D's Embree scene: any rays in, nearest hits or occlusion out. ``threads`` 0 means all cores."""

    def __init__(self, vertices: NDArray[np.float32], triangles: NDArray[np.int32], threads: int = 0) -> None:
        import open3d as o3d

        self._tensor, self._threads = o3d.core.Tensor.from_numpy, threads
        self._scene = o3d.t.geometry.RaycastingScene(nthreads=threads)
        self._scene.add_triangles(
            self._tensor(np.ascontiguousarray(vertices, dtype=np.float32)),
            self._tensor(np.ascontiguousarray(triangles, dtype=np.uint32)),
        )

    def nearest(
        self, origins: NDArray[np.float32], directions: NDArray[np.float32]
    ) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.float32]]:
        """First hit of each ray.

        Parameters
        ----------
        origins, directions : (..., 3) float32
            Directions of unit length.

        Returns
        -------
        triangle : (...) int32, `NOTHING` for a miss
        distance : (...) float32, metres, inf for a miss
        barycentric : (..., 2) float32, weights of the triangle's second and third vertex
        """
        return self.first_hit(_rays(origins, directions))

    def first_hit(
        self, rays: NDArray[np.float32]
    ) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.float32]]:
        """`nearest` for rays given as (..., 6) float32: origin, direction."""
        hit = self._scene.cast_rays(self._tensor(rays), nthreads=self._threads)
        triangle = hit["primitive_ids"].numpy().view(np.int32)  # Embree's invalid id has all bits: `NOTHING`
        return triangle, hit["t_hit"].numpy(), hit["primitive_uvs"].numpy()

    def occluded(
        self,
        origins: NDArray[np.float32],
        directions: NDArray[np.float32],
        far: float = np.inf,
    ) -> NDArray[np.bool_]:
        """Whether anything stands on each ray before ``far`` (in units of the direction's length)."""
        return self.any_hit(_rays(origins, directions), far)

    def any_hit(self, rays: NDArray[np.float32], far: float = np.inf) -> NDArray[np.bool_]:
        """`occluded` for rays given as (..., 6) float32: origin, direction."""
        tensor = self._tensor(rays)
        hit = self._scene.test_occlusions(tensor, tnear=0.0, tfar=float(far), nthreads=self._threads)
        return np.asarray(hit.numpy())


def _rays(origins: NDArray[np.float32], directions: NDArray[np.float32]) -> NDArray[np.float32]:
    rays = np.empty((*directions.shape[:-1], 6), dtype=np.float32)
    rays[..., :3], rays[..., 3:] = origins, directions
    return rays


def build_mesh(scene: Scene) -> SceneMesh:
    """Merge a scene's surfaces and bulbs into one mesh."""
    spheres = [_sphere(bulb) for bulb in scene.bulbs]
    parts = [(s.vertices, s.triangles, i, NOTHING) for i, s in enumerate(scene.surfaces)]
    lamp = len(scene.surfaces)
    parts += [(v, t, lamp, k) for k, (v, t) in enumerate(spheres)]
    offsets = np.cumsum([0] + [len(v) for v, *_ in parts[:-1]])
    vertices = np.concatenate([v for v, *_ in parts]).astype(np.float32)
    triangles = np.concatenate([t + o for (_, t, *_), o in zip(parts, offsets, strict=True)]).astype(np.int32)
    at_vertices = np.zeros_like(vertices)
    uv = np.zeros((len(vertices), 2), dtype=np.float32)
    curved = np.zeros(len(triangles), dtype=bool)
    first = np.cumsum([0] + [len(t) for _, t, *_ in parts])
    for s, at, start, stop in zip(scene.surfaces, offsets, first, first[1:], strict=False):
        if s.normals is not None:
            at_vertices[at : at + len(s.vertices)] = s.normals
            curved[start:stop] = True
        if s.uv is not None:
            uv[at : at + len(s.vertices)] = s.uv
    return SceneMesh(
        vertices=vertices,
        triangles=triangles,
        normals=_normals(vertices, triangles),
        vertex_normals=at_vertices,
        curved=curved,
        uv=uv,
        surface=np.concatenate([np.full(len(t), s, dtype=np.int32) for _, t, s, _ in parts]),
        bulb=np.concatenate([np.full(len(t), b, dtype=np.int32) for _, t, _, b in parts]),
        surface_names=(*(s.name for s in scene.surfaces), "bulb"),
        materials=MaterialTable.of([*(s.material for s in scene.surfaces), OPAL]),
        textures=TextureStore.of(scene.surfaces, more=1),
    )


def _normals(vertices: NDArray[np.float32], triangles: NDArray[np.int32]) -> NDArray[np.float32]:
    a, b, c = (vertices[triangles[:, k]].astype(np.float64) for k in range(3))
    normal = np.cross(b - a, c - a)
    return (normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)).astype(np.float32)


def _sphere(bulb: Bulb, rings: int = 8, sectors: int = 16) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A closed latitude–longitude sphere, faces outwards."""
    theta = np.linspace(0, np.pi, rings + 1)[1:-1]
    phi = np.arange(sectors) * 2 * np.pi / sectors
    body = np.stack(
        [
            np.outer(np.sin(theta), np.cos(phi)),
            np.outer(np.sin(theta), np.sin(phi)),
            np.repeat(np.cos(theta)[:, None], sectors, axis=1),
        ],
        axis=-1,
    ).reshape(-1, 3)
    vertices = np.vstack([[0, 0, 1.0], body, [0, 0, -1.0]]) * bulb.radius + np.asarray(bulb.position)
    index = 1 + np.arange((rings - 1) * sectors).reshape(rings - 1, sectors)
    right, last = np.roll(index, -1, axis=1), len(vertices) - 1
    faces = [np.stack([np.zeros(sectors, dtype=int), index[0], right[0]], axis=1)]
    faces.append(np.stack([index[:-1], index[1:], right[1:]], axis=-1).reshape(-1, 3))
    faces.append(np.stack([index[:-1], right[1:], right[:-1]], axis=-1).reshape(-1, 3))
    faces.append(np.stack([index[-1], np.full(sectors, last), right[-1]], axis=1))
    return vertices, np.concatenate(faces).astype(np.int64)
