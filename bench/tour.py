"""One scene's tour through the whole chain: perceived frame by frame, localised variant by variant, kept."""

from __future__ import annotations

import functools
import pickle
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from bench.localisation import Localised, Variant, World, localise
from bench.metrics import navigation
from bench.perception import FramePercepts, Perception
from bench.progress import Progress
from bench.rng import generator
from bench.run_facts import RunFacts, landmark_csv, run_stem
from bench.sequences.lighting import load_scene
from bench.sequences.rendered import RenderedSequence, SequenceSetup
from bench.store import RunFolder
from bench.workers import Workers
from scenes.occupancy import TrueOccupancy, true_occupancy


@dataclass(frozen=True, eq=False)
class Toured:
    """What came of a tour under every illumination with every filter.

    Attributes
    ----------
    frame_rows : list of dict
        Rows of the frames table.
    localised : list of Localised
        Every SLAM run, variant by variant, seed by seed.
    """

    sequence: RenderedSequence
    occupancy: TrueOccupancy
    frame_rows: list[dict[str, object]]
    localised: list[Localised]

    @property
    def run_rows(self) -> list[dict[str, object]]:
        """Rows of the runs table."""
        return [run.row for run in self.localised]


def take(setup: SequenceSetup, pool: Workers, facts: RunFacts, progress: Progress) -> Toured:
    """Perceive a scene's tour, then localise every variant with every odometry seed."""
    sequence = RenderedSequence(setup)
    percepts = perceive(setup, pool, facts, progress)
    with facts.timed("localise"):
        occupancy = true_occupancy(sequence.scene, setup.study.navigation.resolution_m)
        localised = _localise(sequence, occupancy, percepts, pool, progress)
    return Toured(sequence, occupancy, [row for p in percepts for row in p.rows], localised)


def write(folder: RunFolder, toured: Toured) -> None:
    """The files of a scene beside the tables: tracks, landmarks, maps and the true occupancy."""
    scene, occupancy = toured.sequence.scene, toured.occupancy
    folder.write_trajectory(f"truth--{scene.name}", scene.tour.stamps, scene.tour.poses)
    for run in (run for run in toured.localised if run.row["status"] == "ok"):
        stem = run_stem(run.row)
        folder.write_trajectory(stem, scene.tour.stamps, run.poses)
        if run.row["seed"] == 0:
            folder.write_text(f"figures/landmarks--{stem}.csv", landmark_csv(run.landmark_table))
        if run.grid is not None:
            folder.write_map(stem, run.grid)
    np.savez_compressed(
        folder.path / "figures" / f"occupancy--{scene.name}.npz",
        blocked=occupancy.blocked,
        origin=occupancy.origin,
        resolution=occupancy.resolution,
    )


@functools.lru_cache(maxsize=1)
def perception(pickled_setup: bytes) -> Perception:
    """The perception of the process it is called in; made once, at its first frame."""
    setup: SequenceSetup = pickle.loads(pickled_setup)
    return Perception(RenderedSequence(setup), setup.engine)


def _perceive_frame(task: tuple[bytes, int]) -> FramePercepts:
    pickled_setup, frame = task
    return perception(pickled_setup).frame(frame)


def perceive(setup: SequenceSetup, pool: Workers, facts: RunFacts, progress: Progress) -> list[FramePercepts]:
    """Every frame of a tour, under every illumination with every filter."""
    pickled, percepts = pickle.dumps(setup), []
    frames = len(load_scene(setup.study).tour.stamps)
    with facts.timed("perceive"), progress.stage("perceive", frames) as advance:
        for result in pool.map(_perceive_frame, [(pickled, k) for k in range(frames)]):
            percepts.append(result)
            advance(1)
    return percepts


def _localise(
    sequence: RenderedSequence,
    occupancy: TrueOccupancy,
    percepts: list[FramePercepts],
    pool: Workers,
    progress: Progress,
) -> list[Localised]:
    variants = list(_variants(sequence, occupancy, percepts))
    done: list[Localised] = []
    with progress.stage("localise", len(variants) * sequence.study.seeds) as advance:
        for runs in pool.map(localise, variants):
            done += runs
            advance(len(runs))
    return done


def _variants(
    sequence: RenderedSequence, occupancy: TrueOccupancy, percepts: list[FramePercepts]
) -> Iterator[Variant]:
    study, world = sequence.study, _world(sequence, occupancy, percepts)
    for illumination in study.illuminations.grid():
        for choice in study.filters:
            own = tuple(p.percepts[illumination.name, choice.label] for p in percepts)
            yield Variant(study, world, illumination, choice.label, own)


def _world(sequence: RenderedSequence, occupancy: TrueOccupancy, percepts: list[FramePercepts]) -> World:
    study, scene = sequence.study, sequence.scene
    task = study.navigation
    x0, y0 = occupancy.origin
    rows, cols = occupancy.blocked.shape
    return World(
        scene=scene.name,
        poses=scene.tour.poses,
        landmarks=scene.landmark_positions,
        bounds=(x0, y0, x0 + cols * occupancy.resolution, y0 + rows * occupancy.resolution),
        scans=tuple(p.scan for p in percepts),
        navigation=navigation.prepare(
            occupancy.blocked,
            occupancy.origin,
            occupancy.resolution,
            task.robot_radius_m,
            generator(study.seed, "navigation"),
            task.pairs,
        ),
    )
