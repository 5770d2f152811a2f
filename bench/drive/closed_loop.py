"""One drive: a picture at the true pose, the robot's command, the true motion, and so on until it ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from bench.drive.episode import Episode
from bench.drive.world import TrueWorld
from bench.filter_choice import FilterChoice
from bench.illumination_grid import Illumination
from bench.kinds.drive import ClosedLoopStudy
from bench.metrics import detection
from bench.perception import make_filter, visible_landmarks
from bench.rng import generator
from bench.sequences.rendered import RenderedSequence, calibration
from renderers.basis import LightBasis
from renderers.truth import Recording
from scenes.occupancy import TrueOccupancy
from vslam.detect import DetectorSettings, DiscDetector
from vslam.errors import VslamError
from vslam.follower import FollowerSettings
from vslam.frame import Frame
from vslam.geometry import to_local
from vslam.missions import Explore, GoTo
from vslam.navigator import Navigator, NavigatorSettings, State
from vslam.occupancy import OccupancyGrid
from vslam.robot import Robot
from vslam.routes import RouteSettings
from vslam.slam import Slam, SlamSettings

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Moment:
    """What is true and what the robot believes when a picture is taken.

    Attributes
    ----------
    seconds : float
    true, believed : (3,) float64
        Poses.
    sigma_m : float
        Root of the trace of the believed position's covariance.
    explored : float
        Share of the free space, 0…1.
    visible, detected, detections_true : int
        Landmarks in view, detections, and how many of those show one.
    true_share : float
        Of the picture's pixels that light affects.
    """

    seconds: float
    true: FloatArray
    believed: FloatArray
    sigma_m: float
    explored: float
    visible: int
    detected: int
    detections_true: int
    true_share: float


@dataclass(frozen=True, eq=False)
class Drive:
    """How a drive went.

    Attributes
    ----------
    outcome : str
        "arrived", "explored", "lost", "collision", "stuck", "timeout" or "failed: reason".
    seconds, driven_m : float
        Robot time, and true length of the way.
    goal_errors_m : tuple of float
        True distance to each place at which the robot believed to be.
    moments : tuple of Moment
    replans, landmarks_mapped : int
    grid : OccupancyGrid
        The robot's map at the end.
    """

    outcome: str
    seconds: float
    driven_m: float
    goal_errors_m: tuple[float, ...]
    moments: tuple[Moment, ...]
    replans: int
    landmarks_mapped: int
    grid: OccupancyGrid


class ClosedLoop:
    """Drives episodes of a study under one illumination.

    Parameters
    ----------
    sequence : RenderedSequence
        Of the study, its scene lit by the layers that this illumination needs.
    observe : callable, optional
        Called with each frame, the recording and the robot, for whoever wants to look.
    """

    def __init__(
        self,
        sequence: RenderedSequence,
        occupancy: TrueOccupancy,
        illumination: Illumination,
        observe: Callable[[Frame, Recording, Robot], object] | None = None,
    ) -> None:
        assert isinstance(sequence.study, ClosedLoopStudy)
        self._study: ClosedLoopStudy = sequence.study
        self._sequence, self._occupancy, self._illumination = sequence, occupancy, illumination
        self._calibration, self._observe = calibration(self._study), observe
        discs = DetectorSettings(self._study.discs.min_radius_m, self._study.discs.max_radius_m)
        self._detect = DiscDetector(self._calibration, discs)

    def drive(self, episode: Episode, choice: FilterChoice) -> Drive:
        """Drive one episode with one light filter."""
        with threadpool_limits(limits=1, user_api="blas"):
            return _Drive(self, episode, choice).to_the_end()

    def robot(self, episode: Episode, choice: FilterChoice) -> Robot:
        """A robot that knows nothing yet."""
        study, place = self._study, self._occupancy
        radius, speed = study.navigation.robot_radius_m, study.tour.speed_mps
        settings = NavigatorSettings(
            RouteSettings(robot_radius_m=radius, margin_m=study.navigation.resolution_m),
            replace(FollowerSettings(), speed_mps=speed),
        )
        own = study.slam
        x0, y0 = place.origin
        rows, cols = place.blocked.shape
        bounds = (x0, y0, x0 + cols * place.resolution, y0 + rows * place.resolution)
        return Robot(
            make_filter(choice),
            self._detect,
            Slam(SlamSettings(own.backend, own.association, own.observation, own.gate)),
            self._calibration,
            OccupancyGrid.empty(bounds, study.navigation.resolution_m),
            Navigator(Explore() if episode.task == "explore" else GoTo(episode.places), settings),
            episode.believed_start,
        )


class _Drive:
    """The state of one drive."""

    def __init__(self, loop: ClosedLoop, episode: Episode, choice: FilterChoice) -> None:
        self._loop, self._episode = loop, episode
        self._study = study = loop._study
        stream = episode.number if episode.task == "goal" else 1_000_000 + episode.number
        self._stream = stream
        self.world = TrueWorld(study, loop._occupancy, episode.start, stream)
        self.robot = loop.robot(episode, choice)
        self._moments: list[Moment] = []
        self._errors: list[float] = []
        self._frame_s = study.tour.frame_interval_s
        if episode.task == "explore":
            self._limit_s = study.drive.explore_s
        else:
            self._limit_s = study.drive.patience * episode.optimum_m / study.tour.speed_mps

    def to_the_end(self) -> Drive:
        """Until the mission is done, given up or out of time, or the world or SLAM ends it."""
        outcome = "collision" if self.world.collided else ""
        while not outcome:
            try:
                self._look()
                outcome = self._verdict() or self._move()
            except VslamError as error:
                outcome = f"failed: {error}"
        robot = self.robot
        return Drive(
            outcome,
            len(self._moments) * self._frame_s,
            self.world.driven_m,
            tuple(self._errors),
            tuple(self._moments),
            robot.navigator.replans,
            len(robot.slam.backend.landmarks),
            robot.grid,
        )

    def _look(self) -> None:
        """Take a picture where the robot truly is, and let it see."""
        loop, k, seed = self._loop, len(self._moments), self._study.seed
        light, sequence = loop._illumination, loop._sequence
        seconds = k * self._frame_s
        basis = sequence.basis_at(self.world.pose)
        names = ("drive", self._episode.task, self._stream, k)
        recording = sequence.record_at(basis, light, seconds, generator(seed, "sensor", light.name, *names))
        depth = sequence.noisy_depth(basis, generator(seed, "depth", *names))
        frame = Frame(k, seconds, recording.image, depth, self.world.odometry())
        self.robot.see(frame)
        self._note(seconds, basis, recording)
        if loop._observe is not None:
            loop._observe(frame, recording, self.robot)

    def _move(self) -> str:
        """Drive until the next picture; what ends the drive, if anything does."""
        count = self._study.drive.commands_per_frame
        for _ in range(count):
            left = self.robot.navigator.mission.places_left
            command = self.robot.command()
            arrived = self.robot.navigator.mission.places_left < left
            if arrived and (outcome := self._judge_arrival()):
                return outcome
            self.robot.feel(self.world.apply(command, self._frame_s / count))
            if self.world.collided:
                return "collision"
        return ""

    def _judge_arrival(self) -> str:
        """The robot believes to be at its next place; the world knows."""
        place = self._episode.places[len(self._errors)]
        self._errors.append(float(np.linalg.norm(self.world.pose[:2] - place)))
        return "lost" if self._errors[-1] > self._study.drive.arrival_m else ""

    def _verdict(self) -> str:
        """What the robot itself says, and the clock."""
        state = self.robot.navigator.state
        if state is State.done:
            return "explored" if self._episode.task == "explore" else "arrived"
        if state is State.stuck:
            return "stuck"
        return "timeout" if len(self._moments) * self._frame_s >= self._limit_s else ""

    def _note(self, seconds: float, basis: LightBasis, recording: Recording) -> None:
        discs = to_local(self.world.pose, self._loop._sequence.scene.landmark_positions)
        visible = visible_landmarks(basis)
        found = detection.evaluate(self.robot.observations.points, discs[visible], discs)
        covariance = self.robot.slam.backend.pose_covariance
        moment = Moment(
            seconds,
            self.world.pose.copy(),
            self.robot.pose,
            float(np.sqrt(max(covariance[0, 0] + covariance[1, 1], 0.0))),
            self.world.explored(self.robot.grid),
            found.visible,
            found.detected,
            found.true,
            float(recording.highlight.mean()),
        )
        self._moments.append(moment)
