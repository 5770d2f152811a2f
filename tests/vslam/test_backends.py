"""What every back-end has to do, and how far each may differ from the textbook filter."""

import numpy as np
import pytest

from tests.vslam.drives import Numbering, Q, S, circle, run
from vslam.errors import VslamError
from vslam.frame import Observations, Odometry
from vslam.geometry import to_local
from vslam.motion import move
from vslam.observation import observation_models
from vslam.slam import SlamSettings, run_slam
from vslam.slam_backend import NEW, backends, create

GAUSSIAN = ["ekf", "ekf_fej", "riekf", "ukf", "ckf", "srckf", "information"]
PARTICLES = ["fastslam1", "fastslam2"]
ALL = [*GAUSSIAN, *PARTICLES, "graph"]
FORMS = ["cartesian", "range_bearing"]


def model(form="cartesian"):
    return observation_models.get(form)()


def test_the_literature_is_there():
    assert set(ALL) <= set(backends.names())


def linear_drive(steps=25):
    """A robot that knows its heading and drives straight: motion and Cartesian measurement are linear."""
    generator = np.random.default_rng(2)
    still = np.diag([0.05**2, 0.03**2, 0.0])
    world = np.column_stack([np.linspace(1.0, 9.0, 8), generator.uniform(-2.0, 2.0, 8)])
    pose, drive = np.zeros(3), []
    for k in range(steps):
        ahead = 0.4 if k < 15 else -0.4  # back again: old landmarks come into view once more
        pose = move(pose, np.array([ahead, 0.0, 0.0]))
        local = to_local(pose, world)
        near = np.flatnonzero((local[:, 0] > 0.2) & (local[:, 0] < 3.5))
        points = local[near] + generator.multivariate_normal(np.zeros(2), S, len(near))
        delta = np.array([ahead, 0.0, 0.0]) + generator.multivariate_normal(np.zeros(3), still)
        drive.append((Odometry(delta, still), Observations(points, np.tile(S, (len(near), 1, 1)), near)))
    return drive


@pytest.mark.parametrize("name", GAUSSIAN[1:])
def test_all_gaussian_filters_are_one_where_everything_is_linear(name):
    ekf, other = (run(n, model(), linear_drive()) for n in ("ekf", name))
    # the information filter starts from a micrometre, not from zero
    close = 1e-7 if name == "information" else 1e-10
    np.testing.assert_allclose(other.pose, ekf.pose, atol=close)
    np.testing.assert_allclose(other.landmarks, ekf.landmarks, atol=close)
    np.testing.assert_allclose(other.covariance, ekf.covariance, atol=close)


def test_the_graph_is_the_filter_where_everything_is_linear():
    """A smoother's last pose is the filter's then; bearing and range are not linear, the smoothed form is."""
    drive = linear_drive()
    graph, ekf = run("graph", model(), drive), run("ekf", model(), drive)
    smoothed = graph.smooth()
    np.testing.assert_allclose(smoothed.poses[-1], ekf.pose, atol=1e-5)
    np.testing.assert_allclose(smoothed.landmarks, ekf.landmarks, atol=1e-5)
    np.testing.assert_allclose(graph.pose, ekf.pose, atol=0.01)


@pytest.mark.parametrize("name", PARTICLES)
def test_many_particles_are_the_filter_where_everything_is_linear(name):
    ekf, other = run("ekf", model(), linear_drive(8)), run(name, model(), linear_drive(8), particles=4000)
    # 4000 samples, of which resampling leaves fewer: a sixth of a standard deviation
    sigma = np.sqrt(ekf.covariance.diagonal())
    off = np.concatenate([other.pose - ekf.pose, (other.landmarks - ekf.landmarks).ravel()])
    assert np.all(np.abs(off)[[0, 1, *range(3, len(off))]] < 0.17 * sigma[[0, 1, *range(3, len(off))]])


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", [n for n in GAUSSIAN[1:] if n != "information"])
def test_one_step_differs_from_the_ekf_to_second_order(name, form):
    """Halving all standard deviations must divide the difference of the means by four or more."""
    truth = np.array([[2.0, 1.0], [2.5, -0.5], [1.5, 0.3]])
    differences = []
    for scale in (1.0, 0.5):
        drive = []
        for k in range(3):
            pose = np.array([0.3 * (k + 1), 0.0, 0.0])
            at = to_local(pose, truth) + scale * 0.01 * np.array([[1.0, -1.0], [-0.5, 1.0], [0.7, 0.4]])
            odometry = Odometry(
                np.array([0.3, 0.0, 0.0]) + scale * np.array([0.01, 0.02, 0.03]), scale**2 * Q
            )
            drive.append((odometry, Observations(at, np.tile(scale**2 * S, (3, 1, 1)), np.arange(3))))
        pair = [run(n, model(form), drive) for n in ("ekf", name)]
        differences.append(max(np.abs(pair[0].pose - pair[1].pose).max(), 1e-15))
    assert differences[0] < 0.02
    assert differences[1] < differences[0] / 3.6


