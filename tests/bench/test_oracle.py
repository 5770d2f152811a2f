import numpy as np
import pytest

from bench.dlr_run import OWN_ESTIMATOR, _ways
from bench.oracle import observed, slam_settings
from bench.perception import Percept
from bench.robot_choice import SlamChoice
from bench.study import load
from vslam.errors import VslamError
from vslam.frame import Observations, Odometry
from vslam.slam import run_slam

POINTS = np.array([[2.0, 0.5], [1.0, -0.5], [3.0, 0.0]])
PERCEPT = Percept(
    Observations(POINTS, np.tile(1e-4 * np.eye(2), (3, 1, 1)), np.full(3, -1)), landmark=np.array([7, -1, 2])
)


def test_the_oracle_hands_in_the_truth_and_nothing_else_does():
    told = observed(SlamChoice(association="oracle"), PERCEPT)
    assert told.ids.tolist() == [7, -1, 2] and told.points is POINTS
    assert observed(SlamChoice(association="icnn"), PERCEPT).ids.tolist() == [-1, -1, -1]


def test_what_the_oracle_pairs_is_right_and_false_detections_are_dropped():
    choice = SlamChoice(association="oracle", observation="cartesian")
    still = Odometry(np.zeros(3), 1e-6 * np.eye(3))
    steps = [(still, observed(choice, PERCEPT))] * 2
    assert [m.tolist() for m in run_slam(steps, slam_settings(choice)).matches] == [[0, -1, 1]] * 2


def test_an_unknown_association_is_refused_with_near_names():
    with pytest.raises(VslamError, match="unknown association 'jcb': did you mean 'jcbb'"):
        slam_settings(SlamChoice(association="jcb"))


def test_what_pairs_over_the_whole_drive_is_replayed_once():
    ways = _ways(load("dlr"))
    assert len(ways) == 3 * 2 + 1
    assert [way[1:] for way in ways if way[2] == "constellation"] == [
        (OWN_ESTIMATOR, "constellation", "cartesian")
    ]
