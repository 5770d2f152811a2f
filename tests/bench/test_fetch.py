"""Fetching against a real local server: verified or not there, and one line for every failure."""

import functools
import http.server
import os
import threading
from hashlib import sha256
from pathlib import Path

import pytest

from bench.data import cache_folder, dlr_folder
from bench.errors import BenchError
from bench.fetch import BASE_URL_VARIABLE, DLR_FILES, DLR_PICTURES, PictureSet, RemoteFile, fetch_dlr
from bench.progress import Silent

LOG, TRUTH = b"STEP e.0000 0 0 0 1 0 1 0 0 1\n", b"[0, 0, 0]\n"
FILES = (
    RemoteFile("map.circles", "log/map.circles", sha256(LOG).hexdigest()),
    RemoteFile("truth.txt", "track/truth.txt", sha256(TRUTH).hexdigest()),
)
NAMES = [f"dlr-spatial_cognition-e.{k:04d}.jpg" for k in range(5)]


class Handler(http.server.SimpleHTTPRequestHandler):
    """Serves a folder, counts requests, and can break off in the middle of a file."""

    asked: list[str] = []  # noqa: RUF012  # replaced for each server
    cut = ""

    def do_GET(self) -> None:
        self.asked.append(self.path)
        if self.cut and self.path.endswith(self.cut):
            self.send_response(200)
            self.send_header("Content-Length", "1000")
            self.end_headers()
            self.wfile.write(b"half")
            return
        super().do_GET()

    def log_message(self, *_: object) -> None:
        """Stay quiet."""


