# SPDX-License-Identifier: Apache-2.0
"""Claims of the satellite's paper, each checked by running the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import expm

from mehvar.reproduction import AMPLITUDES, Check, Checks, Expected, Runs, about, above, below, in_words, not_essential
from mehvar.runtime import Status

from .checks import ends, lost, rms_degrees
from .design import cycle, independent, linear, root_locus
from .rows import AXES, LATE, PRINTED_B, measure

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mehvar.runtime import Run

    FloatArray = NDArray[np.float64]

_RPM = 30 / np.pi
_EXACT = 1e-6
"""Relative tolerance of damping, which comes from matrices that are exact up to rounding."""
_WHEELS = 5e-6
"""Relative tolerance of stiffness. Gravity on the wheels, which (8)-(10) neglect, changes pitch by 2.2e-6. Half or
twice the tolerance changes no verdict.
"""


def _follows_model(runs: Runs, expected: Expected) -> Sequence[Check]:
    run = runs("mrac", "paper")
    return (ends(run), below("RMS error from 200 s on", expected("error"), measure(run).rms, "deg"))


def _follows_late(runs: Runs, expected: Expected) -> Sequence[Check]:
    plain, late = runs("mrac", "paper"), runs("mrac", "paper", delay=1)
    return (
        ends(late),
        below("RMS error from 200 s on", expected("error"), measure(late).rms, "deg"),
        below(
            "RMS difference to the run without delay, shifted by one sample",
            expected("shifted"),
            _shifted(plain, late),
            "deg",
        ),
        below("RMS error over that without the delay", expected("ratio"), measure(late).rms / measure(plain).rms),
    )


def _shifted(plain: Run, late: Run) -> FloatArray:
    """Return the RMS difference of the angles from 200 s on, the delayed run taken one sample later, deg."""
    first = int(np.argmin(np.abs(plain.t - LATE)))
    off = [late.variables()[a][first + 1 :] - plain.variables()[a][first:-1] for a in AXES]
    return rms_degrees(off)


def _pd_does_not_track(runs: Runs, expected: Expected) -> Sequence[Check]:
    adaptive, plain = measure(runs("mrac", "paper")).rms, runs("pd", "paper")
    error, late = measure(plain).rms, measure(runs("pd", "paper", delay=1)).rms
    stiffness, damping = expected("stiffness"), expected("damping")
    faster = measure(runs("pd", "paper", follow_model=1, **_faster(plain, stiffness, damping))).rms
    return (
        above("RMS error from 200 s on", expected("error"), error, "deg"),
        above("RMS error from 200 s on, with the delay", expected("error"), late, "deg"),
        above("RMS error over that of the adaptive law", expected("ratio"), error / adaptive),
        not_essential(
            above(
                f"RMS error, Kp {stiffness:g} and Kd {damping:g} times as large, after the reference model",
                expected("error"),
                faster,
                "deg",
            )
        ),
    )


def _faster(run: Run, stiffness: float, damping: float) -> dict[str, Any]:
    """Return the gains of a PD run, multiplied."""
    values = run.parameters.values
    return {f"K{n}_{i}": k * values[f"K{n}_{i}"] for n, k in (("p", stiffness), ("d", damping)) for i in "xyz"}


def _pd_needs_less_torque(runs: Runs, expected: Expected) -> Sequence[Check]:
    adaptive, pd = (measure(runs(law, "paper")).torque for law in ("mrac", "pd"))
    return (below("largest torque from 200 s on, PD over adaptive", expected("ratio"), pd / adaptive),)


def _printed_guess(runs: Runs, expected: Expected) -> Sequence[Check]:
    checks: list[Check] = []
    for what, delay in (("without delay", 0), ("with the delay", 1)):
        run = runs("mrac", "printed", delay=delay)
        checks += [ends(run), below(f"RMS error from 200 s on, {what}", expected("error"), measure(run).rms, "deg")]
        gain, b0, b1 = (_off(run, *names)[:, -1] for names in (("b0", "b1"), ("b0",), ("b1",)))
        of = f"off from Ts²/I at the end, {what}"
        checks += [
            *(below(f"b0 + b1 of {a}, {of}", expected("gain"), float(g)) for a, g in zip(AXES[:2], gain, strict=False)),
            not_essential(below(f"b0 + b1 of yaw, {of}", expected("gain"), float(gain[2]))),
            not_essential(below(f"b0 alone, from half of it, {what}", expected("gain"), b0)),
            not_essential(below(f"b1 alone, from half of it, {what}", expected("gain"), b1)),
        ]
    return checks


def _off(run: Run, *names: str) -> FloatArray:
    """Return the relative error of the sum of B's estimated coefficients by axis and sample."""
    values, series = run.parameters.values, run.variables()
    true = [len(names) * values["Ts"] ** 2 / (2 * values[f"I_{i}"]) for i in "xyz"]
    sums = (np.sum([series[f"{name}_{axis}"] for name in names], axis=0) for axis in AXES)
    return np.array([np.abs(s / t - 1) for s, t in zip(sums, true, strict=True)])


