"""The doctor finds what works here, and says what to do about what does not."""

from pathlib import Path

import pytest

from bench import cli, doctor, provenance


def by_name(checks: list[doctor.Check]) -> dict[str, doctor.Check]:
    return {check.name: check for check in checks}


def test_on_this_machine(capsys, tmp_path):
    """The real thing: an OSMesa context and a cast ray in processes of their own."""
    checks = by_name(doctor.examine(tmp_path))
    assert checks["ray caster"].status == "ok", checks["ray caster"].detail
    assert checks["OSMesa"].status in ("ok", "warn")
    assert ("OpenGL" in checks["OSMesa"].detail) == (checks["OSMesa"].status == "ok")
    assert checks["packages"].status == "ok"
    assert doctor.runnable(list(checks.values()))


def test_it_writes_nothing_and_takes_a_folder_that_is_not_there(tmp_path):
    assert doctor._disk(tmp_path / "not" / "yet").status == "ok"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("code", "works", "text"),
    [
        ("print('noise'); print('4.5 Mesa')", True, "4.5 Mesa"),
        ("raise OSError('libOSMesa.so.8: cannot open')", False, "libOSMesa.so.8: cannot open"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", False, "ended with -11"),
    ],
)
def test_what_a_subprocess_tells(code, works, text):
    outcome = doctor._in_subprocess(code)
    assert outcome.works == works
    assert outcome.text == text


def test_no_osmesa_is_no_obstacle_but_no_open3d_is(monkeypatch):
    monkeypatch.setattr(doctor, "_OSMESA", "raise OSError('no OSMesa')")
    monkeypatch.setattr(doctor, "_RAYCAST", "print('1.0')")
    caster, osmesa = doctor._engines()
    assert (caster.status, osmesa.status) == ("ok", "warn")
    assert "libosmesa6" in osmesa.detail
    monkeypatch.setattr(doctor, "_RAYCAST", "raise ImportError('libGL.so.1')")
    caster, _ = doctor._engines()
    assert caster.status == "fail"
    assert "libGL.so.1" in caster.detail
    assert not doctor.runnable([caster])


def test_a_small_machine_is_warned(monkeypatch):
    monkeypatch.setattr(provenance, "cores", lambda: 1)
    monkeypatch.setattr(provenance, "memory_bytes", lambda: 2_000_000_000)
    assert doctor._cores().status == doctor._memory().status == "warn"
    assert "--workers 1" in doctor._memory().detail


def test_a_missing_package_fails(monkeypatch):
    monkeypatch.setattr(provenance, "PACKAGES", ("numpy", "no-such-package-here"))
    check = doctor._packages()
    assert check.status == "fail"
    assert "no-such-package-here" in check.detail


def test_the_dlr_log(tmp_path):
    for name in ("map.circles", "truth.txt"):
        (tmp_path / name).write_text("")
    assert doctor._dlr(tmp_path) == doctor.Check("DLR log", "ok", str(tmp_path))
    missing = doctor._dlr(tmp_path / "nowhere")
    assert missing.status == "warn"
    assert "fetch dlr" in missing.detail


@pytest.mark.parametrize(("status", "code"), [("ok", 0), ("warn", 0), ("fail", 2)])
def test_the_exit_code(capsys, monkeypatch, status, code):
    check = doctor.Check("thing", status, "see [this] and that")
    monkeypatch.setattr(doctor, "examine", lambda out, data: [check])
    assert cli.execute(["doctor", "--out", str(Path("x"))]) == code
    assert capsys.readouterr().out.split() == [status, "thing", "see", "[this]", "and", "that"]
