"""The names that studies and data sets may use: scenes, filters, back-ends, layouts and the like."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product

from bench import study as study_files
from bench.errors import unknown_name
from bench.study import AnyStudy, DlrStudy, RenderedStudy


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


def check(study: AnyStudy) -> None:
    """Refuse unknown names before anything is rendered.

    Raises
    ------
    BenchError, SceneError, RendererError, VslamError
        For a scene, lamp, illuminant, filter, back-end, association or observation form that does not exist,
        with near names.
    """
    from vslam.slam import Slam, SlamSettings

    if isinstance(study, RenderedStudy):
        if study.scene.file is None:
            _known("scene", [study.scene.name], (entry.name for entry in scenes()))
        _known("filter", [choice.name for choice in study.filters], (entry.name for entry in filters()))
        _try_parameters(study)
        _try_lights(study)
        SlamSettings(study.slam.backend, study.slam.association, study.slam.observation, study.slam.gate)
        return
    if isinstance(study, DlrStudy):
        forms = list(product(study.associations, study.observations))
    else:
        forms = [("annotated", study.observation)]
    for backend, (association, observation) in product(study.backends, forms):
        # built, so that a wrong parameter costs no run
        Slam(SlamSettings(backend.name, association, observation, parameters=backend.parameters))


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