def _single_precision(runs: Runs, expected: Expected) -> Sequence[Check]:
    if runs.model.backend != "c":
        bound = f"< {expected('difference'):g} deg"
        return (not_essential(Check("RMS difference of the angles", bound, "not run", False)),)
    double, single = runs("mrac", "paper", delay=1), runs("mrac", "paper", delay=1, real="float")
    late = double.t >= LATE
    off = [single.variables()[a][late] - double.variables()[a][late] for a in AXES]
    close = below("RMS difference of the angles", expected("difference"), rms_degrees(off), "deg")
    return (ends(single), close)


def _delay_must_be_known(runs: Runs, expected: Expected) -> Sequence[Check]:
    unaware: dict[str, Any] = {"delay": 1, "design_delay": 0}
    misled, aware = runs("mrac", "paper", applied_regressor=0, **unaware), runs("mrac", "paper", **unaware)
    fate, time = lost("learning from the commanded torque", expected("lost"), misled)
    return (
        fate,
        not_essential(time),
        Check("learning from the applied torque", "lost", aware.reason, aware.status is Status.LIMIT),
    )


def _literal_rings(runs: Runs, expected: Expected) -> Sequence[Check]:
    run = runs("mrac-literal", "printed")
    literal, pd = measure(run), measure(runs("pd", "paper")).torque
    return (
        ends(run),
        below("RMS error from 200 s on", expected("error"), literal.rms, "deg"),
        above("ring from 200 s on, 1 for pure alternation", expected("ring"), literal.ring),
        above("largest torque from 200 s on, over that of PD", expected("ratio"), literal.torque / pd),
    )


def _literal_is_lost(runs: Runs, expected: Expected) -> Sequence[Check]:
    unaware: dict[str, Any] = {"delay": 1, "design_delay": 0, "applied_regressor": 0}
    checks = [
        *lost("plant known, no delay", expected("known"), runs("mrac-literal", "paper", adapt=0)),
        *lost("delay, designed for d = 1", expected("delay_1"), runs("mrac-literal", "printed", **unaware)),
        *lost("delay, designed for d = 2", expected("delay_2"), runs("mrac-literal", "printed", delay=1)),
        *lost("delay, zero kept but pole 0.001", expected("pole"), runs("mrac", "paper", rho=0.001, adapt=0, delay=1)),
    ]
    for start in (1e2, 1e3, 1e5):
        checks += lost(f"F(0) = {start:g}", expected(f"start_{start:g}"), runs("mrac-literal", "printed", F0=start))
    largest = runs("mrac-literal", "printed", F0=1e6)
    torque = float(np.abs(largest.u[largest.t >= LATE]).max(initial=0.0))
    checks += [
        ends(largest),
        about("F(0) = 1e6: largest torque from 200 s on", expected("torque"), torque, "N m", AMPLITUDES),
    ]
    return checks


def _literal_controls(runs: Runs, expected: Expected) -> Sequence[Check]:
    run, known = runs("mrac-literal", "printed"), runs("mrac-literal", "paper", adapt=0)
    return (ends(run), _calm(run, expected), not_essential(ends(known, "plant known")))


def _literal_controls_late(runs: Runs, expected: Expected) -> Sequence[Check]:
    run = runs("mrac-literal", "printed", delay=1)
    root = _root_of_s(run.parameters.values["C2_pole"])
    stable = Check("root of S as designed for d = 2", "inside the unit circle", f"{root:.4g}", abs(root) < 1)
    return (ends(run), _calm(run, expected), not_essential(stable))


def _root_of_s(pole: float) -> float:
    """Return the root of S = 1 + s_1 q^-1, by C2 = A S + q^-2 T with a double pole in C2 and A = (1 - q^-1)^2."""
    return -(2 - 2 * pole)


def _calm(run: Run, expected: Expected) -> Check:
    """Return the check that the torques of a run do not alternate."""
    what, bound = "ring from 200 s on, 1 for pure alternation", expected("ring")
    if run.status is not Status.DONE:
        return Check(what, f"< {bound:g}", "none: the run is lost", False)
    return below(what, bound, measure(run).ring)


def _linear_model(runs: Runs, expected: Expected) -> Sequence[Check]:
    values = runs("mrac", "paper").parameters.values
    (x, y, z), w0 = (values[f"I_{i}"] for i in "xyz"), values["omega0"]
    stiffness, damping = _second_order(runs)
    printed = (4 * w0**2 * (y - z), 3 * w0**2 * (x - z), w0**2 * (y - x))
    rate, angle = expected("rate"), expected("angle")
    coupling, kept = rate * abs(damping[2, 0]), np.radians(angle) * np.abs(printed).max()
    checks = [
        about(f"({8 + k}): stiffness of {axis}", printed[k], float(stiffness[k, k]), "N m/rad", _WHEELS)
        for k, axis in enumerate(AXES)
    ]
    checks += [
        about("dropped: torque about x per rate of yaw", -w0 * (x - y + z), float(damping[0, 2]), "N m s/rad", _EXACT),
        about("dropped: torque about z per rate of roll", w0 * (x - y + z), float(damping[2, 0]), "N m s/rad", _EXACT),
        not_essential(
            below(
                f"torque dropped at {rate:g} rad/s, where (8)-(10) keep at {angle:g} degrees at most",
                float(kept),
                float(coupling),
                "N m",
            )
        ),
    ]
    return checks


