"""What a rendered study takes from the DLR log: the folder for a scene that rebuilds it, and its camera."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from bench.data import dlr_folder
from bench.kinds.rendered import RenderedStudy
from bench.scene_choice import LOG
from bench.study_model import Study

S = TypeVar("S", bound=Study)


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
    if not isinstance(study, RenderedStudy) or not study.reads_data():
        return study
    from bench.sequences.dlr_camera import robot_camera

    folder, scene, camera = dlr_folder(data).resolve(), study.scene, study.camera
    if scene.reads_log():
        scene = scene.model_copy(update={"parameters": {LOG: str(folder), **scene.parameters}})
    if camera.source == "dlr":
        own = {"supersampling": camera.supersampling, "optics": camera.optics}
        camera = robot_camera(folder).model_copy(update=own)
    return study.model_copy(update={"scene": scene, "camera": camera})
