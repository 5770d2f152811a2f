"""The replay of the real building log: every back-end with every association and observation form."""

from __future__ import annotations

from itertools import product

import numpy as np

from bench import replay
from bench.data import dlr_folder
from bench.metrics.cramer_rao import position_bound
from bench.options import RunOptions
from bench.progress import Progress
from bench.run_facts import RunFacts, landmark_csv, run_stem
from bench.score import Replay
from bench.sequences import dlr
from bench.sequences.drive import recorded
from bench.store import RunFolder
from bench.study_model import DlrStudy
from vslam.slam import SlamSettings


def run(study: DlrStudy, folder: RunFolder, options: RunOptions, progress: Progress) -> RunFacts:
    """Replay the log into a run folder; the frames table stays empty, as no picture is filtered.

    The log has no clock: its trajectories are stamped with the number of the step.
    """
    facts = RunFacts("none")
    log = dlr.load(dlr_folder(options.data))
    ways = list(product(study.backends, study.associations, study.observations))
    done: list[Replay] = []
    with facts.timed("replay"), progress.stage("replay", 1 + len(ways)) as advance:
        bound_m = position_bound(recorded(log))
        advance(1)
        for backend, association, observation in ways:
            settings = SlamSettings(
                backend.name,
                association,
                observation,
                study.gate,
                seed=study.seed,
                parameters=backend.parameters,
            )
            done += replay.replays(log, settings, backend.label, study.seed, bound_m)
            advance(1)
    write(folder, done)
    return facts


def write(folder: RunFolder, replays: list[Replay]) -> None:
    """Write rows, trajectories and landmarks of drives; a true track per scene and seed, named as such."""
    folder.write_frames([])
    folder.write_runs([result.row for result in replays])
    for scene, truth in {str(r.row["scene"]): r.truth for r in replays}.items():
        folder.write_trajectory(f"truth--{scene}", np.arange(len(truth), dtype=np.float64), truth)
    for result in replays:
        if result.row["status"] == "ok":
            stem = run_stem(result.row)
            folder.write_trajectory(stem, np.arange(len(result.poses), dtype=np.float64), result.poses)
            folder.write_text(f"figures/landmarks--{stem}.csv", landmark_csv(result.landmark_table))
