# SPDX-License-Identifier: Apache-2.0
"""The attitude filter against one in NumPy with whole covariances, against its own statistics, and on a board."""

import numpy as np
import pytest
from scipy.stats import chi2

import mehvar
from mehvar.base.errors import MehvarError
from mehvar.models.parts import AttitudeFilter, Gyro, Hub, Spacecraft, StarTracker, Torquer
from mehvar.runtime.board.run import BoardRequest, run_on_board
from tests.tools import needs

NOISE, WALK, SIGMA, PERIOD, EVERY = 3e-5, 1e-6, (5e-5, 5e-5, 3e-4), 0.1, 10
START = {"roll_0": 0.8, "yaw_0": -0.5, "gyro_bias_x_0": 1e-3, "gyro_bias_y_0": -5e-4}


def rate_gyro(name="gyro", **options):
    return Gyro(name, **{"noise": NOISE, "walk": WALK, "integrating": True, **options})


def own_rate(**options):
    """Return a tracker with a rate of its own."""
    return StarTracker("tracker", sigma=SIGMA, every=EVERY, **options)


def craft_of(gyro=None, tracker=None, **options):
    craft = Spacecraft("eyes", motion="attitude", period=PERIOD)
    craft.add(Hub("hub", mass=40.0, inertia=(2.0, 3.0, 2.5)))
    turn = craft.add(Torquer("turn"))
    gyro = craft.add(gyro or rate_gyro())
    tracker = craft.add(tracker or StarTracker("tracker", sigma=SIGMA))
    every = {"every": EVERY} if tracker.steady else {}
    craft.add(AttitudeFilter("filter", gyro=gyro, tracker=tracker, **{**every, **options}))

    def steer(law):
        for shown in (*gyro.seen(), *tracker.seen(), *(() if tracker.steady else (tracker.new,))):
            law.update(law.keep(f"kept_{shown.name}", shown.unit), shown.symbol)
        kp, kd = law.parameter("kp", 0.8, "N m"), law.parameter("kd", 1.2, "N m s")
        (_, *q), w = law.attitude, law.rates
        return {turn.name: tuple(-kp * a - kd * b for a, b in zip(q, w, strict=True))}

    craft.law("steer", steer)
    return craft


@pytest.fixture(scope="module")
def model():
    return mehvar.build(craft_of())


@pytest.fixture(scope="module")
def losing():
    """A tracker that measures each second, and loses one picture in three."""
    return mehvar.build(craft_of(tracker=own_rate(dropout=0.3)))


def product(p, q):
    (a, *u), (b, *v) = p, q
    u, v = np.array(u), np.array(v)
    return np.array([a * b - u @ v, *(a * v + b * u + np.cross(u, v))])


def turn_by(angle):
    size = np.linalg.norm(angle)
    return np.array([np.cos(size / 2), *(np.sinc(size / 2 / np.pi) * angle / 2)])


def conjugate(q):
    return q * [1, -1, -1, -1]


def to_hub(q):
    """Return the matrix from inertial axes to those of the hub."""
    return np.array([product(product(conjugate(q), [0, *axis]), q)[1:] for axis in np.eye(3)]).T


NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)


def by_hand(gyro, tracker, new, attitude=0.1, bias=1e-3):
    """Return quaternion, bias and covariance after each sample: an error-state filter with angles about inertial axes.

    Source: Sola, Quaternion kinematics for the error-state Kalman filter, arXiv 1711.02508, with global angles; the
    covariance is whole, the transition integrated over the period, and the update is Joseph's for three angles at once.
    """
    q, b, P = np.array([1.0, 0, 0, 0]), np.zeros(3), np.diag([attitude**2] * 3 + [bias**2] * 3)
    white, walk = np.diag([NOISE**2 * PERIOD] * 3 + [0] * 3), np.diag([0] * 3 + [WALK**2 * PERIOD] * 3)
    for k, (g, s) in enumerate(zip(gyro, tracker, strict=True)):
        yield q, b, P
        turn, F = PERIOD * (g - b), np.eye(6)
        places = [to_hub(product(q, turn_by((1 + node) / 2 * turn))).T for node in NODES]
        F[:3, 3:] = -PERIOD / 2 * np.einsum("n,nij->ij", WEIGHTS, places)
        q = s if new[k] and not any(new[:k]) else product(q, turn_by(turn))
        P = F @ (P + walk) @ F.T + white
        if new[k]:
            off = product(conjugate(q), s)
            H = np.hstack([to_hub(q), np.zeros((3, 3))])
            K = P @ H.T @ np.linalg.inv(H @ P @ H.T + np.diag(np.square(SIGMA)))
            x = K @ (2 * off[1:] / off[0])
            P = (np.eye(6) - K @ H) @ P @ (np.eye(6) - K @ H).T + K @ np.diag(np.square(SIGMA)) @ K.T
            q = product([1, *(x[:3] / 2)], q)
            q, b = q / np.linalg.norm(q), b + x[3:]


