"""The SHA-256 of the files that a study names, held against digests taken by hand."""

import json
from hashlib import sha256

import numpy as np
import pytest

from bench import named_files
from bench.options import RunOptions
from bench.progress import Silent
from bench.runner import run
from bench.study import load, parse
from reports import html

LOG = "EDGE_SE2 0 1 1 0 0 400 0 0 400 0 400\n"


def digest(path):
    return sha256(path.read_bytes()).hexdigest()


@pytest.fixture
def beside(glb, tmp_path):
    """A scene whose buffer and picture lie beside it, the picture under a name with a space."""
    glb.quad("ground", (0, 0, 0), (1, 0, 0), (0, 1, 0))
    glb.texture(np.zeros((2, 2, 3), dtype=np.uint8))
    glb.json["images"][0] = {"uri": "white%20oak.png"}
    glb.json["buffers"][0] |= {"uri": "hall.bin", "byteLength": len(glb.data)}
    (tmp_path / "hall.gltf").write_text(json.dumps(glb.json))
    (tmp_path / "hall.bin").write_bytes(glb.data)
    (tmp_path / "white oak.png").write_bytes(b"wood")
    return tmp_path


def test_of_scenes_lamps_and_filters_wherever_they_stand(beside):
    (beside / "mine.onnx").write_bytes(b"net")
    (beside / "down.ies").write_text("IESNA")
    study = parse(
        "sequence: filters\nname: own\n"
        f"scenes: [corridor, {{file: {beside}/hall.gltf, lamps: {{ies: {beside}/down.ies}}}}]\n"
        f"filters: [seed, {beside}/mine.onnx]\n",
        "x",
    )
    names = ("hall.gltf", "hall.bin", "white oak.png", "down.ies", "mine.onnx")
    assert named_files.sha256(study) == {f"{beside}/{name}": digest(beside / name) for name in names}
    before = named_files.sha256(study)
    (beside / "hall.bin").write_bytes(b"other")
    changed = {path for path, found in named_files.sha256(study).items() if found != before[path]}
    assert changed == {f"{beside}/hall.bin"}


def test_a_study_without_files_has_none_and_missing_ones_are_left_to_their_reader(tmp_path):
    assert named_files.sha256(load("quick")) == named_files.sha256(load("backends")) == {}
    gone = f"scene: {{file: {tmp_path}/gone.glb}}\nfilters: [{tmp_path}/gone.onnx]"
    assert named_files.sha256(parse(f"sequence: rendered\nname: own\n{gone}", "x")) == {}


def test_a_run_and_its_page_tell_them(tmp_path, monkeypatch):
    home = tmp_path / "alice"
    home.mkdir()
    monkeypatch.setenv("HOME", str(home))
    log = home / "my_log.g2o"
    log.write_text(LOG + "EDGE_SE2_XY 0 2 2 1 400 0 400\nEDGE_SE2_XY 1 2 1 1 400 0 400\n")
    text = (
        f"sequence: backends\nname: own\nbackends: [ekf]\nseeds: 1\ndrives: [{{source: file, path: {log}}}]\n"
    )
    folder = run(parse(text, "x"), RunOptions(out=tmp_path / "results"), Silent(), report=html.build)
    stored = json.loads((folder / "provenance.json").read_text())["files_sha256"]
    assert stored == {"~/my_log.g2o": digest(log)}
    assert f"~/my_log.g2o {digest(log)}" in (folder / "report.html").read_text()
