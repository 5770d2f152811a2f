"""Association ``oracle`` of rendered studies: pairings that no robot can know, as the best that any could do.

It lives here, as `vslam` knows no truth: its association ``annotated`` pairs by ids, and these are handed in.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from bench.robot_choice import SlamChoice
from vslam.frame import Observations
from vslam.slam import SlamSettings

if TYPE_CHECKING:
    from bench.perception import Percept

ORACLE = "oracle"


def slam_settings(choice: SlamChoice, seed: int = 0) -> SlamSettings:
    """The estimator that a study chooses, ``seed`` for whatever is random in it.

    Raises
    ------
    VslamError
        For an unknown back-end, association or observation form.
    """
    association = "annotated" if choice.association == ORACLE else choice.association
    return SlamSettings(choice.backend, association, choice.observation, choice.gate, seed=seed)


def observed(choice: SlamChoice, percept: Percept) -> Observations:
    """What the estimator is given of a picture: with ``oracle`` the true landmarks as ids, else none."""
    if choice.association != ORACLE:
        return percept.observations
    return replace(percept.observations, ids=percept.landmark)
