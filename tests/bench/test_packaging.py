"""The lock files bind versions and nothing else; the set-up scripts and metadata agree with each other."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
LOCKS = ("requirements-run.lock", "requirements-dev.lock")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())


def blocks(lock: str) -> list[str]:
    """One text per requirement, its hashes with it."""
    text = (ROOT / lock).read_text().replace("\\\n", " ")
    return [line for line in text.splitlines() if line and not line.startswith("#")]


def name_of(requirement: str) -> str:
    return re.split(r"[ =<>;\[]", requirement, maxsplit=1)[0].lower().replace("_", "-")


@pytest.mark.parametrize("lock", LOCKS)
def test_every_requirement_is_pinned_and_hashed(lock):
    for block in blocks(lock):
        assert re.match(r"[\w.-]+==[\w.]+( ;[^-]*)? +(--hash=sha256:[0-9a-f]{64} *)+$", block), block[:80]


@pytest.mark.parametrize("lock", LOCKS)
def test_no_lock_holds_an_address_or_a_path(lock):
    text = (ROOT / lock).read_text()
    assert not re.search(
        r"https?:|file:|--index|--extra-index|--find-links|--trusted|(^|[\s=])/\w", text, re.M
    )


def test_the_locks_agree_and_cover_the_project():
    # without markers: what a tool needs everywhere, the product may need on one system alone
    run, dev = ({re.split("--hash|;", block)[0].strip() for block in blocks(lock)} for lock in LOCKS)
    assert run <= dev
    locked = {name_of(r) for r in run}
    groups = PROJECT["dependency-groups"]
    for requirement in (
        *PROJECT["project"]["dependencies"],
        *groups["build"],
        *PROJECT["build-system"]["requires"],
    ):
        assert name_of(requirement) in locked, requirement
    assert {name_of(r) for r in groups["dev"]} <= {name_of(r) for r in dev}


def test_every_room_is_packaged_contracted_and_typed():
    rooms = {p.parent.name for p in ROOT.glob("*/__init__.py")}
    assert set(PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]) == rooms
    assert set(PROJECT["tool"]["importlinter"]["root_packages"]) == rooms
    assert set(PROJECT["tool"]["mypy"]["packages"]) == rooms


def test_versions_agree():
    version = PROJECT["project"]["version"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == version
    assert citation["license"] == PROJECT["project"]["license"] == "Apache-2.0"
    assert f"## {version}" in (ROOT / "CHANGELOG.md").read_text()
    assert "Apache License" in (ROOT / "LICENSE").read_text()


def test_a_wheel_carries_studies_shaders_and_templates(tmp_path):
    from hatchling.builders.wheel import WheelBuilder

    wheel = next(WheelBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"]))
    listing = subprocess.run(
        [sys.executable, "-m", "zipfile", "-l", wheel], capture_output=True, text=True, check=True
    )
    packed = {line.split()[0] for line in listing.stdout.splitlines()[1:]}
    kinds = ("*.py", "*.yaml", "*.json", "*.onnx", "*.vert", "*.frag", "*.glsl", "*.j2", "*.css", "*.html")
    rooms = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
    tracked = subprocess.run(
        ["git", "ls-files", "--", *rooms], cwd=ROOT, capture_output=True, text=True, check=False
    )
    wanted = {f for f in tracked.stdout.splitlines() if any(Path(f).match(kind) for kind in kinds)}
    assert wanted <= packed
    assert {"bench/studies/quick.yaml", "renderers/shaders/mesh.vert"} <= packed
    assert not any(f.startswith(("tests/", "results/")) or f.endswith(".pyc") for f in packed)


def setup(*arguments: str, path: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the set-up script with commands of our own in front of the system's."""
    command = ["/bin/sh", str(ROOT / "tools/setup.sh"), *arguments]
    variables = {"PATH": f"{path}:/usr/bin:/bin", **environment}
    return subprocess.run(command, env=variables, capture_output=True, text=True, check=False)


def fake(folder: Path, name: str, script: str) -> None:
    folder.mkdir(exist_ok=True)
    (folder / name).write_text(f"#!/bin/sh\n{script}\n")
    (folder / name).chmod(0o755)


# answers every check and makes an empty folder for `-m venv --clear DIR`: ensurepip takes seconds
PYTHON = f'[ "$1" = -m ] && exec mkdir -p "$4/bin"; exec {sys.executable} "$@"'
OLD_PYTHONS = ("python3", "python3.11", "python3.12", "python3.13", "python3.14")


def test_no_fitting_python_is_one_line(tmp_path):
    for name in OLD_PYTHONS:
        fake(tmp_path / "bin", name, "exit 1")  # what the version check of an old Python answers
    done = setup("venv", str(tmp_path / "venv"), path=tmp_path / "bin")
    assert done.returncode == 2
    assert done.stderr == (
        "error: no Python 3.11 to 3.14 found; install one, or name it: make PYTHON=/path/to/python3 run\n"
    )
    assert not (tmp_path / "venv").exists()