def _second_order(runs: Runs) -> tuple[FloatArray, FloatArray]:
    """Return K and D of J angles'' + D angles' + K angles = torque, at rest in the orbit axes."""
    A, B = linear(runs)
    slow, fast = A[:3, :3], A[3:, 3:]
    inertia = np.linalg.inv(B[3:])
    return -inertia @ (A[3:, :3] - fast @ slow), -inertia @ (slow + fast)


def _sampled_model(runs: Runs, expected: Expected) -> Sequence[Check]:
    period = runs("mrac", "paper").parameters.values["Ts"]
    A, B = linear(runs)
    step = expm(period * np.block([[A, B], [np.zeros((3, 9))]]))
    first, second = step[:3, 6:], (step[:3, :6] @ step[:6, 6:])
    checks: list[Check] = []
    for k, axis in enumerate(AXES):
        b0 = float(first[k, k])
        b1 = float(second[k, k]) - 2 * b0
        checks += [
            *coefficients(k, b0, b1),
            about(f"({43 + k}), {axis}: zero of B", -PRINTED_B[k][1] / PRINTED_B[k][0], -b1 / b0, ""),
        ]
    return checks


def coefficients(axis: int, b0: float, b1: float) -> tuple[Check, Check]:
    """Return the checks that b0 and b1 of an axis are those of (43)-(45)."""
    name = f"({43 + axis}), {AXES[axis]}"
    pairs = zip(("b0", "b1"), PRINTED_B[axis], (b0, b1), strict=True)
    one, two = (about(f"{name}: {which}", printed, value, "rad/(N m)") for which, printed, value in pairs)
    return one, two


def _wheels(runs: Runs, expected: Expected) -> Sequence[Check]:
    return carried(runs, expected, expected("momentum"))


def carried(runs: Runs, expected: Expected, momentum: float, **settings: Any) -> Sequence[Check]:
    """Return the checks that the wheels suffice for the manoeuvre: their speed, and the error with a momentum limit."""
    series = runs("mrac", "paper", **settings).variables()
    speeds = np.array([np.abs(series[f"wheel_{i}"]).max() for i in "xyz"]) * _RPM
    stopped = measure(runs("mrac", "paper", hmax=momentum, **settings)).rms
    inertia = runs("mrac", "paper", **settings).parameters.values
    stored = max(speed * inertia[f"Iw_{i}"] for i, speed in zip("xyz", speeds / _RPM, strict=True))
    return (
        not_essential(below("largest momentum of a wheel", momentum, float(stored), "N m s")),
        below("largest speed of a wheel", expected("speed"), float(speeds.max()), "rpm"),
        below(f"RMS error from 200 s on when they stop at {momentum:g} N m s", expected("error"), stopped, "deg"),
    )


def _offset(runs: Runs, expected: Expected) -> Sequence[Check]:
    return offset_helps(runs, "mrac", "printed", "estimate_d", delay=1)


def offset_helps(runs: Runs, law: str, scenario: str, switch: str, **settings: Any) -> Sequence[Check]:
    """Return the check that the error of every axis is smaller with the offset than with a switch off."""
    cases: list[dict[str, Any]] = [{**settings, switch: value} for value in (1, 0)]
    on, off = (measure(runs(law, scenario, **case)).rms for case in cases)
    return (
        Check(
            "RMS error from 200 s on", f"less than {in_words(off, 'deg')}", in_words(on, "deg"), bool((on < off).all())
        ),
    )


def _quick(runs: Runs, expected: Expected) -> Sequence[Check]:
    plain, late = runs("mrac", "printed"), runs("mrac", "printed", delay=1)
    series, share = plain.variables(), expected("known")
    off = f"B(1) of {{}} is off by {100 * share:g} %"
    error = np.degrees([np.abs(series[a] - series[f"ym_{a}"])[plain.t < LATE].max() for a in AXES])
    return (
        *(below(f"last time that {off.format(a)}", expected("time"), _learnt(plain, k, share), "s")
          for k, a in enumerate(AXES[:2])),
        below(f"largest error of the first {LATE:g} s", expected("error"), error, "deg"),
        *(not_essential(below(f"with the delay: last time that {off.format(a)}", expected("time"),
                       _learnt(late, k, share), "s")) for k, a in enumerate(AXES[:2])),
    )  # fmt: skip


def _learnt(run: Run, axis: int, share: float) -> float:
    """Return the last time at which the estimated B(1) = Ts^2/I of an axis deviates by more than a share, s."""
    off = _off(run, "b0", "b1")[axis] > share
    return float(run.t[np.flatnonzero(off)[-1]])


CHECKS: Mapping[str, Checks] = {
    "1": _follows_model,
    "2": _follows_late,
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
    "14": _literal_controls_late,
    "15": _offset,
    "16": independent,
    "17": _quick,
    "18": root_locus,
    "19": cycle,
}
"""Functions by the number of their claim in claims.toml."""
