"""One self-contained page per run: all inlined, written aside and renamed; beside it its tables."""

from __future__ import annotations

import os
from pathlib import Path

from reports import inline, markdown
from reports.errors import ReportError
from reports.kind import kind_of
from reports.page import Page
from reports.run import load
from reports.strips import PICTURES
from reports.wording import number

TEMPLATES = Path(__file__).parent / "templates"


def build(run_dir: Path) -> Path:
    """Write ``report.html`` and ``tables.md`` into a run folder, and figures with data below ``figures/``.

    The same run folder gives the same bytes.

    Parameters
    ----------
    run_dir : Path
        A folder that ``python -m bench run`` wrote.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    ReportError
        Something in the folder is missing or damaged, or it cannot be written.
    """
    run = load(run_dir)
    page = kind_of(run.sequence).compose(run)
    _write(run_dir / "tables.md", markdown.render(page))
    return _write(run_dir / "report.html", render(page))


def _write(target: Path, text: str) -> Path:
    aside = target.with_name(f"{target.name}.part")
    try:
        aside.write_text(text, encoding="utf-8", newline="\n")
        os.replace(aside, target)
    except OSError as error:
        raise ReportError(f"cannot write {target} ({error.strerror}): free or unlock the folder") from error
    return target


def render(page: Page) -> str:
    """The page as HTML."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["png"] = inline.png
    environment.filters["svg"] = lambda path: Markup(inline.svg(path))
    environment.filters["number"] = number
    style = Markup((TEMPLATES / "page.css").read_text(encoding="utf-8"))
    return environment.get_template("page.html.j2").render(page=page, style=style, pictures=PICTURES)
