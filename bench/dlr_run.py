"""The replay of the real building log: every association with every observation form."""

from __future__ import annotations

from itertools import product

import numpy as np

from bench import replay
from bench.data import dlr_folder
from bench.options import RunOptions
from bench.progress import Progress
from bench.run_facts import RunFacts, landmark_csv, run_stem
from bench.sequences import dlr
from bench.store import RunFolder
from bench.study_model import DlrStudy
from vslam.slam import SlamSettings


def run(study: DlrStudy, folder: RunFolder, options: RunOptions, progress: Progress) -> RunFacts:
    """Replay the log into a run folder; the frames table stays empty, as no picture is filtered.

    The log has no clock: its trajectories are stamped with the number of the step.
    """
    facts = RunFacts("none")
    log = dlr.load(dlr_folder(options.data))
    pairs = list(product(study.associations, study.observations))
    replays = []
    with facts.timed("replay"), progress.stage("replay", len(pairs)) as advance:
        for association, observation in pairs:
            settings = SlamSettings(study.backend, association, observation, study.gate)
            replays.append(replay.replay(log, settings, study.seed))
            advance(1)
    stamps = np.arange(len(log.steps), dtype=np.float64)
    folder.write_frames([])
    folder.write_runs([result.row for result in replays])
    folder.write_trajectory("truth--dlr", stamps, log.truth[1:])
    for result in replays:
        if result.row["status"] == "ok":
            stem = run_stem(result.row)
            folder.write_trajectory(stem, stamps, result.poses)
            folder.write_text(f"figures/landmarks--{stem}.csv", landmark_csv(result.landmark_table))
    return facts
