"""The command line: help with examples, light imports, one line and exit code 2 for user errors."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from bench import cli
from bench.commands import run as run_command
from bench.errors import BenchError
from bench.study import load, names

COMMANDS = ("run", "generate", "list", "doctor", "fetch", "report", "speed")
BAD_IES = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 50\n0 45 ninety\n0\n100 50 0\n"
HEAVY = ("open3d", "pyrender", "OpenGL", "colour", "matplotlib", "pandas", "pyarrow", "numba", "scipy", "cv2")


def bench(*arguments: str, **options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "bench", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The one line that a command line is refused with."""
    assert cli.execute(list(arguments)) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert re.fullmatch(r"error: [^\n]+\n", printed.err), printed.err
    return printed.err


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_helps_with_an_example(capsys, command):
    assert cli.execute([command, "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert f"Example: python -m bench {command}" in text


@pytest.mark.parametrize("arguments", [[], ["--help"], ["-h"]])
def test_the_program_helps(capsys, arguments):
    assert cli.execute(arguments) == 0
    text = capsys.readouterr().out
    assert all(command in text for command in COMMANDS)
    assert "Example: " in text


def imported(code: str) -> set[str]:
    """The heavy packages that a fresh interpreter holds after some code."""
    code += f"; import sys; print([m for m in {HEAVY} if m in sys.modules], file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(re.findall(r"'(\w+)'", done.stderr))


def test_help_imports_nothing_heavy():
    assert imported("import bench.cli; bench.cli.execute(['run', '--help'])") == set()


@pytest.mark.parametrize("kind", ["scenes", "filters", "studies", "layouts"])
def test_lists_import_neither_renderer_nor_compiler(kind):
    # nothing has to be compiled to name what exists; only the filters' times want the filters built
    # OpenCV and SciPy load in a fraction of a second; these take several
    slow = {"open3d", "pyrender", "OpenGL", "colour", "matplotlib", "pandas", "scipy", "numba"}
    assert (
        imported(f"import bench.cli; assert bench.cli.execute(['list', '{kind}', '--no-time']) == 0") & slow
        == set()
    )


@pytest.mark.parametrize(
    ("kind", "name"), [("scenes", "corridor"), ("filters", "none"), ("studies", "dlr"), ("layouts", "tum")]
)
def test_lists_name_what_exists_with_a_line_about_it(capsys, kind, name):
    assert cli.execute(["list", kind, "--no-time"]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if not line.startswith(" ")]
    assert any(re.match(rf"{name} +\S", line) for line in lines)
    assert lines == sorted(lines)


def test_a_filter_is_listed_with_all_that_a_user_chooses_by(capsys):
    """Paper, the picture it wants, its time on this machine, and each parameter with its default."""
    assert cli.execute(["list", "filters"]) == 0
    text = capsys.readouterr().out
    seed = text[text.index("\nseed ") : text.index("\nseed_per_pixel ")]
    assert "[dissertation, eqs. 3-2" in seed
    assert re.search(r"\n +wants sRGB, 8 bit; [0-9.e+]+ ms a frame at 320 × 240\n", seed)
    assert re.search(r"\n +patch: int = 15  Side of the dark channel's patch", seed)


@pytest.mark.parametrize(
    "kind",
    [
        "sequence: filters\nname: own\ncamera: {source: dlr}\n",
        "sequence: downstream\nname: own\ncamera: {source: dlr}\n",
        "sequence: backends\nname: own\nbackends: [ekf]\n"
        "drives: [{source: rendered, camera: {source: dlr}}]\n",
    ],
    ids=["filters", "downstream", "backends"],
)
def test_the_log_is_looked_for_where_data_says(capsys, tmp_path, monkeypatch, kind):
    """Also where the check before a run needs it: the robot's camera in scenes and drives of the library."""
    monkeypatch.setenv("BENCH_DATA", str(tmp_path / "elsewhere"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "mine.yaml").write_text(kind)
    found = complaint(capsys, "run", "--study", str(tmp_path / "mine.yaml"), "--data", "nowhere")
    assert "searched --data nowhere" in found and "elsewhere" not in found


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["run", "--study", "quik"], "unknown study 'quik': did you mean 'quick'?"),
        (["run", "--study", "nowhere.yaml"], "study file nowhere.yaml: not found"),
        (["run", "--bogus"], "--bogus"),
        (["run", "--engine", "fast"], "'fast' is not one of"),
        (["run", "--workers", "0"], "greater than or equal to 1; see python -m bench run --help"),
        (["run", "--seed", "-1"], "greater than or equal to 0"),
        (["run", "--study", "dlr", "--engine", "raycast"], "--engine: study 'dlr' renders nothing"),
        (["run", "--study", "dlr", "--stride", "2"], "--stride: study 'dlr' reads no recorded pictures"),
        (["run", "--study", "dlr_pictures", "--stride", "20"], "stride 20 takes only pictures that"),
        (["run", "--study", "dlr", "--data", "nowhere"], "searched --data nowhere"),
        (["generate"], "--out"),
        (["generate", "--out", "x", "--resume", "x"], "give one of --out DIR, --resume DIR and --verify DIR"),
        (["generate", "--verify", "nowhere"], "nowhere: not a data set"),
        (["generate", "--out", "x", "--layout", "exrs"], "unknown layout 'exrs': did you mean 'exr'"),
        (["generate", "--out", "x", "--study", "dlr"], "study 'dlr' is not of one rendered scene"),
        (["generate", "--out", "x", "--illumination", "sum0-bulb1"], "unknown illumination 'sum0-bulb1': "),
        (["list", "filter"], "'filter' is not one of"),
        (["fetch", "kitti"], "'kitti' is not one of"),
        (["report", "nowhere"], "nowhere"),
        (["rnu"], "rnu"),
    ],
)
def test_what_the_user_can_mend_is_one_line(capsys, tmp_path, monkeypatch, arguments, expected):
    monkeypatch.chdir(tmp_path)
    assert expected in complaint(capsys, *arguments)
    assert [p.name for p in tmp_path.rglob("*") if p.is_file()] == []


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("scene: {name: coridor}", "unknown scene 'coridor': did you mean 'corridor'?"),
        ("filters: [nnoe]", "unknown filter 'nnoe': did you mean 'none'?"),
        ("slam: {backend: efk}", "'efk': did you mean 'ekf' or 'riekf'?"),
        ("slam: {association: incn}", "'incn': did you mean 'icnn'?"),
        ("sensor: {fullwell_e: 1}", "sensor.fullwell_e: unknown key: did you mean 'full_well_e'"),
        ("illuminations: {sun_lux: [-1]}", "sun_lux.0: should be greater than or equal to 0, not -1\n"),
        ("illuminations: {bulb_lm: [.nan]}", "bulb_lm.0: should be a finite number, not nan\n"),
        ("illuminations: {sky_per_sun: -.inf}", "sky_per_sun: should be a finite number, not -inf"),
        ("illuminations: {bulb_lm: []}", "bulb_lm: should hold at least one entry, not []"),
        (
            "illuminations: {lamps: [{name: x, illuminant: FL22}]}",
            "mine.yaml: illuminations.lamps.0.illuminant: unknown illuminant 'FL22'; did you mean FL2,",
        ),
        (
            "illuminations: {sun_illuminant: D66}",
            "mine.yaml: illuminations.sun_illuminant: unknown illuminant 'D66'; did you mean D65",
        ),
        (
            "scene: {lamps: {illuminant: 100K}}",
            "mine.yaml: scene.lamps.illuminant: colour temperature 100 K: must lie",
        ),
        ("scene: {lamps: {ies: bad.ies}}", "bad.ies, line 5: 'ninety' is not a number (vertical angles)"),
        ("scene: {lamps: {ies: nowhere.ies}}", "nowhere.ies: cannot be read (No such file or directory)"),
        ("scene: {lamps: {spot: {inner_deg: 40, outer_deg: 20}}}", "spot: needs 0 ≤ inner < outer ≤ 180"),
        (
            "scene: {lamps: {ies: bad.ies, spot: {inner_deg: 1, outer_deg: 9}}}",
            "ies and spot both shape the light; leave one out",
        ),
        ("scene: {parameters: {laps: .nan}}", "length nan m not negative"),
        ("camera: {fov_deg: 400}", "camera.fov_deg: should be less than 360, not 400"),
        ("camera: {model: pinhole, fov_deg: 180}", "of a pinhole must lie above 0° and below 180°"),
        ("camera: {height_m: -1}", "camera.height_m: should be greater than 0, not -1"),
    ],
)
def test_a_study_is_refused_before_anything_is_rendered(capsys, tmp_path, monkeypatch, body, expected):
    monkeypatch.chdir(tmp_path)
    Path("bad.ies").write_text(BAD_IES)
    Path("mine.yaml").write_text(f"sequence: rendered\nname: mine\n{body}\n")
    assert expected in complaint(capsys, "run", "--study", "mine.yaml")
    assert not Path("results").exists()


