"""The replay of the real building log: every back-end with every association and observation form."""

from __future__ import annotations

from itertools import product

import numpy as np

from bench import replay
from bench.backend_choice import BackendChoice
from bench.data import dlr_folder
from bench.kinds.dlr import DlrStudy
from bench.metrics.cramer_rao import position_bound
from bench.options import RunOptions
from bench.progress import Progress
from bench.run_facts import RunFacts, landmark_csv, run_stem
from bench.score import Replay
from bench.sequences import dlr
from bench.sequences.drive import recorded
from bench.store import RunFolder
from vslam.slam import SlamSettings, decides_over_drive

OWN_ESTIMATOR = "local_map"
"""Stands where a row has the back-end, for the estimator of `vslam.loop_closing`."""


def run(study: DlrStudy, folder: RunFolder, options: RunOptions, progress: Progress) -> RunFacts:
    """Replay the log into a run folder; the frames table stays empty, as no picture is filtered.

    The log has no clock: its trajectories are stamped with the number of the step.
    """
    facts = RunFacts("none")
    log = dlr.load(dlr_folder(options.data))
    ways = _ways(study)
    done: list[Replay] = []
    with facts.timed("replay"), progress.stage("replay", 1 + len(ways)) as advance:
        bound_m = position_bound(recorded(log))
        advance(1)
        for backend, label, association, observation in ways:
            settings = SlamSettings(
                backend.name,
                association,
                observation,
                study.gate,
                seed=study.seed,
                parameters=backend.parameters,
            )
            done += replay.replays(log, settings, label, study.seed, bound_m)
            advance(1)
    write(folder, done)
    return facts


def _ways(study: DlrStudy) -> list[tuple[BackendChoice, str, str, str]]:
    """Back-end with the label of its rows, association and observation form of each run.

    What pairs over the whole drive has an estimator of its own, so it runs once, under that one's name.
    """
    ways = []
    for association in study.associations:
        if decides_over_drive(association):
            ways.append((study.backends[0], OWN_ESTIMATOR, association, "cartesian"))
        else:
            forms = product(study.backends, study.observations)
            ways += [(backend, backend.label, association, form) for backend, form in forms]
    return ways


def write(folder: RunFolder, replays: list[Replay]) -> None:
    """Write rows, trajectories and landmarks of drives; a true track per scene and seed, named as such."""
    folder.write_frames([])
    folder.write_runs([result.row for result in replays])
    for scene, truth in {str(r.row["scene"]): r.truth for r in replays}.items():
        folder.write_trajectory(f"truth--{scene}", np.arange(len(truth), dtype=np.float64), truth)
    first = min((int(str(r.row["seed"])) for r in replays), default=0)
    for result in replays:
        if result.row["status"] == "ok":
            stem = run_stem(result.row)
            folder.write_trajectory(stem, np.arange(len(result.poses), dtype=np.float64), result.poses)
            folder.write_text(f"figures/landmarks--{stem}.csv", landmark_csv(result.landmark_table))
            if result.row["seed"] == first:
                folder.write_text(f"g2o/{stem}.g2o", result.graph)
