"""Baked light on disk, found by the content that it was baked from."""

from __future__ import annotations

import hashlib
import os
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np

from renderers import appearance, bake_points, gather, irradiance, lights, shadows
from renderers.irradiance import FULL_QUALITY, BakeQuality, Irradiance
from renderers.lights import UnitLight, unit_lights
from renderers.mesh import RayCaster, SceneMesh, build_mesh
from scenes.model import Scene

WORTH_SAYING_S = 30.0


def bake_scene(scene: Scene, folder: Path, say: Callable[[str], None] = lambda text: None) -> None:
    """Bake a scene's light into the cache, on all cores, for the renderers of other processes to find.

    Parameters
    ----------
    say : callable
        Told beforehand in a line how long it will take, if that is long.
    """
    mesh, layers = build_mesh(scene), list(unit_lights(scene).values())
    caster = RayCaster(mesh.vertices, mesh.triangles)
    if not _path(folder, mesh, layers, FULL_QUALITY).exists():
        seconds = irradiance.expected_seconds(mesh, caster, layers)
        if seconds > WORTH_SAYING_S:
            say(
                f"{len(mesh.triangles):,} triangles: baking their light takes about {seconds:.0f} s, once; "
                "it is kept for later runs"
            )
    load_or_bake(mesh, caster, layers, folder)


def load_or_bake(
    mesh: SceneMesh,
    caster: RayCaster,
    layers: list[list[UnitLight]],
    folder: Path | None,
    quality: BakeQuality = FULL_QUALITY,
) -> Irradiance:
    """Read the baked light of this very mesh and these lights, or bake and keep it.

    Parameters
    ----------
    folder : Path, optional
        Where to keep it; without one, or where it cannot be written, nothing is kept.
    """
    if folder is None:
        return irradiance.bake(mesh, caster, layers, quality)
    path = _path(folder, mesh, layers, quality)
    try:
        with np.load(path) as stored:
            return Irradiance(stored["indirect"], stored["total"])
    except (OSError, KeyError, ValueError, EOFError, zipfile.BadZipFile):  # none yet, or cut short
        baked = irradiance.bake(mesh, caster, layers, quality)
    _keep(path, baked)
    return baked


def _path(folder: Path, mesh: SceneMesh, layers: list[list[UnitLight]], quality: BakeQuality) -> Path:
    return folder / f"irradiance-{_key(mesh, layers, quality)}.npz"


def _key(mesh: SceneMesh, layers: list[list[UnitLight]], quality: BakeQuality) -> str:
    digest = hashlib.blake2b(digest_size=16)
    albedo = gather.diffuse_albedo(mesh.materials)
    for array in (mesh.vertices, mesh.triangles, mesh.surface, albedo, mesh.uv):
        digest.update(np.ascontiguousarray(array).tobytes())
    digest.update(mesh.textures.digest())
    digest.update(repr((layers, quality)).encode())
    for module in (
        irradiance,
        gather,
        bake_points,
        appearance,
        lights,
        shadows,
    ):  # another method is another result
        digest.update(Path(str(module.__file__)).read_bytes())
    return digest.hexdigest()


def _keep(path: Path, baked: Irradiance) -> None:
    aside = path.with_name(f"{path.stem}.{os.getpid()}.partial.npz")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez(aside, indirect=baked.indirect, total=baked.total)
        aside.replace(path)
    except OSError:  # a cache that cannot be written costs time, not results
        with suppress(OSError):
            aside.unlink()