def arrays(runs):
    return {str(name): series.values for name, series in runs.data_vars.items()}


def column(series, names, k):
    """Return what the memory has at instant k: a number for each name, for each run of a batch."""
    return np.stack([series[name][..., k] for name in names], axis=-1)


def covariance(series, k):
    """Return P = U D U' at instant k."""
    places = [(i, j) for i in range(6) for j in range(i + 1, 6)]
    D = column(series, [f"filter_D{i + 1}" for i in range(6)], k)
    U = np.zeros((*D.shape, 6)) + np.eye(6)
    for i, j in places:
        U[..., i, j] = series[f"filter_U{i + 1}{j + 1}"][..., k]
    return U * D[..., None, :] @ np.swapaxes(U, -1, -2)


QUATERNION, BIAS = [f"filter_q{k}" for k in range(4)], [f"filter_bias_{a}" for a in "xyz"]
MEAN = [f"gyro_mean_{a}" for a in "xyz"]


@pytest.mark.parametrize("name", [pytest.param("model", marks=pytest.mark.soak), "losing"])
def test_it_is_the_filter_of_the_textbook(name, request):
    """With factors, one angle after the other and rational turns; 1e-9 rad and rad/s over 600 samples of a slew."""
    run = arrays(mehvar.simulate(request.getfixturevalue(name), "steer", t_end=60.0, parameters=START))
    gyro = np.stack([run[f"kept_gyro_{a}"][1:] for a in "xyz"], axis=1)
    tracker = np.stack([run[f"kept_tracker_q{k}"][1:] for k in range(4)], axis=1)
    new = run["kept_tracker_new"][1:] > 0.5 if name == "losing" else np.arange(len(gyro)) % EVERY == 0
    assert 0.5 < new[::EVERY].mean() < 0.9 if name == "losing" else new[::EVERY].all()
    assert new.sum() == new[::EVERY].sum()
    for k, (q, b, P) in enumerate(by_hand(gyro, tracker, new)):
        ours, size = column(run, QUATERNION, k), np.sqrt(np.diag(P))
        np.testing.assert_allclose(ours / np.linalg.norm(ours), q, rtol=0, atol=1e-9)
        np.testing.assert_allclose(column(run, BIAS, k), b, rtol=0, atol=1e-9)
        np.testing.assert_allclose((covariance(run, k) - P) / np.outer(size, size), np.zeros((6, 6)), atol=1e-9)


def nees(series, k):
    """Return e' P^-1 e at instant k, for each run of a batch; the memory is of the sample before."""
    true, mean, seen = (column(series, n, k) for n in ([f"q{i}" for i in range(4)], MEAN, QUATERNION))
    biases = column(series, [f"gyro_bias_{a}" for a in "xyz"], k) - column(series, BIAS, k)
    result = []
    for q, w, seen_q, b, P in zip(true, mean, seen, biases, covariance(series, k), strict=True):
        off = product(product(q, turn_by(-PERIOD * w)), conjugate(seen_q))
        e = np.array([*(2 * off[1:] / off[0]), *b])
        result.append(e @ np.linalg.solve(P + np.diag([0] * 3 + [WALK**2 * PERIOD] * 3), e))
    return np.array(result)


DRAWN = {f"gyro_bias_{a}_0": "normal(0, 1e-3)" for a in "xyz"} | {f"{n}_0": "uniform(-1, 1)" for n in ("roll", "yaw")}


@pytest.mark.soak
def test_a_rate_of_the_tracker_is_a_rate_of_the_filter(model):
    """The same measurements are due, so the estimates are the same; the clock changes the last bits of a step."""
    other = mehvar.build(craft_of(tracker=own_rate()))
    ours, theirs = (arrays(mehvar.simulate(m, "steer", t_end=10.0, parameters=START)) for m in (model, other))
    for name in (*QUATERNION, *BIAS, "filter_D1", "filter_nis"):
        np.testing.assert_allclose(ours[name], theirs[name], rtol=1e-9, atol=1e-13)


TUMBLING = {f"w{a}_0": "uniform(-1.2, 1.2)" for a in "xyz"} | {f"gyro_bias_{a}_0": "normal(0, 1e-3)" for a in "xyz"}


def outside(model, n, seconds, **options):
    """Return how many means of NEES and NIS lie outside of their 95 % bands; runs count from their first picture on."""
    runs = arrays(mehvar.batch(model, "steer", n, t_end=60.0, save=seconds, **options))
    assert runs["filter_rejected"].max() == 0
    count = 0
    for size, values in ((6, lambda k: nees(runs, k)), (3, lambda k: runs["filter_nis"][:, k])):
        for k in range(1, runs["filter_nis"].shape[1]):
            shown = values(k)[runs["filter_count"][:, k] >= 0]
            low, high = chi2.ppf([0.025, 0.975], size * len(shown)) / len(shown)
            count += not low < shown.mean() < high
    return count


