"""What every study has, and the models of all kinds of study.

Unknown keys are refused. Units are in the names: ``_m`` metres, ``_deg`` degrees, ``_s`` seconds, ``_e``
electrons.
"""

from __future__ import annotations

import importlib
import pkgutil
from abc import abstractmethod
from functools import cache
from pathlib import Path

from pydantic import Field

from bench.study_parts import Name, Part


class Study(Part):
    """A study of any kind.

    The key ``sequence`` names its kind, and with it the module of `bench.kinds` that has its model,
    ``bench/<kind>_run.py``, which runs it, and ``reports/page_<kind>.py``, which tells of it.
    """

    sequence: str
    name: Name
    title: str = ""
    description: str = ""
    seed: int = Field(0, ge=0)

    @abstractmethod
    def check(self, data: Path | None = None) -> None:
        """Refuse unknown names before anything is rendered.

        Parameters
        ----------
        data : Path, optional
            What ``--data`` names, for a scene or camera that comes out of the log.

        Raises
        ------
        BenchError, SceneError, RendererError, VslamError
            For a scene, lamp, illuminant, filter, back-end, association or observation form that does not
            exist, with near names.
        """

    @abstractmethod
    def reads_data(self) -> bool:
        """Whether it takes anything from the data that ``--data`` names."""


@cache
def models() -> dict[str, type[Study]]:
    """The models of all kinds by the value of ``sequence``: ``MODEL`` of each module of `bench.kinds`."""
    from bench import kinds

    names = sorted(module.name for module in pkgutil.iter_modules(kinds.__path__))
    return {name: importlib.import_module(f"{kinds.__name__}.{name}").MODEL for name in names}
