"""What a rendered study takes from the DLR log: the folder for a scene that rebuilds it, and its camera."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from bench.data import dlr_folder
from bench.study_model import BackendsStudy, FiltersStudy, RenderedStudy, Study

S = TypeVar("S", bound=Study)

LOG = "log"
"""Name of the parameter by which a scene's builder asks for the log."""


def reads_data(study: Study) -> bool:
    """Whether the study is about recorded data, or its scene or camera comes out of the log."""
    if isinstance(study, FiltersStudy):
        return study.camera.source == "dlr" or any(_scene_asks(scene.name) for scene in study.scenes)
    if isinstance(study, BackendsStudy):
        return any(drive.source in ("recorded", "virtual") for drive in study.drives)
    if not isinstance(study, RenderedStudy):
        return True
    return study.camera.source == "dlr" or _scene_asks(study.scene.name)


def _scene_asks(name: str) -> bool:
    from scenes import library

    return any(info.name == name and LOG in info.parameters for info in library.describe())


def resolved(study: S, data: Path | None = None) -> S:
    """The study with the log's folder and the numbers of its camera filled in; others stay as they are.

    Parameters
    ----------
    data : Path or None
        From ``--data``; None searches the usual places (`bench.data.dlr_folder`).

    Raises
    ------
    BenchError
        If the study needs the log and there is none, or it has no camera.
    """
    if not isinstance(study, RenderedStudy) or not reads_data(study):
        return study
    from bench.sequences.dlr_camera import robot_camera

    folder, scene, camera = dlr_folder(data).resolve(), study.scene, study.camera
    if _scene_asks(scene.name):
        scene = scene.model_copy(update={"parameters": {LOG: str(folder), **scene.parameters}})
    if camera.source == "dlr":
        own = {"supersampling": camera.supersampling, "optics": camera.optics}
        camera = robot_camera(folder).model_copy(update=own)
    return study.model_copy(update={"scene": scene, "camera": camera})
