"""Stock pyrender on OSMesa, used as its documentation has it, as the baseline of ``sweep``.

What it is given: the scene merged into three primitives with vertex colours (glossy, rough, metal), the
landmark discs as triangles, the sun as a directional light with pyrender's shadow map, the sky as ambient
light, four bulbs as point lights and two as spots of 180° that point down, since stock pyrender drops all but
four lights of a kind. Two passes give the picture with specular light and one without gloss.

What it does less of than ours: 8-bit pictures of gamma 2.2, clamped; no shadows of point lights; no bounced
light, no mirror images; its "diffuse" pass is a material of roughness 1, whose specular lobe is wide and not
gone. The ground outside, which would spoil its shadow map, is left out.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.speed import stage
from bench.speed.model import Configuration
from renderers.camera import T_world_robot
from renderers.osmesa import import_pyrender
from scenes.model import Scene

GAMMA = 2.2
GLOSSY_BELOW = 0.5
POINTS = 4
"""Point lights that stock pyrender can show at once."""

_DISC_SECTORS = 24
_DISC_HEIGHT_M = 2e-3
_OUTSIDE = "ground"

Triangles = tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]


class StockRenderer:
    """A scene in stock pyrender through one camera."""

    def __init__(self, place: Scene, configuration: Configuration) -> None:
        self._pyrender = pyrender = import_pyrender()
        camera = stage.camera(configuration)
        self._glossy, self._dull = self._scene(place, True), self._scene(place, False)
        fov_y = 2 * np.arctan(camera.height / 2 / camera.focal)
        self._eyes = [
            scene.add(pyrender.PerspectiveCamera(yfov=fov_y, znear=0.03, zfar=100.0), pose=np.eye(4))
            for scene, _ in (self._glossy, self._dull)
        ]
        self._renderer = pyrender.OffscreenRenderer(camera.width, camera.height)
        self._flags = pyrender.RenderFlags.SHADOWS_DIRECTIONAL | pyrender.RenderFlags.SKIP_CULL_FACES
        self._sky, self._sun = place.sky.name, place.suns[0].name

    def render(
        self, pose: NDArray[np.float64], intensity: dict[str, float]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """Render both passes.

        Parameters
        ----------
        pose : (3,) float64
        intensity : dict of layer to float
            Lux and lumen.

        Returns
        -------
        full, dull : (H, W, 3) float32
            Luminance with and without gloss, cd/m², as far as 8 bits and the clamp leave it.
        depth : (H, W) float32, metres
        """
        T = T_world_robot(pose) @ stage.MOUNT.T_robot_camera @ np.diag([1.0, -1.0, -1.0, 1.0])
        # 1 is the brightest that its picture holds: as bright as a white wall in the sun or below a bulb
        brightest = max(self._lux(intensity) / np.pi, 1e-6)
        pictures = []
        for (scene, nodes), eye in zip((self._glossy, self._dull), self._eyes, strict=True):
            scene.set_pose(eye, T)
            scene.ambient_light = np.full(3, intensity[self._sky] / np.pi / brightest)
            for name, node in nodes.items():
                scale = 1.0 if name == self._sun else 1 / (4 * np.pi)
                node.light.intensity = intensity[name] * scale / brightest
            pictures.append(self._renderer.render(scene, flags=self._flags))
        full, dull = (brightest * (colour.astype(np.float32) / 255) ** GAMMA for colour, _ in pictures)
        return full.astype(np.float32), dull.astype(np.float32), np.asarray(pictures[0][1])

    def close(self) -> None:
        """Free the OSMesa context."""
        self._renderer.delete()

    def _lux(self, intensity: dict[str, float]) -> float:
        bulbs = max((v for k, v in intensity.items() if k not in (self._sun, self._sky)), default=0.0)
        return intensity[self._sun] + intensity[self._sky] + bulbs / (4 * np.pi)

    def _scene(self, place: Scene, glossy: bool) -> tuple[Any, dict[str, Any]]:
        pyrender = self._pyrender
        scene = pyrender.Scene(bg_color=[0.0, 0.0, 0.0, 0.0])
        scene.add(pyrender.Mesh([self._primitive(part, *kind, glossy) for part, kind in _merged(place)]))
        sun = place.suns[0]
        nodes = {sun.name: scene.add(pyrender.DirectionalLight(), pose=_looking(-sun.direction))}
        for k, bulb in enumerate(place.bulbs):
            pose = _looking(np.array([0.0, 0.0, -1.0]))
            pose[:3, 3] = bulb.position
            half_dome = {"innerConeAngle": np.pi / 2 - 1e-3, "outerConeAngle": np.pi / 2}
            light = pyrender.PointLight() if k < POINTS else pyrender.SpotLight(**half_dome)
            nodes[bulb.group] = scene.add(light, pose=pose)
        return scene, nodes

    def _primitive(self, part: Triangles, roughness: float, metallic: float, glossy: bool) -> Any:
        vertices, triangles, colours = part
        corners = vertices[triangles].reshape(-1, 3)
        edges = vertices[triangles]
        normals = np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        return self._pyrender.Primitive(
            positions=corners.astype(np.float32),
            normals=np.repeat(normals, 3, axis=0).astype(np.float32),
            color_0=np.repeat(colours, 3, axis=0).astype(np.float32),
            material=self._pyrender.MetallicRoughnessMaterial(
                roughnessFactor=roughness if glossy else 1.0, metallicFactor=metallic if glossy else 0.0
            ),
        )


def _merged(place: Scene) -> list[tuple[Triangles, tuple[float, float]]]:
    """The surfaces and discs by kind: triangles with a colour each, and the kind's roughness and metallic."""
    kinds: dict[str, list[tuple[Triangles, float, float]]] = {}
    for surface in place.surfaces:
        if surface.name == _OUTSIDE:
            continue
        material = surface.material
        glossy = "glossy" if material.roughness < GLOSSY_BELOW else "rough"
        kind = "metal" if material.metallic > 0.5 else glossy
        colours = np.tile(material.base_color, (len(surface.triangles), 1))
        part = (surface.vertices, surface.triangles, colours)
        kinds.setdefault(kind, []).append((part, material.roughness, material.metallic))
    floor = next(s.material for s in place.surfaces if s.name == place.floor)
    kinds.setdefault("glossy", []).append((_discs(place), floor.roughness, 0.0))
    return [
        (
            _concatenated([part for part, *_ in parts]),
            (float(np.mean([r for _, r, _ in parts])), float(np.mean([m for *_, m in parts]))),
        )
        for parts in kinds.values()
    ]


