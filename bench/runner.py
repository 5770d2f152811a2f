"""Runs a study, whatever its sequence, and leaves a run folder behind."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from bench import named_files, provenance
from bench.options import RunOptions
from bench.progress import Progress
from bench.run_facts import RunFacts
from bench.store import RunFolder
from bench.study import dump
from bench.study_model import Study


def run(
    study: Study,
    options: RunOptions,
    progress: Progress,
    report: Callable[[Path], object] | None = None,
) -> Path:
    """Run a study.

    Parameters
    ----------
    report : callable, optional
        Writes the report into the folder it is given, before the run gets its name: a run that has a name is
        whole.

    Returns
    -------
    Path
        The run's folder, ``<out>/<study>-<date>-<time>``.

    Raises
    ------
    BenchError, SceneError, RendererError, VslamError
        In one line; nothing is left behind then.
    """
    with RunFolder(options.out, study.name) as folder:
        folder.write_text("study.yaml", dump(study))
        files = named_files.sha256(study)  # before they can change
        facts = _run_of(study)(study, folder, options, progress)
        _write_provenance(folder, study, options, facts, files)
        if report is not None:
            with facts.timed("report"), progress.stage("report", 1) as advance:
                report(folder.path)
                advance(1)
            _write_provenance(folder, study, options, facts, files)
    return folder.path


def _run_of(study: Study) -> Callable[[Any, RunFolder, RunOptions, Progress], RunFacts]:
    """What runs this kind of study: ``run`` of the module that is named after its sequence."""
    run_it: Callable[[Any, RunFolder, RunOptions, Progress], RunFacts]
    run_it = importlib.import_module(f"bench.{study.sequence}_run").run
    return run_it


def _write_provenance(
    folder: RunFolder, study: Study, options: RunOptions, facts: RunFacts, files: Mapping[str, str]
) -> None:
    collected = provenance.collect(
        seed=study.seed, engine=facts.engine, command=options.command, seconds=facts.seconds, files=files
    )
    first: dict[str, object] = {"study": study.name, "engine_notice": facts.engine_notice}
    folder.write_json("provenance.json", first | collected)
