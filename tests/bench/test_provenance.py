"""Provenance says enough to repeat a run and nothing about who ran it."""

import getpass
import json
import socket
import subprocess
from pathlib import Path

import pytest

from bench import provenance


def git(folder: Path, *arguments: str) -> str:
    identity = ["-c", "user.name=nobody", "-c", "user.email=nobody@example.org"]
    command = ["git", "-C", str(folder), *identity, *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def test_it_holds_what_a_repeat_needs():
    facts = provenance.collect(
        seed=3, engine="raycast", command=["bench", "run"], seconds={"render": 1.23456}
    )
    assert json.loads(json.dumps(facts)) == facts
    assert (facts["seed"], facts["engine"], facts["seconds"]) == (3, "raycast", {"render": 1.235})
    assert facts["packages"].keys() == set(provenance.PACKAGES)
    assert facts["packages"]["numpy"][0].isdigit()
    assert facts["machine"]["cores"] >= 1
    assert 0.1 < facts["machine"]["memory_gb"] < 1e5


def test_neither_host_nor_home_is_in_it(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "alice-home"))
    command = ["bench", "run", "--data", str(tmp_path / "alice-home" / "dlr")]
    text = json.dumps(provenance.collect(seed=0, engine="none", command=command))
    assert "alice-home" not in text
    assert "~/dlr" in text
    names = [n for n in (socket.gethostname(), getpass.getuser()) if len(n) > 5]
    assert not any(name in text for name in names)


def test_a_command_can_be_pasted_back():
    assert provenance.collect(seed=0, engine="none", command=["bench", "a b"])["command"] == "bench 'a b'"


def test_the_commit_of_a_checkout(tmp_path):
    git(tmp_path, "init", "-q")
    (tmp_path / "file").write_text("one")
    git(tmp_path, "add", "file")
    git(tmp_path, "commit", "-q", "-m", "first")
    assert provenance.commit(tmp_path) == {"commit": git(tmp_path, "rev-parse", "HEAD"), "dirty": False}
    (tmp_path / "new").write_text("untracked files change nothing that runs")
    assert provenance.commit(tmp_path)["dirty"] is False
    (tmp_path / "file").write_text("two")
    assert provenance.commit(tmp_path)["dirty"] is True


def test_no_commit_for_an_installed_package_inside_another_checkout(tmp_path):
    git(tmp_path, "init", "-q")
    inside = tmp_path / "venv" / "site-packages"
    inside.mkdir(parents=True)
    assert provenance.commit(inside) is None


@pytest.mark.parametrize(("package", "found"), [("numpy", True), ("no-such-package-here", False)])
def test_versions(package, found):
    assert (provenance.version(package) != "not installed") == found
