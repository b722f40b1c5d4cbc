# SPDX-License-Identifier: Apache-2.0
"""What the satellite's paper claims, each checked by running the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import expm

from mehvar.runtime.run.problem import Status

from ..claims import AMPLITUDES, Check, Checks, Expected, about, below, beside
from ..runs import Runs
from .rows import AXES, LATE, PRINTED_B, measure

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mehvar.runtime.run.simulate import Run

    FloatArray = NDArray[np.float64]

_RPM = 30 / np.pi
_LOST = 0.02
"""Allowed deviation of the time at which a run is lost, relative: below one sample, 0.5 s, for times up to 25 s. All
but that of claim 7 agree to the sample, so half of this changes nothing; with twice, claim 7's agrees too."""
_EXACT = 1e-6
"""Relative, of damping: it comes from matrices that are exact but for rounding."""
_WHEELS = 5e-6
"""Relative, of stiffness: gravity pulls at the wheels too, which (8)-(10) leave out: 2.2e-6 of the pitch's. Half
as much still passes, with twice as much nothing else does."""


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
    return fate, about(f"{what}: time", expected, run.t_stop, "s", _LOST)


def _follows_model(runs: Runs, expected: Expected) -> Sequence[Check]:
    run = runs("mrac", "paper")
    return (_ends(run), _each_below("RMS error from 200 s on", expected("error"), measure(run).rms))


