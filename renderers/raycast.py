"""The ray-casting engine: Open3D's Embree, one ray per pixel of any camera."""

from __future__ import annotations

from renderers.gbuffer import F32, I32, View
from renderers.mesh import RayCaster


class RaycastEngine:
    """Casts each pixel's own ray, so a fisheye is as exact as a pinhole."""

    name = "raycast"

    def __init__(self, caster: RayCaster) -> None:
        self._caster = caster

    def visible(self, view: View) -> tuple[I32, F32]:
        """See `Engine.visible`."""
        triangle, distance, _ = self._caster.nearest(view.origin, view.directions)
        return triangle, distance

    def close(self) -> None:
        """Nothing to give back."""
