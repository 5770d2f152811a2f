"""Small drives that several tests of the back-ends share."""

import numpy as np

from vslam.frame import Observations, Odometry
from vslam.geometry import to_local
from vslam.motion import move
from vslam.slam_backend import NEW, create

S = np.diag([0.03, 0.02]) ** 2
Q = np.diag([0.03, 0.02, 0.02]) ** 2
RANGE_M = 4.0


def circle(generator, steps, landmarks, per_picture=5, Q=Q, S=S, delta=(0.3, 0.0, 0.1)):
    """A noisy drive round a circle: (odometry, observations) of each step, true poses and landmarks."""
    delta = np.array(delta)
    world = np.array([0.0, 3.0]) + generator.uniform(-5.0, 5.0, (landmarks, 2))
    pose, drive, truth = np.zeros(3), [], []
    for _ in range(steps):
        pose = move(pose, delta)
        local = to_local(pose, world)
        near = np.flatnonzero((np.hypot(*local.T) < RANGE_M) & (local[:, 0] > 0.3))[:per_picture]
        points = local[near] + generator.multivariate_normal(np.zeros(2), S, len(near))
        seen = Observations(points, np.tile(S, (len(near), 1, 1)), near)
        drive.append((Odometry(generator.multivariate_normal(delta, Q), Q), seen))
        truth.append(pose)
    return drive, np.array(truth), world


class Numbering:
    """Landmark numbers by id, in the order of first sight."""

    def __init__(self):
        self.known = {}

    def __call__(self, ids):
        before = len(self.known)
        numbers = [self.known.setdefault(i, len(self.known)) for i in ids.tolist()]
        return np.array([j if j < before else NEW for j in numbers], dtype=np.int64)


def run(name, model, drive, seed=0, **parameters):
    """The back-end after a drive with known landmarks."""
    backend, numbering = create(name, model, seed, parameters), Numbering()
    for odometry, observations in drive:
        backend.predict(odometry)
        backend.update(observations, numbering(observations.ids))
    return backend