def test_options_change_the_study_that_is_stored():
    quick = load("quick")
    changed = run_command._override(quick, run_command.EngineName.raycast, 42)
    assert (changed.engine, changed.seed) == ("raycast", 42)
    assert changed.model_copy(update={"engine": quick.engine, "seed": quick.seed}) == quick
    assert run_command._override(quick, None, None) == quick


def test_errors_of_every_room_are_one_line(capsys, monkeypatch):
    for error in cli.ROOM_ERRORS:

        def fail(error: type[Exception] = error) -> None:
            raise error("what,\nwhere and what to do")

        monkeypatch.setattr(cli, "app", lambda *_, fail=fail, **__: fail())
        assert complaint(capsys, "run") == "error: what, where and what to do\n"


@pytest.mark.parametrize(
    ("raised", "code"),
    [(KeyboardInterrupt, 130), (BenchError("no"), 2), (RuntimeError("a bug"), RuntimeError)],
)
def test_interrupts_and_bugs(capsys, monkeypatch, raised, code):
    def examine(*_: object) -> None:
        raise raised

    monkeypatch.setattr("bench.doctor.examine", examine)
    if code is RuntimeError:
        with pytest.raises(RuntimeError, match="a bug"):
            cli.execute(["doctor"])
    else:
        assert cli.execute(["doctor"]) == code
        assert capsys.readouterr().err == {130: "interrupted\n", 2: "error: no\n"}[code]


def test_as_a_program():
    done = bench("run", "--study", "quik")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "error: unknown study 'quik': did you mean 'quick'?\n"
    listed = [line.split()[0] for line in bench("list", "studies").stdout.splitlines() if line[:1].strip()]
    assert listed == sorted(names()) and "quick" in listed
