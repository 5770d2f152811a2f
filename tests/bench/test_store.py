"""A run's folder: whole or not there, its tables exactly the schema's, the same bytes for the same rows."""

import errno
import os
import re
import shutil
from collections import namedtuple
from datetime import datetime
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from evo.tools import file_interface

from bench.errors import BenchError
from bench.schema import FRAME_COLUMNS, RUN_COLUMNS
from bench.store import RunFolder, read, tum_lines

NOON = datetime(2026, 1, 2, 12, 30, 45)


def row(columns: dict[str, str], **changes: object) -> dict[str, object]:
    values: dict[str, object] = {"string": "corridor", "int64": 3, "float64": 0.25}
    return {name: values[kind] for name, kind in columns.items()} | changes


def write_run(out: Path, frames: int = 2) -> Path:
    with RunFolder(out, "quick", now=NOON) as folder:
        folder.write_text("study.yaml", "name: quick\n")
        folder.write_json("provenance.json", {"seed": 1})
        folder.write_frames(row(FRAME_COLUMNS, frame=k) for k in range(frames))
        folder.write_runs([row(RUN_COLUMNS, nees=float("nan"))])
        folder.write_trajectory("none", [0.0, 0.5], [[0, 0, 0], [1, 2, np.pi / 2]])
    return folder.path


def test_a_run_gets_its_name_at_the_end(tmp_path):
    with RunFolder(tmp_path, "quick", now=NOON) as folder:
        folder.write_text("study.yaml", "")
        visible = [p.name for p in tmp_path.iterdir() if not p.name.startswith(".")]
        assert visible == []
    assert folder.path == tmp_path / "quick-20260102-123045"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["latest", "quick-20260102-123045"]
    assert (tmp_path / "latest").resolve() == folder.path.resolve()


def test_latest_is_relative_and_moves_on(tmp_path):
    first = write_run(tmp_path)
    second = write_run(tmp_path)
    assert second.name == f"{first.name}-2"  # the same second
    assert os.readlink(tmp_path / "latest") == second.name
    moved = tmp_path.rename(tmp_path.with_name("moved"))
    assert (moved / "latest" / "study.yaml").is_file()


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_a_failure_leaves_nothing(tmp_path, error):
    done = write_run(tmp_path)
    with pytest.raises(error), RunFolder(tmp_path, "quick") as folder:
        folder.write_text("figures/a.csv", "x")
        raise error
    assert sorted(p.name for p in tmp_path.iterdir()) == ["latest", done.name]
    assert os.readlink(tmp_path / "latest") == done.name


def test_read_gives_back_what_was_written(tmp_path):
    run = read(write_run(tmp_path))
    assert run.study == "name: quick\n"
    assert run.provenance == {"seed": 1}
    assert list(run.frames.columns) == list(FRAME_COLUMNS)
    assert run.frames["frame"].tolist() == [0, 1]
    assert np.isnan(run.runs["nees"].iloc[0])
    assert run.runs["status"].iloc[0] == "corridor"


def test_tables_have_the_schema_even_without_rows(tmp_path):
    path = write_run(tmp_path, frames=0)
    schema = pq.read_schema(path / "frames.parquet")
    assert [(f.name, str(f.type).replace("double", "float64")) for f in schema] == list(FRAME_COLUMNS.items())
    assert len(read(path).frames) == 0


def test_the_same_rows_give_the_same_bytes(tmp_path):
    one, other = write_run(tmp_path / "one"), write_run(tmp_path / "other")
    for name in ("frames.parquet", "runs.parquet", "trajectories/none.tum"):
        assert (one / name).read_bytes() == (other / name).read_bytes()


def test_nans_of_any_sign_give_the_same_bytes(tmp_path):
    tables = []
    for name, nan in (("plus", np.nan), ("minus", np.copysign(np.nan, -1))):
        with RunFolder(tmp_path / name, "quick") as folder:
            tables.append(folder.write_frames([row(FRAME_COLUMNS, iou=nan)]).read_bytes())
    assert tables[0] == tables[1]


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"frame": 1.0}, "frame is 1.0, not int64"),
        ({"frame": True}, "frame is True, not int64"),
        ({"filter": None}, "filter is None, not string"),
        ({"iou": "0.5"}, "iou is '0.5', not float64"),
        ({"iuo": 0.5}, r"columns missing \[\], unknown \['iuo'\]"),
    ],
)
def test_a_row_that_is_not_the_schemas_is_refused(tmp_path, changes, complaint):
    with (
        pytest.raises(BenchError, match=rf"^frames.parquet row 1: {complaint}"),
        RunFolder(tmp_path, "q") as folder,
    ):
        folder.write_frames([row(FRAME_COLUMNS), row(FRAME_COLUMNS, **changes)])