def _concatenated(parts: Iterable[Triangles]) -> Triangles:
    vertices, triangles, colours = zip(*parts, strict=True)
    offsets = np.cumsum([0, *(len(v) for v in vertices[:-1])])
    moved = [t + o for t, o in zip(triangles, offsets, strict=True)]
    return np.concatenate(vertices), np.concatenate(moved), np.concatenate(colours)


def _discs(place: Scene) -> Triangles:
    phi = np.arange(_DISC_SECTORS) * 2 * np.pi / _DISC_SECTORS
    rim = np.stack([np.cos(phi), np.sin(phi)], axis=-1)
    fan = np.stack(
        [
            np.zeros(_DISC_SECTORS, dtype=int),
            1 + np.arange(_DISC_SECTORS),
            1 + np.roll(range(_DISC_SECTORS), -1),
        ],
        axis=-1,
    )
    parts = []
    for mark in place.landmarks:
        flat = np.vstack([[0.0, 0.0], mark.radius * rim]) + mark.position
        vertices = np.column_stack([flat, np.full(len(flat), _DISC_HEIGHT_M)])
        paint = place.paint_white if mark.white else place.paint_black
        parts.append((vertices, fan, np.tile(paint, (len(fan), 1))))
    return _concatenated(parts)


def _looking(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """(4, 4) pose of an OpenGL light: it shines along its −z."""
    z = -direction / np.linalg.norm(direction)
    helper = np.array([0.0, 0.0, 1.0]) if abs(z[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    x = np.cross(helper, z)
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    return pose
