"""The names that studies and data sets may use: scenes, filters, studies, layouts, parts of the estimator."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import singledispatch
from itertools import product

from bench import study as study_files
from bench.errors import unknown_name
from bench.study import DlrStudy, DriveStudy, RenderedStudy, Study
from bench.study_model import BackendChoice


@dataclass(frozen=True)
class Entry:
    """A name and one line about it."""

    name: str
    summary: str


def scenes() -> list[Entry]:
    """The scenes of the library."""
    from scenes import library

    return [Entry(info.name, info.summary) for info in library.describe()]


def filters() -> list[Entry]:
    """The light filters, each with its source."""
    from vslam.filters import registry

    return [
        Entry(f.name, f"{f.summary} [{f.source}]" if f.source else f.summary) for f in registry.describe()
    ]


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


@singledispatch
def check(study: Study) -> None:
    """Refuse unknown names before anything is rendered.

    Raises
    ------
    BenchError, SceneError, RendererError, VslamError
        For a scene, lamp, illuminant, filter, back-end, association or observation form that does not exist,
        with near names.
    """
    raise TypeError(f"no check for studies of the kind {study.sequence!r}")


@check.register
def _(study: RenderedStudy) -> None:
    from bench.oracle import slam_settings

    if study.scene.file is None:
        _known("scene", [study.scene.name], (entry.name for entry in scenes()))
    _known("filter", [choice.name for choice in study.filters], (entry.name for entry in filters()))
    _try_parameters(study)
    _try_lights(study)
    slam_settings(study.slam)


@check.register
def _(study: DlrStudy) -> None:
    _try_backends(study.backends, product(study.associations, study.observations))


@check.register
def _(study: DriveStudy) -> None:
    _try_backends(study.backends, [("annotated", study.observation)])


def _try_backends(choices: Iterable[BackendChoice], forms: Iterable[tuple[str, str]]) -> None:
    """Build each back-end, so that a wrong name or parameter costs no run."""
    from vslam.slam import Slam, SlamSettings

    for choice, (association, observation) in product(choices, list(forms)):
        Slam(SlamSettings(choice.name, association, observation, parameters=choice.parameters))


def _try_parameters(study: RenderedStudy) -> None:
    """Build the filters whose parameters a study sets, so that a wrong one costs no rendering."""
    from vslam.filters import registry

    for choice in study.filters:
        if choice.parameters:
            registry.create(choice.name, **choice.parameters)


def _try_lights(study: RenderedStudy) -> None:
    """Build the scene and look its colours up, so that a wrong lamp or illuminant leaves no trace."""
    from bench.data import cache_folder
    from bench.sequences.lighting import light_colours

    light_colours(study, cache_folder())


def _known(kind: str, wanted: Iterable[str], known: Iterable[str]) -> None:
    existing = set(known)
    for name in wanted:
        if name not in existing:
            raise unknown_name(kind, name, existing)
