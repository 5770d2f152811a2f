"""Making data sets: whole or continued, the same bytes however they came about, and refused in one line."""

from __future__ import annotations

import errno
import json
import pickle
import re
import shutil
import subprocess
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import scenes
from bench import cli
from bench.camera_choice import CameraChoice
from bench.datasets import PictureSet
from bench.datasets.verify import verify
from bench.errors import BenchError
from bench.generate import generate, resume
from bench.kinds.rendered import RenderedStudy
from bench.options import GenerateOptions
from bench.progress import Silent

LAYOUTS = ("tum", "euroc", "coco", "exr", "raw")
LIGHTS = ("sun0-bulb200", "sun20000-bulb800")
FRAMES = 4

pytestmark = pytest.mark.usefixtures("cache_home")


@pytest.fixture(scope="module")
def study(short_study: RenderedStudy) -> RenderedStudy:
    """Tiny pictures; the scene, and so its baked light, is that of other tests."""
    tour = short_study.tour.model_copy(update={"frame_interval_s": 0.05})
    return short_study.model_copy(update={"camera": CameraChoice(width=32, height=24), "tour": tour})


def _options(out: Path, **changes: object) -> GenerateOptions:
    usual = {"illuminations": LIGHTS, "frames": FRAMES, "layouts": LAYOUTS}
    return GenerateOptions(out, **{**usual, **changes})