@pytest.mark.parametrize("name", [pytest.param("model", marks=pytest.mark.soak), "losing"])
def test_errors_of_a_tumble_are_as_large_as_it_says(name, request):
    """At up to 2 rad/s, 0.1 s from sample to sample; of ten means at most two are outside, which one in 90 are."""
    assert outside(request.getfixturevalue(name), 300, 12.0, vary=TUMBLING, kp=0.0, kd=0.0) <= 2


@pytest.mark.soak
@pytest.mark.parametrize("name", ["model", "losing"])
@pytest.mark.parametrize("options", [{"vary": DRAWN}, {"vary": TUMBLING, "kp": 0.0, "kd": 0.0}], ids=["slew", "tumble"])
def test_errors_and_innovations_are_as_large_as_it_says(name, options, request):
    """Means over 10 000 runs at 12 instants within 95 % bands: of 24 at most four outside, by chance one."""
    assert outside(request.getfixturevalue(name), 10_000, 5.0, **options) <= 4


def test_what_a_run_shows_is_the_error(model):
    run = mehvar.simulate(model, "steer", t_end=20.0, parameters=START)
    alone = arrays(run.expand_dims("run"))
    for k in (15, 150, 200):
        assert float(run["filter_nees"][k]) == pytest.approx(nees(alone, k)[0], rel=1e-6)


def test_a_filter_that_has_diverged_says_so(model):
    """A bias of 0.05 rad/s where 1e-5 is believed: the measurements are 0.05 rad off, and are rejected."""
    run = mehvar.simulate(model, "steer", t_end=20.0, gyro_bias_x_0=0.05, filter_bias=1e-5)
    assert float(run["filter_rejected"][-1]) > 15
    assert float(run["filter_nees"][-1]) > 1000
    assert "filter is lost" in run.attrs["exceeded"]
    assert "filter is lost" not in mehvar.simulate(model, "steer", t_end=20.0).attrs["exceeded"]


@needs("arm-none-eabi-gcc")
@pytest.mark.parametrize("name", [pytest.param("model", marks=pytest.mark.soak), "losing"])
def test_the_board_computes_the_same_bits(name, request):
    model = request.getfixturevalue(name)
    outcome = run_on_board(model, BoardRequest("steer", "unicorn", compiler="gcc", samples=60, profiled=False))
    assert (outcome.max_ulp, outcome.x.ulp) == (0, 0)
    assert outcome.z.compared > 30 * 60


def second(craft):
    craft.add(AttitudeFilter("other", gyro=craft.parts[2], tracker=craft.parts[3]))
    return craft.system()


def continuous(craft):
    craft.law(
        "own", lambda law: {"turn": tuple(-a * law.parameter("k", 1, "N m") for a in law.attitude[1:])}, sampled=False
    )
    return craft.system()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: craft_of(Gyro("gyro", noise=NOISE)), "filter: gyro.walk = None: must be given for a filter"),
        (lambda: craft_of(rate_gyro(integrating=False)), "filter: gyro.integrating = False: a filter needs"),
        (lambda: craft_of(tracker=StarTracker("t")), "filter: t.sigma = None: must be given for a filter"),
        (lambda: craft_of(rate_gyro(every=2)), "gyro integrates from sample to sample: leave out every"),
        (lambda: craft_of(tracker=own_rate(), every=5), "filter.every = 5: must be left out, tracker has its own rate"),
        (lambda: AttitudeFilter("f", gyro=1, tracker=2), "f.gyro = 1: must be a Gyro"),
        (lambda: craft_of(bias=0.0).system(), r"filter_bias = 0.0: must be a number in \(0, inf\)"),
        (lambda: second(craft_of()), r"the craft has several filters \(filter, other\): only one is allowed"),
        (
            lambda: continuous(craft_of()),
            "law own is continuous, but a filter needs a sampled law: leave out sampled=False",
        ),
    ],
)
def test_wrong_filters_are_refused(make, words):
    with pytest.raises(MehvarError, match=words):
        make()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"filter_every": 2.5}, "filter.every must be a whole number of samples"),
        ({"tracker_sigmay": 0.0}, "tracker.sigma must be above zero for filter"),
    ],
)
def test_wrong_numbers_are_refused(model, given, words):
    with pytest.raises(MehvarError, match=words):
        mehvar.simulate(model, "steer", t_end=1.0, **given)


def test_a_sensor_must_be_on_the_craft():
    craft = Spacecraft("bare", motion="attitude")
    craft.add(Hub("hub", mass=1.0, inertia=(1.0, 1.0, 1.0)))
    gyro, tracker = rate_gyro(), StarTracker("tracker", sigma=SIGMA)
    craft.add(AttitudeFilter("filter", gyro=craft.add(gyro), tracker=tracker))
    with pytest.raises(MehvarError, match="filter: tracker is not on the craft; add it too"):
        craft.system()
