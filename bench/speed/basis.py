"""``basis``: one pose under eight lights with shadows, against the same rays in Embree and nothing else.

Ours: `SceneRenderer.render` with the raycast engine for the sun and seven bulbs, a layer each, and the sky
as a ninth: G-buffer, shading, baked light, mirror rays, discs. Baseline: Open3D's Embree casts the picture's
primary rays and the shadow rays that the eight lights ask for, made beforehand; it neither makes rays nor
shades. Mirror rays are left out of it, though ours casts them too. Both use all cores.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bench.speed import stage
from bench.speed.model import Benchmark, Configuration, Sides
from renderers.camera import T_world_robot
from renderers.gbuffer import View, fill
from renderers.lights import DirectLight, unit_lights
from renderers.mesh import RayCaster, SceneMesh, build_mesh
from renderers.raycast import RaycastEngine
from renderers.shadows import visible_shares
from scenes.model import Scene

BULBS = 7
Rays = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class RayList:
    """Rays of one view, float32, origin and direction last.

    Attributes
    ----------
    primary : (n, 6)
    shadow : list of ((m, k, 6), far)
        One entry per light and call: k rays from each of m points, penumbra rays included.
    """

    primary: Rays
    shadow: list[tuple[Rays, float]] = field(default_factory=list)

    @property
    def count(self) -> int:
        """How many rays there are in all."""
        return self.primary.size // 6 + sum(rays.size // 6 for rays, _ in self.shadow)


class _NotingCaster(RayCaster):
    """Notes the shadow rays that lights ask for."""

    def __init__(self, mesh: SceneMesh, noted: list[tuple[Rays, float]]) -> None:
        super().__init__(mesh.vertices, mesh.triangles)
        self._noted = noted

    def any_hit(self, rays: NDArray[np.float32], far: float = np.inf) -> NDArray[np.bool_]:
        """See `RayCaster.any_hit`."""
        self._noted.append((rays.copy(), far))
        return super().any_hit(rays, far)


def rays_of(place: Scene, configuration: Configuration, pose: NDArray[np.float64]) -> RayList:
    """The primary and shadow rays that a pose needs."""
    mesh = build_mesh(place)
    view = View(stage.camera(configuration), T_world_robot(pose) @ stage.MOUNT.T_robot_camera)
    directions = view.directions.reshape(-1, 3)
    rays = RayList(np.hstack([np.broadcast_to(view.origin, directions.shape), directions]))
    caster = _NotingCaster(mesh, rays.shadow)
    gbuffer = fill(mesh, view, RaycastEngine(caster))
    points, normals = gbuffer.position.reshape(-1, 3), gbuffer.normal.reshape(-1, 3)
    for layer in unit_lights(place).values():
        direct = [light for light in layer if isinstance(light, DirectLight)]
        lux = [light.arriving(points, normals)[1] for light in direct]
        visible_shares(direct, lux, points, normals, caster, gbuffer.surface.shape)
    return rays


@contextmanager
def prepare(configuration: Configuration) -> Iterator[Sides]:
    """Bake the light and make the rays."""
    import open3d as o3d

    place = stage.scene(BULBS, configuration.laps)
    pose = stage.poses(place, 2)[1]
    renderer = stage.renderer(place, configuration, "raycast", threads=0)
    rays = rays_of(place, configuration, pose)
    mesh = build_mesh(place)
    embree = o3d.t.geometry.RaycastingScene()
    embree.add_triangles(
        o3d.core.Tensor.from_numpy(mesh.vertices),
        o3d.core.Tensor.from_numpy(mesh.triangles.astype(np.uint32)),
    )
    primary = o3d.core.Tensor.from_numpy(rays.primary)
    shadow = [(o3d.core.Tensor.from_numpy(r), far) for r, far in rays.shadow]

    def ours() -> int:
        renderer.render(pose)
        return 1

    def embree_alone() -> int:
        embree.cast_rays(primary)
        for tensor, far in shadow:
            embree.test_occlusions(tensor, tnear=0.0, tfar=float(far))
        return 1

    def note(_: float, alone: float) -> str:
        return (
            f"{len(rays.primary):,} primary and {rays.count - len(rays.primary):,} shadow rays; "
            f"Embree casts {rays.count / alone / 1e3:.1f} million a second"
        )

    yield Sides(ours, embree_alone, note)
    renderer.close()


BENCHMARK = Benchmark(
    "basis",
    "one pose under 8 lights with shadows, against Embree's rays alone",
    "ms",
    False,
    "ratio ≤ 3",
    prepare,
)
