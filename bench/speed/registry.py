"""The benchmarks by name. A benchmark is one module of this folder with a ``BENCHMARK``."""

from __future__ import annotations

import importlib
import pkgutil

import bench.speed
from bench.errors import unknown_name
from bench.speed.model import Benchmark


def benchmarks() -> dict[str, Benchmark]:
    """All benchmarks, sorted by name."""
    modules = (
        importlib.import_module(f"bench.speed.{m.name}") for m in pkgutil.iter_modules(bench.speed.__path__)
    )
    found = [module.BENCHMARK for module in modules if hasattr(module, "BENCHMARK")]
    return {b.name: b for b in sorted(found, key=lambda b: b.name)}


def choose(names: list[str]) -> list[Benchmark]:
    """The named benchmarks, or all.

    Raises
    ------
    BenchError
        For a name that no benchmark has, with near names.
    """
    known = benchmarks()
    for name in names:
        if name not in known:
            raise unknown_name("benchmark", name, known)
    return [known[name] for name in dict.fromkeys(names)] or list(known.values())
