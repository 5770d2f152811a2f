"""Which engine finds the visible surfaces, and the fallback where OSMesa is missing."""

from __future__ import annotations

from dataclasses import dataclass

from renderers.camera import Camera
from renderers.errors import RendererError
from renderers.gbuffer import Engine
from renderers.mesh import RayCaster, SceneMesh

NAMES = ("rasterise", "raycast")


@dataclass(frozen=True)
class EngineChoice:
    """The engine to use; ``notice`` is one line to show if it is not the one preferred."""

    name: str
    notice: str = ""


def choose_engine(wanted: str) -> EngineChoice:
    """Resolve "auto": rasterise where OSMesa gives a context, raycast with a notice otherwise.

    Raises
    ------
    RendererError
        If "rasterise" is asked for by name and OSMesa is missing, or the name is unknown.
    """
    if wanted not in ("auto", *NAMES):
        raise RendererError(f"unknown engine {wanted!r}; choose auto, rasterise or raycast")
    if wanted == "raycast":
        return EngineChoice("raycast")
    try:
        probe_osmesa()
    except RendererError as error:
        if wanted == "rasterise":
            raise
        return EngineChoice("raycast", f"using the raycast engine: {error}")
    return EngineChoice("rasterise")


def probe_osmesa() -> str:
    """Create and free an OSMesa context; returns the OpenGL version it gives.

    Raises
    ------
    RendererError
        If there is none.
    """
    from renderers.osmesa import FloatTarget

    target = FloatTarget(8, 8)
    version = target.version
    target.close()
    return version


def make_engine(name: str, mesh: SceneMesh, camera: Camera, caster: RayCaster) -> Engine:
    """Create an engine by name for a mesh and a camera."""
    if name == "rasterise":
        from renderers.rasterise import RasteriseEngine

        return RasteriseEngine(mesh, camera)
    if name == "raycast":
        from renderers.raycast import RaycastEngine

        return RaycastEngine(caster)
    raise RendererError(f"unknown engine {name!r}; choose {' or '.join(NAMES)}")
