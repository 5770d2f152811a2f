"""Small scenes and pictures: a floor, a wall, a lamp, and cameras that look straight at them."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import pytest

from renderers.basis import SceneRenderer
from renderers.camera import Mount
from renderers.gbuffer import GBuffer, View, fill
from renderers.mesh import RayCaster, build_mesh
from renderers.raycast import RaycastEngine
from scenes.geometry import rectangle, surface
from scenes.model import Bulb, Landmark, Material, Scene, Sky, Sun, Surface, Tour

MATT = Material((0.6, 0.4, 0.2), roughness=1.0, specular=0.0)


def _floor(half: float = 2.0, material: Material = MATT, cell: float = 1.0) -> Surface:
    """A square floor about the origin, facing up."""
    return surface("floor", material, rectangle((-half, -half, 0), (2 * half, 0, 0), (0, 2 * half, 0), cell))


def _scene(
    *surfaces: Surface,
    bulbs: Iterable[Bulb] = (),
    landmarks: Iterable[Landmark] = (),
    sun: Sun | None = None,
) -> Scene:
    """A scene that stands still; the sun is below the horizon unless given."""
    surfaces = surfaces or (_floor(),)
    return Scene(
        name="test",
        surfaces=surfaces,
        landmarks=tuple(landmarks),
        suns=(sun or Sun(azimuth_deg=180.0, elevation_deg=-30.0, lux=1.0),),
        sky=Sky(lux=1.0),
        bulbs=tuple(bulbs),
        tour=Tour(np.zeros((1, 3)), np.zeros(1)),
        floor=surfaces[0].name,
        paint_white=(1.0, 1.0, 1.0),
        paint_black=(0.0, 0.0, 0.0),
        bounds=(-2.0, -2.0, 2.0, 2.0),
    )


@pytest.fixture(scope="session")
def floor() -> Callable[..., Surface]:
    return _floor


@pytest.fixture(scope="session")
def scene_of() -> Callable[..., Scene]:
    return _scene


@pytest.fixture(scope="session")
def downwards() -> Mount:
    """A camera 3 m above the robot's origin that looks straight down, its right to the robot's right."""
    return Mount(height_m=3.0, pitch_deg=90.0)


@pytest.fixture(scope="session")
def renderer_of() -> Callable[..., SceneRenderer]:
    """Renderers of small scenes: one thread, the ray caster."""

    def make(scene, camera, mount, **options):
        return SceneRenderer(scene, camera, mount, threads=1, **options)

    return make


@pytest.fixture(scope="session")
def gbuffer_of() -> Callable[..., GBuffer]:
    """The G-buffer of a scene seen from a pose, without any light."""

    def make(scene, camera, T_world_camera):
        mesh = build_mesh(scene)
        engine = RaycastEngine(RayCaster(mesh.vertices, mesh.triangles, threads=1))
        return fill(mesh, View(camera, np.asarray(T_world_camera, dtype=np.float64)), engine)

    return make


@pytest.fixture(scope="session")
def on_floor() -> Callable[..., np.ndarray]:
    """Where each pixel's ray meets z = 0, worked out in float64 apart from the renderer: (H, W, 3)."""

    def points(camera, T_world_camera):
        u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
        rays = camera.unproject(np.stack([u, v], axis=-1).astype(float)) @ T_world_camera[:3, :3].T
        eye = T_world_camera[:3, 3]
        return eye + rays * (-eye[2] / rays[..., 2:])

    return points
