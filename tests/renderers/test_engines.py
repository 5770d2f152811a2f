"""Engine against engine, and what happens where OSMesa is missing."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from scipy import ndimage

from renderers.camera import Fisheye, Intrinsics, Mount, Pinhole, T_world_robot
from renderers.engine import NAMES, choose_engine, make_engine, probe_osmesa
from renderers.errors import RendererError
from renderers.gbuffer import View, fill
from renderers.mesh import RayCaster, build_mesh
from scenes import library


def osmesa_missing():
    try:
        probe_osmesa()
    except RendererError as error:
        return str(error)
    return ""


NO_OSMESA = osmesa_missing()
needs_osmesa = pytest.mark.skipif(bool(NO_OSMESA), reason=NO_OSMESA or "OSMesa is there")

CAMERAS = {
    "pinhole": Pinhole(320, 240, 90.0),
    "fisheye": Fisheye(320, 240, 150.0),
    "barrel": Pinhole(320, 240, 90.0, (-0.2, 0.05, 1e-3, -1e-3, -0.005)),
    "pincushion": Pinhole(320, 240, 70.0, (0.2, 0.05, 0.0, 0.0)),
    "off-centre": Pinhole(320, 240, Intrinsics(240.0, 130.0, 150.3, 99.8), (-0.25, 0.11, 0.0, 0.0)),
    "far to the side": Pinhole(320, 240, 175.0),
    "Kannala-Brandt": Fisheye(320, 240, Intrinsics(125.0, 118.0, 163.0, 112.0), (0.04, -0.01, 2e-3, -1e-4)),
}


@pytest.fixture(scope="module")
def corridor():
    scene = library.load("corridor")
    mesh = build_mesh(scene)
    return scene, mesh, RayCaster(mesh.vertices, mesh.triangles, threads=1)


@needs_osmesa
@pytest.mark.parametrize("name", CAMERAS)
def test_engines_agree(corridor, name):
    """Away from edges, depth within 1 mm and the same surface on 99.9 % of the pixels, at each pose."""
    scene, mesh, caster = corridor
    camera = CAMERAS[name]
    engines = [make_engine(engine, mesh, camera, caster) for engine in NAMES]
    for pose in scene.tour.poses[[0, 23, 61, 100]]:
        view = View(camera, T_world_robot(pose) @ Mount().T_robot_camera)
        drawn, cast = (fill(mesh, view, engine) for engine in engines)
        # an edge: the eight neighbours do not all show the same face of the same surface
        face = np.round(cast.normal, 3) @ [1.0, 10.0, 100.0] + 1000.0 * cast.surface
        flat = ndimage.maximum_filter(face, 3) == ndimage.minimum_filter(face, 3)
        assert flat.mean() > 0.7
        near = np.abs(drawn.depth - cast.depth) < 1e-3
        same = drawn.surface == cast.surface
        assert (near & same)[flat].mean() >= 0.9995
        assert (near & same).mean() >= 0.98  # the edges too agree nearly everywhere
        normals = np.einsum("hwc,hwc->hw", drawn.normal, cast.normal)
        seen = cast.surface >= 0
        assert normals[flat & seen].min() > 0.999
    for engine in engines:
        engine.close()


@needs_osmesa
def test_osmesa_says_its_version():
    assert probe_osmesa()[0].isdigit()
    assert choose_engine("auto").name == "rasterise"
    assert choose_engine("auto").notice == ""
    assert choose_engine("rasterise").name == "rasterise"


@needs_osmesa
def test_engines_share_a_process(corridor):
    """Each engine draws into its own context, whatever was created or closed in between."""
    scene, mesh, caster = corridor
    view = View(Pinhole(64, 48, 80.0), T_world_robot(scene.tour.poses[0]) @ Mount().T_robot_camera)
    first = make_engine("rasterise", mesh, view.camera, caster)
    before = first.visible(view)[0]
    second = make_engine("rasterise", mesh, Pinhole(32, 24, 60.0), caster)
    second.close()
    np.testing.assert_array_equal(first.visible(view)[0], before)
    first.close()


def test_unknown_engines():
    with pytest.raises(RendererError, match="unknown engine 'vulkan'"):
        choose_engine("vulkan")
    with pytest.raises(RendererError, match="unknown engine 'auto'"):
        make_engine("auto", None, CAMERAS["pinhole"], None)


def test_raycast_needs_no_probe():
    assert choose_engine("raycast").name == "raycast"
    assert choose_engine("raycast").notice == ""


WITHOUT_OSMESA = """
import ctypes, ctypes.util
real_load, real_find = ctypes.CDLL.__init__, ctypes.util.find_library

def load(self, name, *args, **kwargs):
    if name and "OSMesa" in str(name):
        raise OSError(f"{name}: cannot open shared object file: No such file or directory")
    real_load(self, name, *args, **kwargs)

ctypes.CDLL.__init__ = load
ctypes.util.find_library = lambda name: None if "OSMesa" in name else real_find(name)

from renderers.engine import choose_engine
from renderers.errors import RendererError

choice = choose_engine("auto")
print(choice.name)
print(choice.notice)
try:
    choose_engine("rasterise")
except RendererError as error:
    print("refused:", error)
"""


def test_without_osmesa_auto_falls_back_and_rasterise_refuses():
    """In a process whose loader cannot find the library, as on a system without it."""
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_OSMESA], capture_output=True, text=True, timeout=60, check=True
    )
    name, notice, refused = done.stdout.splitlines()  # three lines: neither message breaks its line
    assert name == "raycast"
    assert notice.startswith("using the raycast engine")
    assert refused.startswith("refused: engine 'rasterise'")
    for message in (notice, refused):
        assert "OSMesa" in message and "libosmesa6" in message
