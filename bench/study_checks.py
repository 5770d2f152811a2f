"""What kinds of study check before anything is rendered: that the names they choose exist.

Each raises as `bench.study_model.Study.check` says.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import product
from typing import TYPE_CHECKING

from bench.backend_choice import BackendChoice
from bench.errors import unknown_name
from bench.filter_choice import FilterChoice
from bench.robot_choice import SlamChoice
from bench.scene_choice import SceneChoice

if TYPE_CHECKING:
    from bench.kinds.rendered import RenderedStudy


def scenes(choices: Iterable[SceneChoice]) -> None:
    """The scenes that are chosen by name, not by file, are in the library."""
    from scenes import library

    _known("scene", [choice.name for choice in choices if choice.file is None], library.names())


def filters(choices: Sequence[FilterChoice]) -> None:
    """Filters chosen by name are registered; whatever a name alone does not tell is built, as a try."""
    from vslam.filters import discovery, registry

    names = [choice.name for choice in choices]
    by_name = [name for name in names if not (discovery.is_class(name) or discovery.is_onnx(name))]
    _known("filter", by_name, registry.names())
    for choice in choices:
        if choice.parameters or choice.name not in registry.names():
            registry.create(choice.name, **choice.parameters)


def lights(study: RenderedStudy) -> None:
    """Build the scene and look its colours up, so that a wrong lamp or illuminant leaves no trace."""
    from bench.data import cache_folder
    from bench.sequences.lighting import light_colours

    light_colours(study, cache_folder())


def backends(choices: Iterable[BackendChoice], forms: Iterable[tuple[str, str]]) -> None:
    """Build each back-end with each association and observation form: a wrong parameter costs no run."""
    from vslam.slam import Slam, SlamSettings

    for choice, (association, observation) in product(choices, list(forms)):
        Slam(SlamSettings(choice.name, association, observation, parameters=choice.parameters))


def rendered_slam(choice: SlamChoice) -> None:
    """The estimator of a rendered study, whose association may be ``oracle``."""
    from bench.oracle import slam_settings

    slam_settings(choice)


def _known(kind: str, wanted: Iterable[str], known: Iterable[str]) -> None:
    existing = set(known)
    for name in wanted:
        if name not in existing:
            raise unknown_name(kind, name, existing)
