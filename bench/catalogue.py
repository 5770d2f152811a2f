"""The names that studies and data sets may use: scenes, filters, studies, layouts, parts of the estimator."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import singledispatch
from itertools import product

from bench import study as study_files
from bench.backend_choice import BackendChoice
from bench.errors import unknown_name
from bench.study import BackendsStudy, DlrStudy, FiltersStudy, PairsStudy, RenderedStudy, Study
from bench.study_model import DlrLightStudy, DlrPicturesStudy
from vslam.filters.parameters import NO_DEFAULT, FilterParameter
from vslam.filters.registry import FilterDescription

WithFilters = RenderedStudy | PairsStudy | FiltersStudy | DlrPicturesStudy | DlrLightStudy


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
    from vslam.filters import registry

    if study.scene.file is None:
        _known("scene", [study.scene.name], (entry.name for entry in scenes()))
    _known("filter", _names_of(study), registry.names())
    _try_filters(study)
    _try_lights(study)
    slam_settings(study.slam)


@check.register
def _(study: FiltersStudy) -> None:
    from bench.light_levels import in_scene
    from vslam.filters import registry

    _known("scene", [s.name for s in study.scenes if s.file is None], (entry.name for entry in scenes()))
    _known("filter", _names_of(study), registry.names())
    _try_filters(study)
    for scene in study.scenes:
        _try_lights(in_scene(study, scene))


@check.register
def _(study: PairsStudy | DlrLightStudy) -> None:
    from vslam.filters import registry

    _known("filter", _names_of(study), registry.names())
    _try_filters(study)


@check.register
def _(study: DlrStudy) -> None:
    _try_backends(study.backends, product(study.associations, study.observations))


@check.register
def _(study: DlrPicturesStudy) -> None:
    from vslam.filters import registry

    _known("filter", _names_of(study), registry.names())
    _try_filters(study)
    for choice in study.slam:
        _try_backends([BackendChoice(name=choice.backend)], [(choice.association, choice.observation)])


@check.register
def _(study: BackendsStudy) -> None:
    _try_backends(study.backends, [("annotated", study.observation)])


def _try_backends(choices: Iterable[BackendChoice], forms: Iterable[tuple[str, str]]) -> None:
    """Build each back-end, so that a wrong name or parameter costs no run."""
    from vslam.slam import Slam, SlamSettings

    for choice, (association, observation) in product(choices, list(forms)):
        Slam(SlamSettings(choice.name, association, observation, parameters=choice.parameters))


def _names_of(study: WithFilters) -> list[str]:
    """Of the filters that are chosen by a registered name, not by class or file."""
    from vslam.filters import discovery

    chosen = [choice.name for choice in study.filters]
    return [name for name in chosen if not (discovery.is_class(name) or discovery.is_onnx(name))]


def _try_filters(study: WithFilters) -> None:
    """Build the filters that are not known by name alone, so that a wrong one costs no rendering."""
    from vslam.filters import registry

    for choice in study.filters:
        if choice.parameters or choice.name not in registry.names():
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
