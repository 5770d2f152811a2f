import numpy as np
import pytest

from vslam.errors import VslamError
from vslam.frame import Observations, Odometry
from vslam.geometry import to_local
from vslam.motion import move
from vslam.slam import Slam, SlamSettings, run_slam

Q = np.diag([0.03, 0.02, 0.02]) ** 2
S = 0.02**2 * np.eye(2)
DELTA = np.array([0.3, 0.0, 0.1])


def drive(steps, seed=0):
    """Round a circle twice among well separated landmarks, with noise; ids and true poses known."""
    generator = np.random.default_rng(seed)
    around = np.linspace(0.0, 2 * np.pi, 12, endpoint=False)
    world = np.array([0.0, 3.0]) + 4.0 * np.column_stack([np.cos(around), np.sin(around)])
    pose, sequence, truth = np.zeros(3), [], []
    for _ in range(steps):
        pose = move(pose, DELTA)
        local = to_local(pose, world)
        near = np.flatnonzero((np.hypot(*local.T) < 4.0) & (local[:, 0] > 0.2))
        points = local[near] + generator.multivariate_normal(np.zeros(2), S, len(near))
        observations = Observations(points, np.tile(S, (len(near), 1, 1)), near)
        sequence.append((Odometry(generator.multivariate_normal(DELTA, Q), Q), observations))
        truth.append(pose)
    return sequence, np.array(truth), world


@pytest.mark.parametrize("observation", ["cartesian", "range_bearing"])
@pytest.mark.parametrize("association", ["annotated", "icnn"])
def test_maps_a_small_world(association, observation):
    sequence, truth, world = drive(130)
    result = run_slam(sequence, SlamSettings(association=association, observation=observation))
    errors = np.hypot(*(result.poses - truth)[:, :2].T)
    lost = [np.zeros(3)]
    for odometry, _ in sequence:
        lost.append(move(lost[-1], odometry.delta))
    assert errors.max() < 0.2 < 0.5 < np.hypot(*(np.array(lost[1:]) - truth)[:, :2].T).max()
    assert result.landmarks.shape == (12, 2) and result.landmark_covariances.shape == (12, 2, 2)
    assert result.poses.shape == (130, 3) and result.covariances.shape == (130, 3, 3)
    # Each landmark is one true one, and every match says so.
    number = {}
    for matches, (_, observations) in zip(result.matches, sequence, strict=True):
        for j, i in zip(matches.tolist(), observations.ids.tolist(), strict=True):
            assert j == -1 or number.setdefault(j, i) == i
    assert np.hypot(*(result.landmarks - world[[number[j] for j in range(12)]]).T).max() < 0.2


def test_step_by_step_is_the_same():
    sequence, _, _ = drive(40)
    settings = SlamSettings(association="icnn", observation="cartesian")
    whole, slam = run_slam(sequence, settings), Slam(settings)
    for k, (odometry, observations) in enumerate(sequence):
        np.testing.assert_array_equal(slam.step(odometry, observations), whole.matches[k])
        np.testing.assert_array_equal(slam.backend.pose, whole.poses[k])
    np.testing.assert_array_equal(slam.backend.landmarks, whole.landmarks)


def test_the_same_steps_give_the_same_bytes():
    sequence, _, _ = drive(40)
    one, other = (run_slam(sequence) for _ in range(2))
    assert one.poses.tobytes() == other.poses.tobytes()
    assert one.landmarks.tobytes() == other.landmarks.tobytes()


def test_the_default_is_the_dissertations_measurement_with_its_own_association():
    assert SlamSettings() == SlamSettings("ekf", "icnn", "range_bearing", 0.99, 0.9999)


def test_no_steps_no_poses():
    result = run_slam([])
    assert result.poses.shape == (0, 3) and result.landmarks.shape == (0, 2) and result.matches == ()


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda u, o: (Odometry(u.delta * np.nan, u.covariance), o), "step 5: the odometry .* not finite"),
        (
            lambda u, o: (Odometry(u.delta, -u.covariance), o),
            "step 5: the odometry covariance .* not positive",
        ),
        (lambda u, o: (u, Observations(o.points * np.inf, o.covariances, o.ids)), "step 5: .* not finite"),
        (lambda u, o: (u, Observations(o.points, -o.covariances, o.ids)), "step 5: .* not positive definite"),
        (lambda u, o: (u, Observations(o.points, o.covariances, o.ids * 0)), "step 5: .* occurs twice"),
    ],
)
def test_bad_input_names_the_step(spoil, message):
    sequence, _, _ = drive(8)
    sequence[5] = spoil(*sequence[5])
    with pytest.raises(VslamError, match=message) as caught:
        run_slam(sequence, SlamSettings(association="annotated"))
    assert "\n" not in str(caught.value)


def test_an_odometry_that_overflows_is_noticed():
    sequence, _, _ = drive(8)
    sequence[5] = (Odometry(np.array([1e200, 0.0, 0.0]), Q), Observations.none())
    with np.errstate(all="ignore"), pytest.raises(VslamError, match=r"step [567]: "):
        run_slam(sequence)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"backend": "ekv"}, "unknown SLAM back-end 'ekv': did you mean 'ekf'"),
        ({"association": "icn"}, "unknown association 'icn': did you mean 'icnn'"),
        ({"observation": "stereo"}, "unknown observation model 'stereo': known: cartesian, range_bearing"),
        ({"gate": 1.0}, "gates must be"),
        ({"gate": 0.99, "new_gate": 0.9}, "gates must be"),
    ],
)
def test_wrong_settings_are_refused(wrong, message):
    with pytest.raises(VslamError, match=message):
        SlamSettings(**wrong)
