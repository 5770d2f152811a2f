"""Picture pairs from files of every kind to the report."""

import shutil

import cv2
import numpy as np
import pandas as pd
import pytest

from bench import cli
from bench.errors import BenchError
from bench.pairs_run import true_masks
from bench.sequences.pairs import as_light, find, load

HEIGHT, WIDTH = 40, 52


def scene(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coloured stripes in linear light, (H, W, 3), without and with a white lobe, and the lobe."""
    rng = np.random.default_rng(seed)
    colours = rng.uniform(0.1, 0.5, (4, 3))
    diffuse = np.repeat(colours[np.arange(WIDTH) * 4 // WIDTH][None], HEIGHT, axis=0)
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    lobe = 0.5 * np.exp(-((x - rng.uniform(10, 40)) ** 2 + (y - 20) ** 2) / 50)
    return diffuse, np.clip(diffuse + lobe[..., None], 0, 1), lobe


def write(path, light: np.ndarray, depth: type = np.uint8) -> None:
    """Linear light as the file's numbers, BGR for OpenCV."""
    path.parent.mkdir(parents=True, exist_ok=True)
    values = light[..., ::-1] if light.ndim == 3 else light
    full = np.iinfo(depth).max if depth is not np.float32 else 1
    stored = values * full if depth is np.float32 else np.rint(values * full)
    assert cv2.imwrite(str(path), stored.astype(depth))


@pytest.fixture
def folder(tmp_path):
    for k, (suffix, depth) in enumerate([(".png", np.uint8), (".png", np.uint16), (".tif", np.float32)]):
        diffuse, lit, lobe = scene(k)
        write(tmp_path / "pairs" / "input" / f"p{k}{suffix}", lit, depth)
        write(tmp_path / "pairs" / "diffuse" / f"p{k}.png", diffuse, np.uint16)
        write(tmp_path / "pairs" / "mask" / f"p{k}.png", (lobe > 0.1).astype(float))
    return tmp_path / "pairs"


def test_files_of_all_kinds_hold_the_same_light(folder):
    for k, files in enumerate(find(folder)):
        diffuse, lit, lobe = scene(k)
        pair = load(files)
        assert pair.name == f"p{k}"
        np.testing.assert_allclose(as_light(pair.picture), lit, atol=0.5 / 255 + 1e-6)
        np.testing.assert_allclose(pair.diffuse, diffuse, atol=1e-4)
        np.testing.assert_array_equal(pair.mask, lobe > 0.1)


def test_openexr_is_read_in_rgb(folder):
    import OpenEXR

    _, lit, _ = scene(0)
    (folder / "input" / "p0.png").unlink()
    channels = {c: np.ascontiguousarray(lit[..., k], dtype=np.float32) for k, c in enumerate("RGB")}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, channels) as file:
        file.write(str(folder / "input" / "p0.exr"))
    pair = load(find(folder)[0])
    np.testing.assert_allclose(pair.picture, lit, atol=1e-6)
    assert pair.picture.dtype == np.float32


def test_true_masks_are_the_residue_and_the_given_one(folder):
    pair = load(find(folder)[1])
    _, _, lobe = scene(1)
    masks = true_masks(pair, (8, 16, 32))
    assert list(masks) == ["residue > 8", "residue > 16", "residue > 32", "given mask"]
    away = np.abs(lobe - 16 / 255) > 1e-4
    np.testing.assert_array_equal(masks["residue > 16"][away], (lobe > 16 / 255)[away])


def run(folder, out, *options: str) -> int:
    return cli.execute(
        ["run", "--study", "pairs", "--data", str(folder), "--out", str(out), "--workers", "1", *options]
    )


def test_the_study_scores_every_filter_on_every_picture(folder, tmp_path, capsys):
    assert run(folder, tmp_path / "results", "--linear", "--filter", "seed") == 0
    latest = tmp_path / "results" / "latest"
    pictures = pd.read_parquet(latest / "pictures.parquet")
    masks = pd.read_parquet(latest / "masks.parquet")
    assert len(pictures) == 3 * 2 and len(masks) == 3 * 2 * 4
    untouched = pictures[pictures["filter"] == "none"].set_index("picture")
    for k, files in enumerate(find(folder)):
        pair = load(files)
        mse = ((as_light(pair.picture) - pair.diffuse) ** 2).mean()
        assert untouched.loc[f"p{k}", "psnr_db"] == pytest.approx(-10 * np.log10(mse), abs=1e-6)
    assert (masks.loc[masks["filter"] == "none", "iou"] == 0).all()
    page = (latest / "report.html").read_text()
    assert "linear light" in page and "MATLAB" in page
    text = capsys.readouterr().out
    assert "doing nothing has" in text and "residue > 16" in text


FAILING = """
class Failing:
    name = "failing"

    def __call__(self, image):
        raise ValueError("no such light")
"""


def test_a_filter_that_fails_is_told_and_the_others_go_on(folder, tmp_path, capsys, monkeypatch):
    (tmp_path / "plugged_pairs.py").write_text(FAILING)
    monkeypatch.chdir(tmp_path)
    assert run(folder, tmp_path / "results", "--filter", "plugged_pairs:Failing", "--filter", "seed") == 3
    pictures = pd.read_parquet(tmp_path / "results" / "latest" / "pictures.parquet")
    failed = pictures[pictures["filter"] == "failing"]
    assert len(failed) == 3 and failed["status"].str.contains("no such light").all()
    assert (pictures.loc[pictures["filter"] == "seed", "status"] == "ok").all()
    assert "no such light" in capsys.readouterr().out


def without(name):
    def change(folder):
        shutil.rmtree(folder / name)

    return change


def unlink(name):
    return lambda folder: (folder / name).unlink()


def junk(name):
    return lambda folder: (folder / name).write_bytes(b"not a picture")


def smaller(folder):
    write(folder / "diffuse" / "p1.png", np.zeros((10, 10, 3)))


def empty(folder):
    without("input")(folder)
    (folder / "input").mkdir()


def twice(folder):
    shutil.copy(folder / "input" / "p0.png", folder / "input" / "p0.bmp")


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (without("diffuse"), "no such folder"),
        (empty, "holds no picture"),
        (unlink("diffuse/p2.png"), "p2.tif has no partner in diffuse/"),
        (unlink("mask/p0.png"), "p0.png has no partner in mask/"),
        (junk("input/p1.png"), "cannot be read as a picture"),
        (smaller, "a pair has one size"),
        (twice, "share a name"),
    ],
)
def test_bad_folders_are_one_line_and_leave_nothing(folder, tmp_path, capsys, change, expected):
    change(folder)
    assert run(folder, tmp_path / "results") == 2
    error = capsys.readouterr().err.splitlines()[-1]  # a bar may stand above
    assert error.startswith("error: ") and expected in error
    assert not any(p for p in (tmp_path / "results").glob("*"))


def test_the_folder_has_to_be_named(tmp_path, capsys):
    assert cli.execute(["run", "--study", "pairs", "--out", str(tmp_path)]) == 2
    assert "--data DIR" in capsys.readouterr().err


def test_floats_must_be_finite(folder):
    values = np.full((HEIGHT, WIDTH, 3), np.nan)
    write(folder / "input" / "p2.tif", values, np.float32)
    with pytest.raises(BenchError, match="NaN"):
        load(find(folder)[2])


def test_the_packaged_study_takes_all_filters():
    from bench.kinds.pairs import PairsStudy
    from bench.study import load
    from vslam.filters import registry

    study = load("pairs")
    assert isinstance(study, PairsStudy)
    assert study.filters[0].name == "none"
    assert {choice.name for choice in study.filters} == set(registry.names())
