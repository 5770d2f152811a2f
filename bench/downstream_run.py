"""A study of several scenes through the whole chain: each is toured as a rendered study's one scene is."""

from __future__ import annotations

from bench import tour
from bench.engine_choice import chosen_engine
from bench.kinds.downstream import DownstreamStudy
from bench.light_levels import in_scene
from bench.options import RunOptions
from bench.progress import Progress
from bench.rendered_run import for_workers, prepared
from bench.run_facts import RunFacts
from bench.store import RunFolder
from bench.workers import workers


def run(study: DownstreamStudy, folder: RunFolder, options: RunOptions, progress: Progress) -> RunFacts:
    """Tour the study's scenes one after another into a run folder."""
    facts = chosen_engine(study.engine, progress)
    frame_rows, run_rows = [], []
    with workers(options.workers) as pool:
        for scene in study.scenes:
            there = in_scene(study, scene, options.data)
            with prepared(there, facts.engine, facts, progress) as setup:
                toured = tour.take(for_workers(setup, options), pool, facts, progress)
            tour.write(folder, toured)
            frame_rows += toured.frame_rows
            run_rows += toured.run_rows
    folder.write_frames(frame_rows)
    folder.write_runs(run_rows)
    return facts
