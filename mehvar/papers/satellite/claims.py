# SPDX-License-Identifier: Apache-2.0
"""What the satellite's paper claims, each checked by running the model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import expm

from mehvar.papers.satellite.rows import AXES, LATE, measure, row_claims
from mehvar.papers.study import Check, Claim, Runs, about, below, beside
from mehvar.runtime.run.problem import Status

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from mehvar.runtime.run.simulate import Run

    FloatArray = NDArray[np.float64]

PRINTED_B = ((0.307, 0.0586), (0.305, 0.0411), (0.302, 0.0404))
"""b0 and b1 of roll, pitch and yaw as (43)-(45) print them, rad/(N m)."""
_RPM = 30 / np.pi


def claims(runs: Runs) -> list[Claim]:
    """Return what became of the paper's claims and of the rows of the metric table.

    Parameters
    ----------
    runs : Runs
        Of the satellite.

    Returns
    -------
    list of Claim
        Numbered 1 to 13, and R1 to R18 for the rows.
    """
    return [
        _follows_model(runs),
        _bears_delay(runs),
        _pd_does_not_track(runs),
        _pd_needs_less_torque(runs),
        _printed_guess(runs),
        _single_precision(runs),
        _delay_must_be_known(runs),
        _literal_rings(runs),
        _literal_is_lost(runs),
        _literal_controls(runs),
        _linear_model(runs),
        _sampled_model(runs),
        _wheels(runs),
        *row_claims(runs),
    ]


def _each_below(what: str, bound: float, values: FloatArray, unit: str = "deg") -> Check:
    """Return the check that the numbers of all three axes are below a bound."""
    return Check(what, f"< {bound:g} {unit}".strip(), _three(values, unit), bool((values < bound).all()))


def _each_above(what: str, bound: float, values: FloatArray, unit: str = "") -> Check:
    return Check(what, f"> {bound:g} {unit}".strip(), _three(values, unit), bool((values > bound).all()))


def _three(values: FloatArray, unit: str) -> str:
    return f"{' / '.join(f'{v:.3g}' for v in values)} {unit}".strip()


def _ends(run: Run) -> Check:
    return Check("the run", "reaches its end", run.reason, run.status is Status.DONE)


def _lost(what: str, expected: float, run: Run) -> tuple[Check, Check]:
    """Return the checks that a run is lost and when."""
    fate = Check(what, "lost", "lost" if run.status is Status.LIMIT else run.reason, run.status is Status.LIMIT)
    return fate, about(f"{what}: time", expected, run.t_stop, "s", 0.02)


def _follows_model(runs: Runs) -> Claim:
    run = runs("mrac", "paper")
    found = measure(run)
    return Claim(
        "1",
        "The adaptive law, here mrac, which keeps the plant's zero, makes all three angles follow the reference model.",
        (_ends(run), _each_below("RMS error from 200 s on", 0.1, found.rms)),
    )


def _bears_delay(runs: Runs) -> Claim:
    plain, late = runs("mrac", "paper"), runs("mrac", "paper", delay=1)
    return Claim(
        "2",
        "Designed for the delay of one sample, the law follows just as well, one sample later.",
        (
            _ends(late),
            _each_below("RMS error from 200 s on", 0.2, measure(late).rms),
            _each_below("RMS difference to the run without delay, shifted by one sample", 0.15, _shifted(plain, late)),
        ),
    )


def _shifted(plain: Run, late: Run) -> FloatArray:
    """Return the RMS difference of the angles from 200 s on, the delayed run taken one sample later, deg."""
    first = int(np.argmin(np.abs(plain.t - LATE)))
    off = [late.variables()[a][first + 1 :] - plain.variables()[a][first:-1] for a in AXES]
    return _rms_degrees(off)


def _rms_degrees(off: Sequence[FloatArray]) -> FloatArray:
    rms: FloatArray = np.degrees(np.sqrt(np.square(off).mean(axis=1)))
    return rms


def _pd_does_not_track(runs: Runs) -> Claim:
    adaptive, plain = measure(runs("mrac", "paper")).rms, runs("pd", "paper")
    found, late = measure(plain).rms, measure(runs("pd", "paper", delay=1)).rms
    faster = measure(runs("pd", "paper", follow_model=1, **_faster(plain, 100.0, 20.0))).rms
    return Claim(
        "3",
        "PD control does not follow, with the delay or without.",
        (
            _each_above("RMS error from 200 s on", 10.0, found, "deg"),
            _each_above("the same with the delay", 10.0, late, "deg"),
            _each_above("over that of the adaptive law", 50.0, found / adaptive),
            beside(_each_above("Kp 100 and Kd 20 times as large, after the reference model", 10.0, faster, "deg")),
        ),
        "So it is with the printed gains (50), which give each axis a natural frequency of 0.0315 rad/s and a damping "
        "ratio of 0.27. It is no statement about PD control: larger gains track better.",
    )


def _faster(run: Run, stiffness: float, damping: float) -> dict[str, Any]:
    """Return the gains of a PD run, multiplied."""
    values = run.parameters.values
    return {f"K{n}_{i}": k * values[f"K{n}_{i}"] for n, k in (("p", stiffness), ("d", damping)) for i in "xyz"}


def _pd_needs_less_torque(runs: Runs) -> Claim:
    adaptive, pd = (measure(runs(law, "paper")).torque for law in ("mrac", "pd"))
    return Claim(
        "4",
        "PD needs less torque than the adaptive law.",
        (_each_below("largest torque from 200 s on, PD over adaptive", 1 / 3, pd / adaptive, ""),),
    )


def _printed_guess(runs: Runs) -> Claim:
    checks: list[Check] = []
    for what, delay in (("without delay", 0), ("with the delay", 1)):
        run = runs("mrac", "printed", delay=delay)
        checks += [_ends(run), _each_below(f"RMS error from 200 s on, {what}", 0.2, measure(run).rms)]
    return Claim(
        "5", "The estimator finds the plant from a wrong first guess: the printed B, F(0) = 1e4.", tuple(checks)
    )


def _single_precision(runs: Runs) -> Claim:
    text = "Single precision, the board's, is enough for the law (with the delay)."
    if runs.model.backend != "c":
        missing = beside(Check("difference of the angles", "< 0.01 deg", "not run", False))
        return Claim("6", text, (missing,), "A law computes in single precision in generated C only.")
    double, single = runs("mrac", "paper", delay=1), runs("mrac", "paper", delay=1, real="float")
    late = double.t >= LATE
    off = [single.variables()[a][late] - double.variables()[a][late] for a in AXES]
    close = _each_below("RMS difference of the angles", 0.01, _rms_degrees(off))
    return Claim("6", text, (_ends(single), close))


def _delay_must_be_known(runs: Runs) -> Claim:
    unaware: dict[str, Any] = {"delay": 1, "design_delay": 0}
    misled, aware = runs("mrac", "paper", applied_regressor=0, **unaware), runs("mrac", "paper", **unaware)
    fate, time = _lost("learning from the commanded torque", 41.0, misled)
    return Claim(
        "7",
        "The delay must be designed for: the law for d = 1 loses the satellite when there is a delay.",
        (
            fate,
            beside(time),
            Check("learning from the applied torque", "lost", aware.reason, aware.status is Status.LIMIT),
        ),
        "The loop is lost, but a few samples from the expected time: on the way the angles oscillate through large "
        "values, and when the torque passes its bound depends on how the plant is integrated there.",
    )


def _literal_rings(runs: Runs) -> Claim:
    run = runs("mrac-literal", "printed")
    found, pd = measure(run), measure(runs("pd", "paper")).torque
    return Claim(
        "8",
        "Law (32) as printed keeps the samples near the model by a torque that changes sign at every sample "
        "(first guess: the printed B, F(0) = 1e4, no delay).",
        (
            _ends(run),
            _each_below("RMS error from 200 s on", 0.1, found.rms),
            _each_above("ring from 200 s on, 1 for pure alternation", 0.9, found.ring),
            _each_above("largest torque from 200 s on, over that of PD", 50.0, found.torque / pd),
        ),
    )


def _literal_is_lost(runs: Runs) -> Claim:
    unaware: dict[str, Any] = {"delay": 1, "design_delay": 0, "applied_regressor": 0}
    checks = [
        *_lost("plant known, no delay", 180.5, runs("mrac-literal", "paper", adapt=0)),
        *_lost("delay, designed for d = 1", 4.5, runs("mrac-literal", "printed", **unaware)),
        *_lost("delay, designed for d = 2", 34.5, runs("mrac-literal", "printed", delay=1)),
        *_lost("delay, zero kept but pole 0.001", 188.0, runs("mrac", "paper", rho=0.001, adapt=0, delay=1)),
    ]
    for start, time in ((1e2, 138.5), (1e3, 76.5), (1e5, 11.5)):
        checks += _lost(f"F(0) = {start:g}", time, runs("mrac-literal", "printed", F0=start))
    largest = runs("mrac-literal", "printed", F0=1e6)
    torque = float(np.abs(largest.u[largest.t >= LATE]).max(initial=0.0))
    checks += [_ends(largest), about("F(0) = 1e6: largest torque from 200 s on", 60.0, torque, "N m", 0.02)]
    return Claim(
        "9",
        "Whether law (32) survives depends on choices that the paper does not give; poles at 0.001 leave no margin.",
        tuple(checks),
    )


def _literal_controls(runs: Runs) -> Claim:
    plain, late = runs("mrac-literal", "printed"), runs("mrac-literal", "printed", delay=1)
    known = runs("mrac-literal", "paper", adapt=0)
    return Claim(
        "10",
        "Law (32) as printed controls the satellite, with the delay and without.",
        (
            _ends(plain),
            _each_below("without delay: ring from 200 s on, 1 for pure alternation", 0.5, measure(plain).ring, ""),
            Check("plant known, no delay", "reaches its end", known.reason, known.status is Status.DONE),
            Check("with the delay", "reaches its end", late.reason, late.status is Status.DONE),
        ),
        "The law cancels the zero of the sampled plant, which is at -1 exactly: the torque that this hides from the "
        "samples alternates for ever or grows. The paper's argument needs zeros inside the unit circle, as its printed "
        "B has, but the plant has not (claim 12). What the paper says about adaptive control holds with law mrac, "
        "which has the same estimator and keeps the zero (claims 1 to 5).",
        refuted=True,
    )


def _linear_model(runs: Runs) -> Claim:
    values = runs("mrac", "paper").parameters.values
    (x, y, z), w0 = (values[f"I_{i}"] for i in "xyz"), values["omega0"]
    stiffness, damping = _second_order(runs)
    kept = (4 * w0**2 * (y - z), 3 * w0**2 * (x - z), w0**2 * (y - x))
    checks = [
        about(f"({8 + k}): stiffness of {axis}", kept[k], float(stiffness[k, k]), "N m/rad", 1e-6)
        for k, axis in enumerate(AXES)
    ]
    checks += [
        about("dropped: torque about x per rate of yaw", -w0 * (x - y + z), float(damping[0, 2]), "N m s/rad", 1e-6),
        about("dropped: torque about z per rate of roll", w0 * (x - y + z), float(damping[2, 0]), "N m s/rad", 1e-6),
        beside(Check("roll-yaw coupling", "none", f"{damping[2, 0]:.3g} N m s/rad", bool(damping[2, 0] == 0))),
    ]
    return Claim(
        "11",
        "Near rest in the orbit axes the dynamics are (8)-(10), with the second derivative where the first is printed.",
        tuple(checks),
        "The paper drops the coupling of roll and yaw by the orbital rate. At 0.01 rad/s it is a torque of 2e-5 N m, "
        "more than ten times what the largest stiffness gives at 30 degrees.",
    )


def _second_order(runs: Runs) -> tuple[FloatArray, FloatArray]:
    """Return K and D of J angles'' + D angles' + K angles = torque, at rest in the orbit axes."""
    A, B = _linear(runs)
    slow, fast = A[:3, :3], A[3:, 3:]
    inertia = np.linalg.inv(B[3:])
    return -inertia @ (A[3:, :3] - fast @ slow), -inertia @ (slow + fast)


