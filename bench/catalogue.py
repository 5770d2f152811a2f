"""The names that studies and data sets may use: scenes, filters, studies, layouts, back-ends."""

from __future__ import annotations

from dataclasses import dataclass

from bench import study as study_files
from vslam.filters.parameters import NO_DEFAULT, FilterParameter
from vslam.filters.registry import FilterDescription


@dataclass(frozen=True)
class Entry:
    """A name, one line about it, and further lines where there is more to say."""

    name: str
    summary: str
    details: tuple[str, ...] = ()


def scenes() -> list[Entry]:
    """The scenes of the library."""
    from scenes import library

    return [Entry(info.name, info.summary) for info in library.describe()]


def filters(timed: bool = False) -> list[Entry]:
    """The light filters, each with its source, the picture it wants and its parameters.

    With ``timed`` each is built and measured (`bench.filter_times`), which takes a few seconds.
    """
    from vslam.filters import registry

    return [
        Entry(
            f.name,
            f"{f.summary} [{f.source}]" if f.source else f.summary,
            (_needs(f, timed), *(_parameter(p) for p in f.parameters)),
        )
        for f in registry.describe()
    ]


def _needs(description: FilterDescription, timed: bool) -> str:
    wants = f"wants {description.wants.value}"
    if not timed:
        return wants
    from bench.filter_times import HEIGHT, WIDTH, milliseconds
    from vslam.errors import VslamError
    from vslam.filters import registry

    try:
        taken = milliseconds(registry.create(description.name))
        return f"{wants}; {taken:.2g} ms a frame at {WIDTH} × {HEIGHT}"
    except VslamError as error:
        return f"{wants}; not timed: {error}"


def _parameter(parameter: FilterParameter) -> str:
    typed = f"{parameter.name}: {parameter.type}" if parameter.type else parameter.name
    default = "" if parameter.default is NO_DEFAULT else f" = {parameter.default!r}"
    return f"{typed}{default}  {parameter.meaning}".rstrip()


def studies() -> list[Entry]:
    """The packaged studies."""
    return [Entry(name, study_files.load(name).title) for name in study_files.names()]


def backends() -> list[Entry]:
    """The SLAM back-ends, each with its first line."""
    from vslam.slam_backend import backends as known

    return [Entry(name, (known.get(name).__doc__ or "").strip().split("\n")[0]) for name in known.names()]


def layouts() -> list[Entry]:
    """The layouts of data sets."""
    from bench.datasets import layout

    return [Entry(name, known.summary) for name, known in layout.layouts().items()]