def test_a_missing_column_is_refused(tmp_path):
    short = {k: v for k, v in row(RUN_COLUMNS).items() if k != "nees"}
    with pytest.raises(BenchError, match=r"missing \['nees'\]"), RunFolder(tmp_path, "quick") as folder:
        folder.write_runs([short])


def test_numpy_scalars_are_numbers(tmp_path):
    with RunFolder(tmp_path, "quick") as folder:
        folder.write_frames([row(FRAME_COLUMNS, frame=np.int32(7), iou=np.float32(0.5), f1=1)])
        table = pq.read_table(folder.path / "frames.parquet").to_pylist()
    assert (table[0]["frame"], table[0]["iou"], table[0]["f1"]) == (7, 0.5, 1.0)


def test_a_trajectory_in_tum_format():
    lines = tum_lines([0, 1.5], [[1, 2, 0], [3, 4, np.pi / 2]])
    stamp, x, y, z, *quaternion = (float(v) for v in lines[1].split())
    assert (stamp, x, y, z) == (1.5, 3, 4, 0)
    # a quarter turn about z: (0, 0, sin 45°, cos 45°)
    assert quaternion == pytest.approx([0, 0, np.sqrt(0.5), np.sqrt(0.5)])
    assert all(len(line.split()) == 8 for line in lines)


def test_evo_reads_a_trajectory_with_equal_numbers(tmp_path):
    stamps, poses = [0.0, 0.5, 1.0], np.array([[1, 2, 0], [3, -4, np.pi / 2], [-60.123456, 43.9, -3.1]])
    path = tmp_path / "none.tum"
    path.write_text("".join(f"{line}\n" for line in tum_lines(stamps, poses)))
    track = file_interface.read_tum_trajectory_file(path)
    valid, details = track.check()
    assert valid, details
    np.testing.assert_allclose(track.timestamps, stamps)
    np.testing.assert_allclose(track.positions_xyz, np.column_stack([poses[:, :2], np.zeros(3)]), atol=1e-9)
    np.testing.assert_allclose(track.get_orientations_euler("sxyz")[:, 2], poses[:, 2], atol=1e-9)


def test_a_trajectory_must_be_whole_and_finite():
    with pytest.raises(BenchError, match="2 stamps but poses of shape"):
        tum_lines([0, 1], np.zeros((3, 3)))
    with pytest.raises(BenchError, match="not finite"):
        tum_lines([0], [[0, np.inf, 0]])


def test_a_file_where_the_results_folder_should_be(tmp_path):
    (tmp_path / "results").write_text("")
    with pytest.raises(BenchError, match=r"results: cannot be written \(.*\); choose another with --out"):
        RunFolder(tmp_path / "results", "quick")


def test_a_results_folder_that_may_not_be_written(tmp_path, monkeypatch):
    # as root no permission bit forbids anything, so the system's refusal is raised here
    def refuse(self: Path, *_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(self))

    monkeypatch.setattr(Path, "touch", refuse)
    with pytest.raises(BenchError, match=r"cannot be written \(Permission denied\)"):
        RunFolder(tmp_path, "quick")


def test_too_little_disk(tmp_path, monkeypatch):
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(10**9, 10**9 - 10**6, 10**6))
    with pytest.raises(BenchError, match="1 MB free, about 50 MB needed; make room"):
        RunFolder(tmp_path, "quick", needed_bytes=50_000_000)
    assert not any(tmp_path.iterdir())


def test_a_latest_that_is_not_ours_is_left_alone(tmp_path):
    (tmp_path / "latest").mkdir()
    with pytest.raises(BenchError, match="latest: is no link to a run"):
        RunFolder(tmp_path, "quick")


def test_reading_what_is_no_run(tmp_path):
    with pytest.raises(BenchError, match=re.escape(f"{tmp_path}: not the folder of a run")):
        read(tmp_path)


@pytest.mark.parametrize(
    ("name", "content", "complaint"),
    [
        ("frames.parquet", b"", "cannot be read"),
        ("runs.parquet", b"PAR1 no table", "cannot be read"),
        ("provenance.json", b"{", "provenance.json cannot be read"),
    ],
)
def test_reading_a_damaged_run(tmp_path, name, content, complaint):
    path = write_run(tmp_path)
    (path / name).write_bytes(content)
    with pytest.raises(BenchError, match=complaint) as caught:
        read(path)
    assert "\n" not in str(caught.value)


def test_reading_a_table_of_another_version(tmp_path):
    path = write_run(tmp_path)
    shutil.copy(path / "frames.parquet", path / "runs.parquet")
    with pytest.raises(BenchError, match="its columns are not those of this version"):
        read(path)