def _linear(runs: Runs) -> tuple[FloatArray, FloatArray]:
    """Return A and B of the angles and rates at rest in the orbit axes."""
    model = runs.model
    rest = model.state(wy=-runs("mrac", "paper").parameters.values["omega0"])
    A, B, *_ = model.linearize(rest, np.zeros(3), model.parameters())
    return A[:6, :6], B[:6]


def _sampled_model(runs: Runs) -> Claim:
    period = runs("mrac", "paper").parameters.values["Ts"]
    A, B = _linear(runs)
    step = expm(period * np.block([[A, B], [np.zeros((3, 9))]]))
    first, second = step[:3, 6:], (step[:3, :6] @ step[:6, 6:])
    checks: list[Check] = []
    for k, axis in enumerate(AXES):
        b0 = float(first[k, k])
        b1 = float(second[k, k]) - 2 * b0
        checks += [
            about(f"({43 + k}), {axis}: b0", PRINTED_B[k][0], b0, "rad/(N m)", 0.01),
            about(f"({43 + k}), {axis}: b1", PRINTED_B[k][1], b1, "rad/(N m)", 0.01),
            about(f"({43 + k}), {axis}: zero of B", -PRINTED_B[k][1] / PRINTED_B[k][0], -b1 / b0, "", 0.01),
        ]
    return Claim(
        "12",
        "The sampled plant has A = 1 - 2 q^-1 + q^-2 and B as printed in (43)-(45).",
        tuple(checks),
        "With the torque held over Ts both coefficients of B are Ts^2/(2 I): the printed b1 are right, the printed b0 "
        "five to seven and a half times too large. The zero is at -1, on the unit circle, not well inside it. Where "
        "the printed b0 come from is not known; as first guess of the estimator they serve (claim 5).",
        refuted=True,
    )


def _wheels(runs: Runs) -> Claim:
    run = runs("mrac", "paper")
    series = run.variables()
    speeds = np.array([np.abs(series[f"wheel_{i}"]).max() for i in "xyz"]) * _RPM
    held = measure(runs("mrac", "paper", hmax=0.009)).rms
    return Claim(
        "13",
        "The wheels of Table 1 can carry the manoeuvre.",
        (
            below("largest speed of a wheel", 6000, float(speeds.max()), "rpm"),
            _each_below("RMS error from 200 s on when they stop at 0.009 N m s (6000 rpm)", 1.0, held),
        ),
        "Spin inertias of 1.3e-5 to 1.5e-5 kg m^2 are too small for a body of 3 kg m^2: the manoeuvre stores 0.12 N m "
        "s. The runs have no momentum limit unless hmax is set, and the paper's cannot have had one. With 1e-3 in "
        "place of 1e-5 the wheels would do; whether that was meant cannot be decided.",
        refuted=True,
    )