@pytest.mark.parametrize("form", FORMS)
def test_the_information_filter_is_the_ekf(form):
    drive, *_ = circle(np.random.default_rng(1), steps=40, landmarks=60)
    ekf, other = run("ekf", model(form), drive), run("information", model(form), drive)
    np.testing.assert_allclose(other.pose, ekf.pose, atol=1e-6)
    np.testing.assert_allclose(other.covariance, ekf.covariance, atol=1e-7)
    np.testing.assert_allclose(other.landmark_covariances, ekf.landmark_covariances, atol=1e-7)
    np.testing.assert_allclose(other.cross_covariances, ekf.cross_covariances, atol=1e-7)


@pytest.mark.parametrize("form", FORMS)
def test_the_square_root_filter_is_the_cubature_filter(form):
    drive, *_ = circle(np.random.default_rng(3), steps=60, landmarks=80, per_picture=8)
    full, root = run("ckf", model(form), drive), run("srckf", model(form), drive)
    assert len(full.landmarks) > 40, "the factor must outgrow its first chunk"
    np.testing.assert_allclose(root.pose, full.pose, atol=1e-9)
    np.testing.assert_allclose(root.landmarks, full.landmarks, atol=1e-9)
    np.testing.assert_allclose(root.covariance, full.covariance, atol=1e-10)
    np.testing.assert_allclose(root.landmark_covariances, full.landmark_covariances, atol=1e-10)
    np.testing.assert_allclose(root.cross_covariances, full.cross_covariances, atol=1e-10)
    np.testing.assert_allclose(root._L, np.tril(root._L), atol=0)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ALL)