@pytest.fixture(scope="module")
def whole(study: RenderedStudy, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set made in one go; tests read it only."""
    out = tmp_path_factory.mktemp("whole") / "set"
    generate(study, _options(out), Silent())
    return out


@pytest.fixture
def copied(whole: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(whole, tmp_path / "set"))


def _content(root: Path) -> dict[str, bytes]:
    return {str(p.relative_to(root)): p.read_bytes() for p in root.rglob("*") if p.is_file()}


class Calls(Silent):
    """Calls a function after each step of the stage that writes."""

    def __init__(self, after_step: Callable[[int], None]) -> None:
        self._after_step, self._steps, self.notices = after_step, 0, list[str]()

    @contextmanager
    def stage(self, title: str, total: int) -> Iterator[Callable[[int], None]]:
        yield self._advance if title.startswith("generate") else lambda _: None

    def notice(self, text: str) -> None:
        self.notices.append(text)

    def _advance(self, steps: int) -> None:
        self._steps += steps
        self._after_step(self._steps)


def _interrupt_after(steps: int) -> Calls:
    def check(done: int) -> None:
        if done == steps:
            raise KeyboardInterrupt

    return Calls(check)


def test_every_file_is_listed_with_its_digest(whole):
    listed = set(json.loads((whole / "dataset.json").read_text())["files"])
    assert listed == set(_content(whole)) - {"dataset.json"}
    verdict = verify(whole, Silent())
    assert (verdict.files, verdict.problems) == (len(listed), ())


def test_the_same_bytes_for_two_processes(whole, study, tmp_path):
    generate(study, _options(tmp_path / "set", workers=2), Silent())
    assert _content(tmp_path / "set") == _content(whole)


def test_an_interrupted_data_set_is_continued_to_the_same_bytes(whole, study, tmp_path):
    out = tmp_path / "set"
    with pytest.raises(KeyboardInterrupt):
        generate(study, _options(out), _interrupt_after(2))
    unfinished = verify(out, Silent()).problems
    assert unfinished == ("dataset.json: missing, as only 4 of 8 pictures are made",)
    with (out / "pictures.jsonl").open("ab") as index:
        index.write(b'{"sequence":"corridor/sun0')  # as a crash leaves it
    resume(out, 1, Silent())
    assert _content(out) == _content(whole)


def test_what_is_there_is_not_made_again(copied):
    (copied / "tum/corridor/sun0-bulb200/rgb/000002.png").unlink()
    steps = []
    resume(copied, 1, Calls(steps.append))
    assert steps == [1]


def test_verify_names_each_damaged_and_missing_file_and_resume_mends_them(whole, copied):
    picture = copied / "tum/corridor/sun0-bulb200/rgb/000001.png"
    data = bytearray(picture.read_bytes())
    data[len(data) // 2] ^= 1  # one bit, the same size
    picture.write_bytes(data)
    (copied / "exr/corridor/sun20000-bulb800/000003.exr").unlink()
    (copied / "coco/corridor/sun0-bulb200/annotations.json").write_text("{}")
    assert set(verify(copied, Silent()).problems) == {
        "tum/corridor/sun0-bulb200/rgb/000001.png: damaged",
        "exr/corridor/sun20000-bulb800/000003.exr: missing",
        "coco/corridor/sun0-bulb200/annotations.json: damaged",
    }
    resume(copied, 1, Silent())
    assert _content(copied) == _content(whole)


@pytest.mark.parametrize("name", ["dataset.json", "pictures.jsonl"])
def test_a_damaged_index_is_named_and_mended(whole, copied, name):
    (copied / name).write_bytes((whole / name).read_bytes()[:-100])
    assert verify(copied, Silent()).problems == (f"{name}: damaged",)
    resume(copied, 1, Silent())
    assert _content(copied) == _content(whole)


@contextmanager
def _small_disk(at: Path, size: str) -> Iterator[Path]:
    """A file system of a few megabytes, where the machine lets us have one."""
    at.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={size}", "none", str(at)], capture_output=True, check=False
    )
    if mounted.returncode:
        pytest.skip("may not mount a small file system")
    try:
        yield at
    finally:
        subprocess.run(["umount", "-l", str(at)], check=True)


@pytest.mark.parametrize("processes", [1, 2])
def test_a_full_disk_stops_cleanly_and_is_continued(whole, study, tmp_path, processes):
    with _small_disk(tmp_path / "disk", "2M") as disk:
        ballast, out = disk / "ballast", disk / "set"

        def fill(done: int) -> None:
            if done == 1:
                with pytest.raises(OSError) as full, ballast.open("wb", buffering=0) as file:
                    while True:
                        file.write(bytes(4096))
                assert full.value.errno == errno.ENOSPC

        with pytest.raises(BenchError, match=r"No space left on device; make room, then .*--resume") as error:
            generate(study, _options(out, workers=processes), Calls(fill))
        assert "\n" not in str(error.value)
        assert not (out / "dataset.json").exists() and not list(out.rglob("*.partial"))
        assert len(verify(out, Silent()).problems) == 1  # unfinished, but all that is listed is whole
        with pytest.raises(BenchError, match=r"No space left on device|MB free"):
            resume(out, processes, Silent())
        ballast.unlink()
        resume(out, processes, Silent())
        assert _content(out) == _content(whole)


def test_the_size_is_said_beforehand_and_about_right(whole, study, tmp_path):
    told = Calls(lambda _: None)
    generate(study, _options(tmp_path / "set"), told)
    (notice,) = told.notices
    assert notice.startswith("8 pictures, about ")
    megabytes = float(notice.split()[3])
    listed = json.loads((whole / "dataset.json").read_text())["files"]
    pictures = sum(f["bytes"] for path, f in listed.items() if path.endswith((".png", ".exr")))
    assert megabytes == pytest.approx(pictures / 1e6, rel=0.3, abs=0.05)


def test_too_little_disk_is_said_before_pictures_are_made(study, tmp_path):
    with _small_disk(tmp_path / "disk", "256k") as disk:
        with pytest.raises(BenchError, match="MB needed"):
            generate(study, _options(disk / "set", frames=None), Silent())
        assert [p.name for p in (disk / "set").iterdir()] == ["request.json"]


def test_memory_does_not_grow_with_the_number_of_pictures(study, tmp_path):
    def peak(out: Path, frames: int) -> int:
        tracemalloc.start()
        generate(study, _options(out, frames=frames, layouts=("tum", "coco")), Silent())
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    peak(tmp_path / "first", 2)  # loads and compiles
    few, many = peak(tmp_path / "few", 6), peak(tmp_path / "many", 60)
    assert many < few + 300_000  # 108 pictures more; one of them has 20 kB of arrays, its index line 2 kB


def test_the_reader_gives_what_a_data_loader_takes(whole):
    pictures = pickle.loads(pickle.dumps(PictureSet(whole)))
    assert len(pictures) == len(LIGHTS) * FRAMES == len(list(pictures))
    item = pictures[5]
    assert (item["sequence"], item["frame"]) == ("corridor/sun20000-bulb800", 1)
    kinds = {name: (a.shape, str(a.dtype)) for name, a in item.items() if isinstance(a, np.ndarray)}
    assert kinds == {
        "pose": ((3,), "float64"),
        "image": ((24, 32, 3), "uint8"),
        "depth": ((24, 32), "float32"),
        "mask": ((24, 32), "bool"),
        "diffuse": ((24, 32, 3), "float32"),
        "specular": ((24, 32, 3), "float32"),
    }
    assert all(a.flags.writeable for a in item.values() if isinstance(a, np.ndarray))
    batch = {name: np.stack([pictures[k][name] for k in range(8)]) for name in kinds}  # as collating does
    assert batch["image"].shape == (8, 24, 32, 3)
    with pytest.raises(IndexError):
        pictures[len(pictures)]
    np.testing.assert_array_equal(pictures[-1]["image"], pictures[len(pictures) - 1]["image"])


def test_the_reader_s_layouts_agree(whole):
    tum, exr, raw = (PictureSet(whole, layout) for layout in ("tum", "exr", "raw"))
    for layout in ("euroc", "coco"):
        np.testing.assert_array_equal(PictureSet(whole, layout)[6]["image"], tum[6]["image"])
    np.testing.assert_allclose(exr[6]["full"], exr[6]["diffuse"] + exr[6]["specular"], rtol=2e-3, atol=1e-3)
    near = exr[6]["depth"] < 13
    np.testing.assert_allclose(tum[6]["depth"][near], exr[6]["depth"][near], atol=1.01e-4)
    brightness = raw[6]["raw"].astype(float).ravel()
    assert np.corrcoef(brightness, np.minimum(tum[6]["diffuse"] + tum[6]["specular"], 1).ravel())[0, 1] > 0.99


def test_the_reader_refuses_what_is_not_there(whole, tmp_path):
    with pytest.raises(BenchError, match="did you mean 'tum'"):
        PictureSet(whole, "tumm")
    with pytest.raises(BenchError, match=r"unknown layout of .* 'exr-float': did you mean 'exr'"):
        PictureSet(whole, "exr-float")
    with pytest.raises(BenchError, match=r"unknown split of .* 'train': known: all"):
        PictureSet(whole, split="train")
    with pytest.raises(BenchError, match=r"dataset.json: cannot be read"):
        PictureSet(tmp_path)


HALL = """
import numpy as np
from scenes.geometry import rectangle, surface
from scenes.library import scene
from scenes.model import Bulb, Landmark, Material, Scene, Sky, Sun
from scenes.tour import drive, rounded_loop

@scene("hall")
def build(seed=0, speed_mps=0.93, frame_interval_s=0.5):
    "An open hall."
    grey = Material((0.3, 0.3, 0.3), roughness=0.2)
    floor = surface("floor", grey, rectangle((0, 0, 0), (8, 0, 0), (0, 8, 0)))
    places = np.random.default_rng(seed).uniform(1, 7, (4, 2))
    discs = tuple(Landmark(k, tuple(p), 0.15, white=k < 2) for k, p in enumerate(places.tolist()))
    way = rounded_loop(np.array([[3.0, 3.0], [5.0, 3.0], [5.0, 5.0], [3.0, 5.0]]), radius=0.5)
    tour = drive(way, 0.0, 12.0, speed_mps, frame_interval_s)
    return Scene("hall", (floor,), discs, (Sun(180, 40, 20_000),), Sky(2_500), (Bulb((4, 4, 2.5), 800),),
                 tour, "floor", (0.85,) * 3, (0.03,) * 3, (0, 0, 8, 8))
"""


@pytest.fixture
def hall(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A scene that bakes in no time, found as any module of the room is."""
    (tmp_path / "room").mkdir()
    (tmp_path / "room" / "hall.py").write_text(HALL)
    monkeypatch.setattr(scenes, "__path__", [*scenes.__path__, str(tmp_path / "room")])


@pytest.mark.usefixtures("hall")
def test_splits_share_no_geometry_and_are_read_apart(study, tmp_path):
    out = tmp_path / "set"
    splits = ("train", "test")
    generate(study, _options(out, scenes=("hall",), splits=splits, frames=1, layouts=("tum",)), Silent())
    train, test = (PictureSet(out, split=split) for split in splits)
    assert {train[k]["sequence"] for k in range(2)} == {f"hall-train/{light}" for light in LIGHTS}
    assert {test[k]["sequence"] for k in range(2)} == {f"hall-test/{light}" for light in LIGHTS}
    marks = [(out / f"tum/hall-{split}/{LIGHTS[0]}/landmarks.csv").read_text() for split in splits]
    assert marks[0] != marks[1]
    manifest = json.loads((out / "dataset.json").read_text())
    assert {split: len(names) for split, names in manifest["splits"].items()} == {"train": 2, "test": 2}
    import mlcroissant

    records = list(mlcroissant.Dataset(str(out / "croissant.json")).records("pictures"))
    assert [r["pictures/split"] for r in records] == [b"train", b"train", b"test", b"test"]


def test_a_tour_through_a_wall_is_refused_with_its_place(study, tmp_path, monkeypatch, capsys):
    """Of a scene that is a module; of a file it is refused where the tour is planned."""
    wall = "surface('wall', grey, rectangle((4, 0, 0), (0, 4, 0), (0, 0, 2)))"
    (tmp_path / "room").mkdir()
    (tmp_path / "room" / "walled.py").write_text(
        HALL.replace('"hall"', '"walled"').replace("(floor,)", f"(floor, {wall})")
    )
    monkeypatch.setattr(scenes, "__path__", [*scenes.__path__, str(tmp_path / "room")])
    arguments = ["generate", "--scene", "walled", "--out", str(tmp_path / "set"), "--frames", "1"]
    assert cli.execute(arguments) == 2
    error = capsys.readouterr().err
    assert re.search(r"^error: scene 'walled': the tour runs into an obstacle at \((3\.9|4)", error, re.M)
    assert not list((tmp_path / "set").rglob("*.png"))


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--layout", "tmu"], "unknown layout 'tmu': did you mean 'tum'?"),
        (["--scene", "coridor"], "unknown scene 'coridor': did you mean 'corridor'?"),
        (["--split", "tests"], "unknown split 'tests': did you mean 'test'?"),
        (
            ["--illumination", "sun0-bulb10"],
            "'sun0-bulb10': did you mean 'sun0-bulb100'",
        ),
    ],
)
def test_unknown_names_are_one_line_and_write_nothing(capsys, tmp_path, arguments, expected):
    assert cli.execute(["generate", "--out", str(tmp_path / "x"), *arguments]) == 2
    error = capsys.readouterr().err
    assert expected in error and error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_holds_something_is_refused_and_kept(copied, study):
    before = _content(copied)
    with pytest.raises(BenchError, match=r"exists already; continue it with --resume"):
        generate(study, _options(copied), Silent())
    assert _content(copied) == before


