"""The command line. Commands import what they need when they run, so that ``--help`` answers at once."""

from __future__ import annotations

import errno
import sys

import typer
from typer.exceptions import TyperException

from bench.commands import doctor, fetch, generate, listing, preview, report, run, score, speed
from bench.errors import BenchError
from renderers.errors import RendererError
from reports.errors import ReportError
from scenes.errors import SceneError
from vslam.errors import VslamError

ROOM_ERRORS = (BenchError, RendererError, ReportError, SceneError, VslamError)
PROGRAM = "python -m bench"
USER_ERROR, INTERRUPTED = 2, 130

app = typer.Typer(
    help="Does a light filter help a visual SLAM robot, under which light, and at what cost?",
    epilog="Example: python -m bench run --study quick",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("run", epilog=run.EXAMPLE)(run.run)
app.command("generate", epilog=generate.EXAMPLE)(generate.generate)
app.command("preview", epilog=preview.EXAMPLE)(preview.preview)
app.command("list", epilog=listing.EXAMPLE)(listing.list_known)
app.command("doctor", epilog=doctor.EXAMPLE)(doctor.doctor)
app.command("fetch", epilog=fetch.EXAMPLE)(fetch.fetch)
app.command("report", epilog=report.EXAMPLE)(report.report)
app.command("score", epilog=score.EXAMPLE)(score.score)
app.command("speed", epilog=speed.EXAMPLE)(speed.speed)


@app.callback(invoke_without_command=True)
def _no_command(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def main() -> None:
    """Run the command line and exit; bugs keep a trace.

    0 done, 2 the user can mend it, 3 a run is whole but holds failures, 130 interrupted.
    """
    sys.exit(execute(sys.argv[1:]))


def execute(arguments: list[str]) -> int:
    """Run one command line.

    Parameters
    ----------
    arguments : list of str
        Without the program's name.

    Returns
    -------
    int
        The exit code. Whatever the user can mend is one line on standard error and 2.
    """
    try:
        code = app(arguments, prog_name=PROGRAM, standalone_mode=False)
    except TyperException as error:
        message = error.format_message().replace("Value error, ", "").rstrip(".")
        context = getattr(error, "ctx", None)  # of the command that was given something wrong
        return _complain(f"{message}; see {context.command_path if context else PROGRAM} --help")
    except ROOM_ERRORS as error:
        return _complain(str(error))
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        return _complain(f"{error.filename or 'disk'}: no room left on the disk; make room and run again")
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    if code == INTERRUPTED:
        typer.echo("interrupted", err=True)
    return code or 0


def _complain(message: str) -> int:
    typer.echo(f"error: {' '.join(message.split())}", err=True)
    return USER_ERROR