def test_all_follow_a_drive_round_a_circle(name, form):
    drive, truth, _ = circle(np.random.default_rng(5), steps=70, landmarks=25)
    lost = np.zeros(3)
    for odometry, _ in drive:
        lost = move(lost, odometry.delta)
    backend = run(name, model(form), drive)
    off = np.hypot(*(backend.pose - truth[-1])[:2])
    assert off < 0.25 < np.hypot(*(lost - truth[-1])[:2]) + 0.25
    assert abs(backend.pose[2] - truth[-1, 2]) < 0.15, "headings count turns"
    n = len(backend.landmarks)
    assert backend.landmark_covariances.shape == (n, 2, 2)
    assert backend.cross_covariances.shape == (n, 3, 2)
    assert backend.memory_bytes > 0
    joint = backend.joint_covariance(np.array([2, 0]))
    np.testing.assert_allclose(joint, joint.T, atol=1e-12)
    assert np.linalg.eigvalsh(joint)[0] > 0.0
    np.testing.assert_allclose(joint[:3, :3], backend.pose_covariance, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(joint[:3, 3:5], backend.cross_covariances[2], rtol=1e-6, atol=1e-10)
    np.testing.assert_allclose(joint[5:7, 5:7], backend.landmark_covariances[0], rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("name", GAUSSIAN)
def test_the_order_of_observations_does_not_matter(name):
    drive, *_ = circle(np.random.default_rng(4), steps=30, landmarks=20)
    generator = np.random.default_rng(0)
    shuffled = []
    for odometry, o in drive:
        order = generator.permutation(len(o))
        shuffled.append((odometry, Observations(o.points[order], o.covariances[order], o.ids[order])))
    one, other = run(name, model(), drive), run(name, model(), shuffled)
    # sigma points sit on the columns of a Cholesky factor, which knows an order: equal to third order there
    close = 2e-4 if name in ("ukf", "ckf", "srckf") else 1e-9
    np.testing.assert_allclose(one.pose, other.pose, atol=close)
    np.testing.assert_allclose(one.pose_covariance, other.pose_covariance, atol=close)
    by_x = [np.sort(e.landmarks[:, 0]) for e in (one, other)]
    np.testing.assert_allclose(by_x[0], by_x[1], atol=close)


@pytest.mark.parametrize("name", ["ekf", "ekf_fej", "riekf", "ukf", "ckf", "srckf"])
def test_covariance_stays_positive_over_many_steps(name):
    """10,000 for the fastest, 1,000 for the others: rounding errors must not add up."""
    laps = 40 if name == "ekf_fej" else 4
    drive, *_ = circle(np.random.default_rng(6), steps=250, landmarks=12, per_picture=2)
    backend, numbering = create(name, model(), 0, {}), Numbering()
    for odometry, observations in drive * laps:
        backend.predict(odometry)
        backend.update(observations, numbering(observations.ids))
    P = backend.covariance
    np.testing.assert_allclose(P, P.T, atol=1e-15)
    assert np.linalg.eigvalsh(P)[0] > 0.0
    assert np.isfinite(backend.pose).all()


@pytest.mark.parametrize("name", ALL)
def test_a_robot_that_cannot_slide_and_sees_nothing_is_no_trouble(name):
    backend = create(name, model(), 0, {})
    for _ in range(3):
        backend.predict(Odometry(np.array([0.5, 0.0, 0.1]), np.diag([1e-4, 0.0, 1e-6])))
        backend.update(Observations.none(), np.zeros(0, dtype=np.int64))
    assert np.isfinite(backend.pose).all() and np.isfinite(backend.pose_covariance).all()
    seen = Observations(np.array([[2.0, 0.5], [-1.5, 0.2]]), np.tile(S, (2, 1, 1)), np.array([0, 1]))
    np.testing.assert_array_equal(backend.update(seen, np.array([NEW, NEW])), [0, 1])
    # one of them behind the robot
    backend.update(seen, np.array([0, 1]))
    assert np.isfinite(backend.landmarks).all()


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda u, o: (Odometry(u.delta, -u.covariance), o), "odometry covariance .* not positive"),
        (lambda u, o: (Odometry(u.delta * np.nan, u.covariance), o), "not finite"),
        (lambda u, o: (u, Observations(o.points, -o.covariances, o.ids)), "not positive definite"),
        (lambda u, o: (u, Observations(o.points * np.inf, o.covariances, o.ids)), "not finite"),
        (lambda u, o: (u, Observations(o.points, o.covariances, o.ids * 0)), "occurs twice"),
    ],
)
def test_bad_input_is_one_line_and_never_nan(name, spoil, message):
    drive, *_ = circle(np.random.default_rng(8), steps=5, landmarks=20)
    drive[3] = spoil(*drive[3])
    with pytest.raises(VslamError, match=f"step 3: .*{message}") as caught:
        run_slam(drive, SlamSettings(name, "annotated", "cartesian"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ALL)
def test_a_landmark_cannot_be_matched_twice_in_a_picture(name):
    drive, *_ = circle(np.random.default_rng(8), steps=5, landmarks=20)
    backend = run(name, model(), drive)
    twice = Observations(np.ones((2, 2)), np.tile(S, (2, 1, 1)), np.array([0, 0]))
    with pytest.raises(VslamError, match="twice"):
        backend.update(twice, np.array([0, 0]))


@pytest.mark.parametrize("name", ALL)
def test_an_empty_stream_has_an_empty_result(name):
    result = run_slam([], SlamSettings(name, "annotated", "cartesian"))
    assert result.poses.shape == (0, 3) and result.landmarks.shape == (0, 2)
    assert result.smoothed is None


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("ekf", {"particles": 3}, "SLAM back-end 'ekf': .*particles"),
        ("fastslam1", {"particles": 1}, "1 particles"),
        ("fastslam1", {"particles": "many"}, "SLAM back-end 'fastslam1'"),
        ("graph", {"robust": "hubert"}, "unknown robust loss 'hubert': known: none, huber"),
        ("graph", {"relinearise": 0.0}, "relinearise must be positive"),
    ],
)
def test_parameters_must_fit(name, parameters, message):
    with pytest.raises(VslamError, match=message):
        create(name, model(), 0, parameters)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ["ekf", "ekf_fej"])
def test_jacobians_numerically(name, form):
    """H and G agree with finite differences where first and latest estimate coincide."""
    observe = model(form)
    backend = create(name, observe, 0, {})
    backend.predict(Odometry(np.array([0.4, 0.1, 0.3]), Q))
    seen = Observations(np.array([[2.0, 0.7]]), S[None], np.array([0]))
    z, _ = observe.measure(seen)
    pose, landmark = backend.pose, observe.g(backend.pose, z)
    G_R, G_z = backend._founding_jacobians(z, landmark)
    backend.update(seen, np.array([NEW]))
    H_R, H_L = backend._measurement_jacobians(np.array([0]))
    for got, f, x in (
        (G_R[0], lambda r: observe.g(r, z)[0], pose),
        (G_z[0], lambda v: observe.g(pose, v[None])[0], z[0]),
        (H_R[0], lambda r: observe.h(r, landmark)[0], pose),
        (H_L[0], lambda p: observe.h(pose, p[None])[0], landmark[0]),
    ):
        step = 1e-6 * np.eye(len(x))
        numeric = np.column_stack([(f(x + d) - f(x - d)) / 2e-6 for d in step])
        np.testing.assert_allclose(got, numeric, atol=1e-8)