def test_the_command_verifies(capsys, copied):
    assert cli.execute(["generate", "--verify", str(copied)]) == 0
    assert "all whole" in capsys.readouterr().out
    (copied / "frames.csv").unlink()
    assert cli.execute(["generate", "--verify", str(copied)]) == 2
    printed = capsys.readouterr()
    assert printed.out == "frames.csv: missing\n"
    assert "1 files missing or damaged; mend them with: python -m bench generate --resume" in printed.err
    assert cli.execute(["generate", "--resume", str(copied)]) == 0
    assert cli.execute(["generate", "--verify", str(copied)]) == 0


def test_another_version_does_not_continue(copied):
    request = json.loads((copied / "request.json").read_text())
    (copied / "request.json").write_text(json.dumps(request | {"glarebench": "0.0.1"}))
    with pytest.raises(BenchError, match=r"begun by glarebench 0\.0\.1, this is"):
        resume(copied, 1, Silent())


@pytest.mark.parametrize("content", [None, "{}", "no JSON"])
def test_what_is_no_data_set_is_refused(tmp_path, content):
    if content is not None:
        (tmp_path / "request.json").write_text(content)
    for command in (lambda: verify(tmp_path, Silent()), lambda: resume(tmp_path, 1, Silent())):
        with pytest.raises(BenchError, match=r"not a data set|cannot be read"):
            command()