def test_a_python_can_be_named(tmp_path):
    for name in OLD_PYTHONS:
        fake(tmp_path / "bin", name, "exit 1")
    fake(tmp_path / "own", "python", PYTHON)
    done = setup("venv", str(tmp_path / "venv"), path=tmp_path / "bin", PYTHON=str(tmp_path / "own/python"))
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "venv/bin").is_dir()


def python_without_ensurepip(folder: Path) -> None:
    """Debian's python3 without python3-venv: it runs, but has no ensurepip."""
    fake(folder, "python3", f'case "$2" in *ensurepip*) exit 1 ;; esac\n{PYTHON}')


def test_without_the_venv_package_and_without_rights_the_package_is_named(tmp_path):
    python_without_ensurepip(tmp_path / "bin")
    fake(tmp_path / "bin", "id", "echo 1000")
    fake(tmp_path / "bin", "sudo", "exit 1")
    done = setup("venv", str(tmp_path / "venv"), path=tmp_path / "bin")
    package = f"python{sys.version_info[0]}.{sys.version_info[1]}-venv"
    assert done.returncode == 2
    assert done.stderr == (
        f"error: python3 cannot create virtual environments; install {package} (apt-get install {package})\n"
    )


@pytest.mark.parametrize("root", [True, False])
def test_the_venv_package_is_installed_where_that_is_allowed(tmp_path, root):
    python_without_ensurepip(tmp_path / "bin")
    fake(tmp_path / "bin", "id", f"echo {0 if root else 1000}")
    fake(tmp_path / "bin", "sudo", 'echo sudo >> "$LOG"; [ "$1" = -n ] && exit 0; exec "$@"')
    fake(tmp_path / "bin", "apt-get", 'echo "$@" >> "$LOG"')
    log = tmp_path / "log"
    done = setup("venv", str(tmp_path / "venv"), path=tmp_path / "bin", LOG=str(log))
    assert done.returncode == 0, done.stderr
    calls = log.read_text().splitlines()
    assert ("sudo" in calls) == (not root)
    apt = [call for call in calls if call != "sudo"]
    assert apt[0].startswith("update")
    assert apt[1].endswith(f"python{sys.version_info[0]}.{sys.version_info[1]}-venv")


@pytest.fixture
def venv_without_libraries(tmp_path: Path) -> Path:
    """A venv whose Python cannot load the libraries named in $MISSING."""
    script = 'for library in $MISSING; do case "$2" in *"$library"*) exit 1 ;; esac; done'
    (tmp_path / "venv").mkdir()
    fake(tmp_path / "venv/bin", "python", script)
    fake(tmp_path / "bin", "id", "echo 1000")
    fake(tmp_path / "bin", "sudo", "exit 1")
    return tmp_path


@pytest.mark.parametrize(
    ("missing", "notice"),
    [
        ("", ""),
        (
            "libOSMesa",
            "notice: libosmesa6 is missing and could not be installed: the raycast engine is used instead\n",
        ),
        (
            "libGL.so libOSMesa",
            "notice: missing system libraries, without which Open3D may not load: "
            "apt-get install libosmesa6 libgl1\n",
        ),
    ],
)
def test_missing_libraries_never_stop_the_set_up(venv_without_libraries, missing, notice):
    folder = venv_without_libraries
    done = setup("libraries", str(folder / "venv"), path=folder / "bin", MISSING=missing)
    assert (done.returncode, done.stderr) == (0, notice)


def test_one_package_that_is_gone_keeps_no_other_out(venv_without_libraries):
    """Releases after Mesa 25.1 have no libosmesa6."""
    folder, log = venv_without_libraries, venv_without_libraries / "log"
    fake(folder / "bin", "id", "echo 0")
    fake(folder / "bin", "apt-get", 'echo "$@" >> "$LOG"; case "$*" in *osmesa*) exit 100 ;; esac')
    done = setup(
        "libraries", str(folder / "venv"), path=folder / "bin", MISSING="libOSMesa libidn2", LOG=str(log)
    )
    assert done.returncode == 0
    assert [call.split()[-1] for call in log.read_text().splitlines()][1:] == ["libosmesa6", "libidn2-0"]
    assert "notice: apt-get could not install libosmesa6" in done.stderr


# a make inside a make announces its folders
OUTSIDE_MAKE = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MAKELEVEL", "MFLAGS")}


def test_make_helps_by_default():
    done = subprocess.run(["make"], cwd=ROOT, env=OUTSIDE_MAKE, capture_output=True, text=True, check=True)
    targets = [line.split()[0] for line in done.stdout.splitlines()]
    assert targets == ["help", "setup", "run", "test", "lint", "lock", "clean"]


def test_ci_hands_over_the_data_and_runs_the_tests(tmp_path):
    (tmp_path / "repo/.ci").mkdir(parents=True)
    (tmp_path / "shared/data").mkdir(parents=True)
    (tmp_path / "repo/.ci/run").write_text((ROOT / ".ci/run").read_text())
    (tmp_path / "repo/Makefile").write_text("test:\n\t@echo $$BENCH_DATA\n")
    done = subprocess.run(
        ["sh", "repo/.ci/run"], cwd=tmp_path, env=OUTSIDE_MAKE, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip().splitlines()[-1] == str(tmp_path / "shared/data")
    assert os.access(ROOT / ".ci/run", os.X_OK)
