"""The page: one file, nothing loaded from elsewhere, the same bytes each time."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import pandas as pd
import pytest

from reports.html import build
from reports.inline import THEME
from reports.run import load

VOID = {"meta", "img", "br", "link", "input", "hr"}


class Reader(HTMLParser):
    """Collects addresses, ids and text, and checks that tags close."""

    def __init__(self) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.links: list[str] = []
        self.ids: list[str] = []
        self.tags: Counter[str] = Counter()
        self.open: list[str] = []
        self.text: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags[tag] += 1
        if tag not in VOID:
            self.open.append(tag)
        self._read(tag, attributes)

    def handle_startendtag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags[tag] += 1
        self._read(tag, attributes)

    def _read(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        for name, value in attributes:
            if name == "id":
                self.ids.append(value or "")
            elif name in {"src", "srcset", "data", "poster"} or (name.endswith("href") and tag != "a"):
                self.loads.append(value or "")
            elif name == "href":
                self.links.append(value or "")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text.append(data)


def read(page: Path) -> Reader:
    reader = Reader()
    reader.feed(page.read_text(encoding="utf-8"))
    assert reader.open == []
    return reader


@pytest.fixture(scope="module")
def page(rendered_run: Path) -> Path:
    return build(rendered_run)


def test_nothing_is_loaded_from_elsewhere(page: Path) -> None:
    reader = read(page)
    assert reader.loads
    assert all(a.startswith(("data:", "#")) for a in reader.loads)
    assert reader.tags["script"] == reader.tags["link"] == reader.tags["iframe"] == 0
    text = page.read_text(encoding="utf-8")
    assert not re.search(r"https?://|@import|url\((?!#)", text)


def test_each_filter_and_number_is_on_the_page(page: Path, rendered_run: Path) -> None:
    text = " ".join(read(page).text)
    saved = pd.read_csv(rendered_run / "figures" / "headline.csv")
    for name in load(rendered_run).filters:
        assert name in text
    for row in saved[saved["condition"] == "all illuminations"].query("metric == 'rmse'").itertuples():
        assert f"{row.value:.3f}" in text
    assert "did harm" in text and "all-negative mask" in text and "do nothing" in text


def test_links_lead_to_files_or_places_on_the_page(page: Path) -> None:
    reader = read(page)
    for link in reader.links:
        assert (link[1:] in reader.ids) if link.startswith("#") else (page.parent / link).is_file()
    figures = {Path(link).stem for link in reader.links if link.endswith(".svg")}
    assert len(figures) == 1 + 5 + 1  # effects, heat maps, map
    assert {f"figures/{name}.csv" for name in figures} <= set(reader.links)


def test_ids_are_unique_and_what_pictures_refer_to_exists(page: Path) -> None:
    reader = read(page)
    assert [i for i, n in Counter(reader.ids).items() if n > 1] == []
    text = page.read_text(encoding="utf-8")
    assert set(re.findall(r"url\(#([^)]+)\)", text)) <= set(reader.ids)


def test_pictures_follow_the_theme(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for variable in THEME.values():
        assert f"{variable[4:-1]}:" in text
    assert "prefers-color-scheme: dark" in text and "@media print" in text
    assert "fill: #ffffff" not in text and "DejaVu" not in text


def test_same_folder_same_bytes_and_nothing_left_aside(page: Path, rendered_run: Path) -> None:
    first = page.read_bytes()
    figures = {p.name: p.read_bytes() for p in (rendered_run / "figures").glob("*.*")}
    build(rendered_run)
    assert page.read_bytes() == first
    assert {p.name: p.read_bytes() for p in (rendered_run / "figures").glob("*.*")} == figures
    assert list(rendered_run.rglob("*.part")) == []
    assert len(first) < 8_000_000


def test_failures_have_a_section(rendered: Callable[..., Path]) -> None:
    text = " ".join(read(build(rendered(failed=(("seed", 0),), sun=(0.0,), strips=False))).text)
    assert "What failed" in text and "lost positive definiteness" in text and "2 of 16" in text


def test_text_from_the_run_is_escaped(rendered: Callable[..., Path]) -> None:
    folder = rendered(sun=(0.0,), bulb=(800.0,), strips=False)
    study = (folder / "study.yaml").read_text(encoding="utf-8")
    nasty = study.replace("A glossy corridor", "<script>alert(1)</script> & a corridor")
    (folder / "study.yaml").write_text(nasty, encoding="utf-8")
    assert read(build(folder)).tags["script"] == 0


def test_many_strips_keep_the_page_small(
    rendered: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    from reports import strips

    folder = rendered(sun=(0.0,), bulb=(800.0,))
    monkeypatch.setattr(strips, "BUDGET_BYTES", 20_000)
    reader = read(build(folder))
    assert 0 < reader.tags["img"] < 45
    assert "left out to keep the page small" in " ".join(reader.text)


def test_dlr_page(dlr_run: Path) -> None:
    reader = read(build(dlr_run))
    text = " ".join(reader.text)
    for word in ("1.473", "0.828", "0.13", "0.168", "60 % (332)", "Cramér", "no online estimator can reach"):
        assert word in text
    assert {p.stem for p in (dlr_run / "figures").glob("*.svg")} == {
        "dlr-squared-error",
        "dlr-coordinates",
        "dlr-mapped",
        "map--dlr",
    }
    assert all(a.startswith(("data:", "#")) for a in reader.loads)