def _bears_delay(runs: Runs, expected: Expected) -> Sequence[Check]:
    plain, late = runs("mrac", "paper"), runs("mrac", "paper", delay=1)
    return (
        _ends(late),
        _each_below("RMS error from 200 s on", expected("error"), measure(late).rms),
        _each_below(
            "RMS difference to the run without delay, shifted by one sample", expected("shifted"), _shifted(plain, late)
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


def _pd_does_not_track(runs: Runs, expected: Expected) -> Sequence[Check]:
    adaptive, plain = measure(runs("mrac", "paper")).rms, runs("pd", "paper")
    error, late = measure(plain).rms, measure(runs("pd", "paper", delay=1)).rms
    faster = measure(runs("pd", "paper", follow_model=1, **_faster(plain, 100.0, 20.0))).rms
    return (
        _each_above("RMS error from 200 s on", expected("error"), error, "deg"),
        _each_above("the same with the delay", expected("error"), late, "deg"),
        _each_above("over that of the adaptive law", expected("ratio"), error / adaptive),
        beside(
            _each_above("Kp 100 and Kd 20 times as large, after the reference model", expected("error"), faster, "deg")
        ),
    )


def _faster(run: Run, stiffness: float, damping: float) -> dict[str, Any]:
    """Return the gains of a PD run, multiplied."""
    values = run.parameters.values
    return {f"K{n}_{i}": k * values[f"K{n}_{i}"] for n, k in (("p", stiffness), ("d", damping)) for i in "xyz"}


def _pd_needs_less_torque(runs: Runs, expected: Expected) -> Sequence[Check]:
    adaptive, pd = (measure(runs(law, "paper")).torque for law in ("mrac", "pd"))
    return (_each_below("largest torque from 200 s on, PD over adaptive", expected("ratio"), pd / adaptive, ""),)


def _printed_guess(runs: Runs, expected: Expected) -> Sequence[Check]:
    checks: list[Check] = []
    for what, delay in (("without delay", 0), ("with the delay", 1)):
        run = runs("mrac", "printed", delay=delay)
        checks += [_ends(run), _each_below(f"RMS error from 200 s on, {what}", expected("error"), measure(run).rms)]
    return checks


def _single_precision(runs: Runs, expected: Expected) -> Sequence[Check]:
    if runs.model.backend != "c":
        missing = beside(Check("difference of the angles", "< 0.01 deg", "not run", False))
        return (missing,)
    double, single = runs("mrac", "paper", delay=1), runs("mrac", "paper", delay=1, real="float")
    late = double.t >= LATE
    off = [single.variables()[a][late] - double.variables()[a][late] for a in AXES]
    close = _each_below("RMS difference of the angles", expected("difference"), _rms_degrees(off))
    return (_ends(single), close)


def _delay_must_be_known(runs: Runs, expected: Expected) -> Sequence[Check]:
    unaware: dict[str, Any] = {"delay": 1, "design_delay": 0}
    misled, aware = runs("mrac", "paper", applied_regressor=0, **unaware), runs("mrac", "paper", **unaware)
    fate, time = _lost("learning from the commanded torque", expected("lost"), misled)
    return (
        fate,
        beside(time),
        Check("learning from the applied torque", "lost", aware.reason, aware.status is Status.LIMIT),
    )


def _literal_rings(runs: Runs, expected: Expected) -> Sequence[Check]:
    run = runs("mrac-literal", "printed")
    literal, pd = measure(run), measure(runs("pd", "paper")).torque
    return (
        _ends(run),
        _each_below("RMS error from 200 s on", expected("error"), literal.rms),
        _each_above("ring from 200 s on, 1 for pure alternation", expected("ring"), literal.ring),
        _each_above("largest torque from 200 s on, over that of PD", expected("ratio"), literal.torque / pd),
    )


def _literal_is_lost(runs: Runs, expected: Expected) -> Sequence[Check]:
    unaware: dict[str, Any] = {"delay": 1, "design_delay": 0, "applied_regressor": 0}
    checks = [
        *_lost("plant known, no delay", expected("known"), runs("mrac-literal", "paper", adapt=0)),
        *_lost("delay, designed for d = 1", expected("delay_1"), runs("mrac-literal", "printed", **unaware)),
        *_lost("delay, designed for d = 2", expected("delay_2"), runs("mrac-literal", "printed", delay=1)),
        *_lost("delay, zero kept but pole 0.001", expected("pole"), runs("mrac", "paper", rho=0.001, adapt=0, delay=1)),
    ]
    for start in (1e2, 1e3, 1e5):
        checks += _lost(f"F(0) = {start:g}", expected(f"start_{start:g}"), runs("mrac-literal", "printed", F0=start))
    largest = runs("mrac-literal", "printed", F0=1e6)
    torque = float(np.abs(largest.u[largest.t >= LATE]).max(initial=0.0))
    checks += [
        _ends(largest),
        about("F(0) = 1e6: largest torque from 200 s on", expected("torque"), torque, "N m", AMPLITUDES),
    ]
    return checks


def _literal_controls(runs: Runs, expected: Expected) -> Sequence[Check]:
    plain, late = runs("mrac-literal", "printed"), runs("mrac-literal", "printed", delay=1)
    exact = runs("mrac-literal", "paper", adapt=0)
    return (
        _ends(plain),
        _each_below(
            "without delay: ring from 200 s on, 1 for pure alternation", expected("ring"), measure(plain).ring, ""
        ),
        Check("plant known, no delay", "reaches its end", exact.reason, exact.status is Status.DONE),
        Check("with the delay", "reaches its end", late.reason, late.status is Status.DONE),
    )


def _linear_model(runs: Runs, expected: Expected) -> Sequence[Check]:
    values = runs("mrac", "paper").parameters.values
    (x, y, z), w0 = (values[f"I_{i}"] for i in "xyz"), values["omega0"]
    stiffness, damping = _second_order(runs)
    printed = (4 * w0**2 * (y - z), 3 * w0**2 * (x - z), w0**2 * (y - x))
    checks = [
        about(f"({8 + k}): stiffness of {axis}", printed[k], float(stiffness[k, k]), "N m/rad", _WHEELS)
        for k, axis in enumerate(AXES)
    ]
    checks += [
        about("dropped: torque about x per rate of yaw", -w0 * (x - y + z), float(damping[0, 2]), "N m s/rad", _EXACT),
        about("dropped: torque about z per rate of roll", w0 * (x - y + z), float(damping[2, 0]), "N m s/rad", _EXACT),
        beside(Check("roll-yaw coupling", "none", f"{damping[2, 0]:.3g} N m s/rad", bool(damping[2, 0] == 0))),
    ]
    return checks


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


def _sampled_model(runs: Runs, expected: Expected) -> Sequence[Check]:
    period = runs("mrac", "paper").parameters.values["Ts"]
    A, B = _linear(runs)
    step = expm(period * np.block([[A, B], [np.zeros((3, 9))]]))
    first, second = step[:3, 6:], (step[:3, :6] @ step[:6, 6:])
    checks: list[Check] = []
    for k, axis in enumerate(AXES):
        b0 = float(first[k, k])
        b1 = float(second[k, k]) - 2 * b0
        checks += [
            about(f"({43 + k}), {axis}: b0", PRINTED_B[k][0], b0, "rad/(N m)"),
            about(f"({43 + k}), {axis}: b1", PRINTED_B[k][1], b1, "rad/(N m)"),
            about(f"({43 + k}), {axis}: zero of B", -PRINTED_B[k][1] / PRINTED_B[k][0], -b1 / b0, ""),
        ]
    return checks


def _wheels(runs: Runs, expected: Expected) -> Sequence[Check]:
    run = runs("mrac", "paper")
    series = run.variables()
    speeds = np.array([np.abs(series[f"wheel_{i}"]).max() for i in "xyz"]) * _RPM
    held = measure(runs("mrac", "paper", hmax=0.009)).rms
    return (
        below("largest speed of a wheel", expected("speed"), float(speeds.max()), "rpm"),
        _each_below("RMS error from 200 s on when they stop at 0.009 N m s (6000 rpm)", expected("error"), held),
    )


CHECKS: Mapping[str, Checks] = {
    "1": _follows_model,
    "2": _bears_delay,
    "3": _pd_does_not_track,
    "4": _pd_needs_less_torque,
    "5": _printed_guess,
    "6": _single_precision,
    "7": _delay_must_be_known,
    "8": _literal_rings,
    "9": _literal_is_lost,
    "10": _literal_controls,
    "11": _linear_model,
    "12": _sampled_model,
    "13": _wheels,
}
"""By the number of the claim in claims.toml."""