class Server:
    """A public source with the log, the track and five pictures."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name, content in (("log/map.circles", LOG), ("track/truth.txt", TRUTH)):
            (folder / name).parent.mkdir(parents=True)
            (folder / name).write_bytes(content)
        (folder / "pictures").mkdir()
        for name in NAMES:
            (folder / "pictures" / name).write_bytes(name.encode())
        self.handler = type("Counting", (Handler,), {"asked": []})
        self.http = http.server.ThreadingHTTPServer(
            ("127.0.0.1", 0), functools.partial(self.handler, directory=str(folder))
        )
        self.url = f"http://127.0.0.1:{self.http.server_port}"

    def pictures(self) -> PictureSet:
        lines = [f"{sha256(name.encode()).hexdigest()}  {name}\n" for name in NAMES]
        return PictureSet(len(NAMES), "pictures", sha256("".join(lines).encode()).hexdigest())


@pytest.fixture
def server(tmp_path):
    served = Server(tmp_path / "served")
    thread = threading.Thread(target=served.http.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True)
    thread.start()
    yield served
    served.http.shutdown()
    served.http.server_close()
    thread.join()


def fetch(server: Server, folder: Path, pictures: PictureSet | None = None) -> Path:
    return fetch_dlr(folder, Silent(), pictures, FILES, server.url)


def everything(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_the_log_and_the_track(server, tmp_path):
    folder = fetch(server, tmp_path / "deep" / "dlr")
    assert everything(folder) == {"map.circles": LOG, "truth.txt": TRUTH}


def test_a_second_fetch_asks_for_nothing(server, tmp_path):
    fetch(server, tmp_path / "dlr", server.pictures())
    server.handler.asked.clear()
    fetch(server, tmp_path / "dlr", server.pictures())
    assert server.handler.asked == []


def test_a_damaged_file_is_fetched_again(server, tmp_path):
    folder = fetch(server, tmp_path / "dlr")
    (folder / "truth.txt").write_bytes(b"damaged")
    fetch(server, folder)
    assert (folder / "truth.txt").read_bytes() == TRUTH


def test_a_file_that_is_not_the_one_pinned_is_refused(server, tmp_path):
    (server.folder / "track/truth.txt").write_bytes(b"[1, 1, 1]\n")
    with pytest.raises(
        BenchError, match=r"track/truth.txt: the file is not the one pinned .*; nothing was kept"
    ):
        fetch(server, tmp_path / "dlr")
    assert everything(tmp_path / "dlr") == {"map.circles": LOG}


def test_a_download_that_breaks_off_leaves_nothing(server, tmp_path):
    server.handler.cut = "map.circles"
    with pytest.raises(BenchError, match=r"log/map\.circles: ") as caught:
        fetch(server, tmp_path / "dlr")
    assert "\n" not in str(caught.value)
    assert everything(tmp_path / "dlr") == {}


def test_pictures_come_whole(server, tmp_path):
    folder = fetch(server, tmp_path / "dlr", server.pictures())
    assert sorted(p.name for p in (folder / "images").iterdir()) == NAMES
    assert not (folder / ".images.partial").exists()


def test_interrupted_pictures_go_on_where_they_stopped(server, tmp_path):
    server.handler.cut = NAMES[3]
    with pytest.raises(BenchError, match=NAMES[3]):
        fetch(server, tmp_path / "dlr", server.pictures())
    assert not (tmp_path / "dlr" / "images").exists()
    kept = {p.name for p in (tmp_path / "dlr" / ".images.partial").iterdir()}
    server.handler.cut = ""
    server.handler.asked.clear()
    fetch(server, tmp_path / "dlr", server.pictures())
    assert sorted(path.rsplit("/", 1)[1] for path in server.handler.asked) == sorted(set(NAMES) - kept)
    assert sorted(p.name for p in (tmp_path / "dlr" / "images").iterdir()) == NAMES


def test_one_wrong_picture_refuses_the_set(server, tmp_path):
    (server.folder / "pictures" / NAMES[2]).write_bytes(b"another")
    with pytest.raises(BenchError, match="are not those pinned; nothing was kept"):
        fetch(server, tmp_path / "dlr", server.pictures())
    assert everything(tmp_path / "dlr") == {"map.circles": LOG, "truth.txt": TRUTH}


def test_a_file_that_is_gone(server, tmp_path):
    (server.folder / "log/map.circles").unlink()
    with pytest.raises(BenchError, match=r"log/map.circles: the server answered 404"):
        fetch(server, tmp_path / "dlr")


def test_no_network(tmp_path):
    with pytest.raises(BenchError, match="no connection; check the network"):
        fetch_dlr(tmp_path, Silent(), None, FILES, "http://127.0.0.1:1")


def test_a_folder_that_cannot_be_written(server, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(BenchError, match="choose another with --to"):
        fetch(server, tmp_path / "file" / "dlr")


def test_the_address_can_come_from_the_environment(server, tmp_path, monkeypatch):
    monkeypatch.setenv(BASE_URL_VARIABLE, server.url + "/")
    assert everything(fetch_dlr(tmp_path / "dlr", Silent(), files=FILES)) == {
        "map.circles": LOG,
        "truth.txt": TRUTH,
    }


def test_the_pins_are_those_of_the_real_data(dlr_folder):
    for file in DLR_FILES:
        assert sha256((dlr_folder / file.name).read_bytes()).hexdigest() == file.sha256
    digest = sha256()
    pictures = DLR_PICTURES.files()
    for file in pictures:
        content = (dlr_folder / "images" / file.name).read_bytes()
        digest.update(f"{sha256(content).hexdigest()}  {file.name}\n".encode())
    assert digest.hexdigest() == DLR_PICTURES.sha256
    assert len(pictures) == len(os.listdir(dlr_folder / "images")) == 3297


def make_dlr(folder: Path) -> Path:
    folder.mkdir(parents=True)
    for name in ("map.circles", "truth.txt"):
        (folder / name).write_text("")
    return folder


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv("BENCH_DATA", raising=False)
    return cache_folder()


def test_places_are_searched_in_order(cache, tmp_path, monkeypatch):
    in_cache = make_dlr(cache / "dlr")
    assert dlr_folder() == in_cache
    shared = make_dlr(tmp_path / "shared" / "dlr")
    monkeypatch.setenv("BENCH_DATA", str(tmp_path / "shared"))
    assert dlr_folder() == shared
    given = make_dlr(tmp_path / "given")
    assert dlr_folder(given) == given
    assert dlr_folder(tmp_path / "shared") == shared


def test_an_explicit_folder_is_never_replaced_by_another(cache, tmp_path):
    make_dlr(cache / "dlr")
    with pytest.raises(BenchError, match=r"searched --data .*nowhere, --data .*nowhere/dlr; get it with"):
        dlr_folder(tmp_path / "nowhere")


def test_nowhere_names_all_three_places(cache, monkeypatch):
    with pytest.raises(BenchError) as caught:
        dlr_folder()
    for place in ("--data DIR", "$BENCH_DATA/dlr (not set)", str(cache / "dlr"), "python -m bench fetch dlr"):
        assert place in str(caught.value)
