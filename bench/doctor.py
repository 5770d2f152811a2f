"""Checks that this machine can run the suite; each check says ok, or what to do."""

from __future__ import annotations

import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from bench import provenance
from bench.data import dlr_folder
from bench.errors import BenchError

Status = Literal["ok", "warn", "fail"]

_RESULTS_BYTES = 1_000_000_000  # ten quick runs with room to spare
_MEMORY_BYTES = 3_500_000_000  # two workers with Open3D loaded
_OSMESA = "from renderers.engine import probe_osmesa; print(probe_osmesa())"
_RAYCAST = """
import numpy as np, open3d as o3d
scene = o3d.t.geometry.RaycastingScene()
corners = np.array([[-1, -1, 2], [1, -1, 2], [0, 1, 2]], np.float32)
scene.add_triangles(corners, np.array([[0, 1, 2]], np.uint32))
hit = scene.cast_rays(o3d.core.Tensor([[0, 0, 0, 0, 0, 1]], o3d.core.float32))["t_hit"].item()
assert abs(hit - 2) < 1e-3, hit
print(o3d.__version__)
"""


@dataclass(frozen=True)
class Check:
    """One line of the report. ``fail`` means that a run is not possible."""

    name: str
    status: Status
    detail: str


def examine(out: Path = Path("results"), data: Path | None = None) -> list[Check]:
    """Run every check.

    Parameters
    ----------
    out : Path
        The results folder that a run would use.
    data : Path or None
        The DLR folder from ``--data``.
    """
    return [*_engines(), _python(), _packages(), _cores(), _memory(), _disk(out), _dlr(data)]


def runnable(checks: list[Check]) -> bool:
    """Whether no check failed."""
    return all(check.status != "fail" for check in checks)


def _engines() -> list[Check]:
    """A ray caster is needed by both engines (shadows); OSMesa by one. Each may take its process down."""
    caster = _in_subprocess(_RAYCAST)
    osmesa = _in_subprocess(_OSMESA)
    return [
        Check("ray caster", "ok", f"Open3D {caster.text} casts rays")
        if caster.works
        else Check(
            "ray caster", "fail", f"Open3D does not work ({caster.text}); run make setup, see its notices"
        ),
        Check("OSMesa", "ok", f"OpenGL {osmesa.text}: engine rasterise")
        if osmesa.works
        else Check(
            "OSMesa", "warn", f"{osmesa.text}; the raycast engine is used until libosmesa6 is installed"
        ),
    ]


@dataclass(frozen=True)
class _Outcome:
    works: bool
    text: str


def _in_subprocess(code: str) -> _Outcome:
    """Run the code in a fresh interpreter; its last line of output says how it went."""
    try:
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    except subprocess.TimeoutExpired:
        return _Outcome(False, "no answer within 120 s")
    lines = (done.stdout if done.returncode == 0 else done.stderr).strip().splitlines()
    # an exception's line names its class; the message alone is for the reader
    last = lines[-1].split("Error: ", 1)[-1] if lines else f"ended with {done.returncode}"
    return _Outcome(done.returncode == 0, last)


def _python() -> Check:
    return Check("Python", "ok", f"{sys.version.split()[0]}, glarebench {provenance.version('glarebench')}")


def _packages() -> Check:
    versions = {name: provenance.version(name) for name in provenance.PACKAGES}
    missing = [name for name, found in versions.items() if found == "not installed"]
    if missing:
        return Check(
            "packages", "fail", f"not installed: {', '.join(missing)}; run make setup or pip install ."
        )
    return Check("packages", "ok", ", ".join(f"{name} {found}" for name, found in versions.items()))


def _cores() -> Check:
    count = provenance.cores()
    if count < 2:
        return Check("cores", "warn", "1: a run takes about twice the time that is stated for two cores")
    return Check("cores", "ok", f"{count}")


def _memory() -> Check:
    total = provenance.memory_bytes()
    if total < _MEMORY_BYTES:
        return Check("memory", "warn", f"{total / 1e9:.1f} GB: use --workers 1")
    return Check("memory", "ok", f"{total / 1e9:.1f} GB")


def _disk(out: Path) -> Check:
    place = next(p for p in (out.absolute(), *out.absolute().parents) if p.exists())
    free = shutil.disk_usage(place).free
    if free < _RESULTS_BYTES:
        return Check("disk", "warn", f"{free / 1e9:.1f} GB free for {out}: make room or use --out elsewhere")
    return Check("disk", "ok", f"{free / 1e9:.0f} GB free for {out}")


def _dlr(data: Path | None) -> Check:
    try:
        return Check("DLR log", "ok", f"{dlr_folder(data)}")
    except BenchError as error:
        return Check("DLR log", "warn", f"needed by --study dlr alone: {error}")
