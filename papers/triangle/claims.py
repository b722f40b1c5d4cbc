# SPDX-License-Identifier: Apache-2.0
"""Claims of the triangle's paper, each checked by running the model."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.reproduction import AMPLITUDES, Check, Checks, Expected, Runs, about, below, count, not_essential
from mehvar.runtime import Status

from .chart import law_direction
from .nonholonomic import attitude_is_area, smooth_laws_fail, usual_laws_leave

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mehvar.runtime import Run

    FloatArray = NDArray[np.float64]

_RODS = ("u_l1", "u_l2", "u_l3")
_R = 0.65
_FARTHEST = 0.6495
"""rho of the farthest random target: beyond it the path law is still on its way at 100 s."""
_PAIRS = 40
"""Random pairs of start and target. They show that some take longer than the paper's; more could only add to these. The
model's tests run 10^5."""
_DRIFT = 0.001
_CLOSER = 0.8
"""Largest remaining part at 100 s of an error at 35 s: the sliding law creeps and keeps 0.64 of the attitude's."""
_EXACT = 1e-6
"""Relative tolerance for algebraic consequences of the equations: the six printed digits agree."""
_OUTSIDE = 1e-6
"""Distance by which a law may pass its limiting circle within an integration step. The path law does by 4e-15."""
_GROWTH = 1e-8
"""rad: errors of integration, with tolerances of 1e-9, about a shifted attitude that is practically zero."""
_STEP = 1e-7
"""Step of central differences at a point of size 0.01: rounding changes the slope by 1e-7, and 1e-3 is allowed."""
ALIKE = 0.05
"""Relative deviation of comparable times of two laws: theirs differ by 1.2 %, with the printed gain by 90 %."""


def errors_at(run: Run, t: float) -> FloatArray:
    """Return |theta error| in rad and rho~ at a sample instant."""
    series, k = run.variables(), int(np.argmin(np.abs(run.t - t)))
    return np.array([abs(series["theta_error"][k]), series["rho_error"][k]])


def random_runs(runs: Runs, law: str, **changes: float) -> list[Run]:
    """Run a law for 100 s between starts and targets spread evenly over the disc, from all attitudes."""
    g = np.random.default_rng(1)
    start, goal = _R * np.sqrt(g.random(_PAIRS)), _FARTHEST * np.sqrt(g.random(_PAIRS))
    phi, theta, direction = g.uniform(-np.pi, np.pi, (3, _PAIRS))
    rods = np.stack(runs.model.functions["lengths"](goal, direction, np.full(_PAIRS, 0.43)), axis=-1)
    settings = {"t_end": 100.0, "dt_out": 0.05, "rtol": 1e-9, "atol": 1e-9, **changes}
    starts = [{"rho": float(r), "phi": float(f), "theta": float(a)} for r, f, a in zip(start, phi, theta, strict=True)]
    targets = [{f"l{k}_f": float(length) for k, length in enumerate(lengths, 1)} for lengths in rods]
    return [runs(law, "paper", initial, **target, **settings) for initial, target in zip(starts, targets, strict=True)]


def _reaches_target(runs: Runs, expected: Expected) -> Sequence[Check]:
    checks: list[Check] = []
    for law in ("sliding", "path"):
        angle, distance = expected(f"{law}_angle"), expected(f"{law}_distance")
        own, many = errors_at(runs(law, "paper"), 35.0), random_runs(runs, law)
        early, late = (np.max([errors_at(run, t) for run in many], axis=0) for t in (35.0, 100.0))
        closer = all(run.status is Status.DONE for run in many) and bool((late < _CLOSER * early).all())
        checks += [
            below(f"{law}, paper's start, |θ| at 35 s", angle, own[0], "rad"),
            below(f"{law}, paper's start, ρ̃ at 35 s", distance, own[1]),
            not_essential(below(f"{law}, worst of {_PAIRS} random pairs, |θ| at 35 s", angle, early[0], "rad")),
            not_essential(below(f"{law}, worst of {_PAIRS} random pairs, ρ̃ at 35 s", distance, early[1])),
            Check(
                f"{law}, worst of {_PAIRS} random pairs at 100 s",
                "closer than at 35 s",
                f"{late[0]:.2g} rad, {late[1]:.2g}",
                closer,
            ),
        ]
    return checks


def _attitude_falls(runs: Runs, expected: Expected) -> Sequence[Check]:
    checks = []
    for law in ("sliding", "path"):
        many = [np.abs(run.variables()["theta_shifted"]) for run in [runs(law, "paper"), *random_runs(runs, law)]]
        growth = max(float(np.diff(angle).max()) for angle in many)
        ends = max(float(angle[-1] / angle[0]) for angle in many)
        checks += [
            below(f"{law}: largest growth of |θ̃| in a sample, {_PAIRS + 1} pairs", _GROWTH, growth, "rad"),
            below(f"{law}: |θ̃| at the end over that at the start, {_PAIRS + 1} pairs", expected("end"), ends),
        ]
    return checks


def _times_agree(runs: Runs, expected: Expected) -> Sequence[Check]:
    sliding, path = (runs.metrics(law, "paper")["T_rho"] for law in ("sliding", "path"))
    printed = runs.metrics("path", "printed")["T_rho"]
    return (
        about("sliding: time after which ρ̃ < 0.02", expected("sliding_time"), sliding, "s"),
        about("path: time after which ρ̃ < 0.02", expected("path_time"), path, "s"),
        Check(
            "difference",
            f"within {100 * ALIKE:g} %",
            f"{100 * (path / sliding - 1):+.1f} %",
            abs(path / sliding - 1) < ALIKE,
        ),
        not_essential(
            about("path, gain 5 as printed: time after which ρ̃ < 0.02", round(sliding, 2), printed, "s", ALIKE)
        ),
    )


def _path_is_calmer(runs: Runs, expected: Expected) -> Sequence[Check]:
    sliding, path = (runs.metrics(law, "paper") for law in ("sliding", "path"))
    printed = runs.metrics("path", "printed")["max_rate"]
    coarse, fine = (_largest_change(runs("path", "paper", dt_out=dt)) for dt in (0.01, 0.001))
    return (
        about("sliding: largest rod rate", expected("sliding_rate"), sliding["max_rate"], "m/s", AMPLITUDES),
        about("path: largest rod rate", expected("path_rate"), path["max_rate"], "m/s", AMPLITUDES),
        count("sliding: sign changes of the rod rates", expected("sliding_flips"), sliding["flips"]),
        count("path: sign changes of the rod rates", expected("path_flips"), path["flips"]),
        about("sliding: turn of φ̃", expected("sliding_turn"), _turn(runs("sliding", "paper")), "rad"),
        about("path: turn of φ̃", expected("path_turn"), _turn(runs("path", "paper")), "rad"),
        Check(
            "path: largest change of a rod rate in 0.01 s and in 0.001 s",
            "shrinks with the step",
            f"{coarse:.2g} and {fine:.2g} m/s",
            fine < 0.2 * coarse,  # a tenth of the step; a jump would not shrink at all
        ),
        not_essential(below("path, gain 5 as printed: largest rod rate", expected("sliding_rate"), printed, "m/s")),
    )


def _turn(run: Run) -> float:
    """Return the change of the target's direction over a run, rad."""
    phi = np.unwrap(run.variables()["phi_error"])
    return float(phi[-1] - phi[0])


def _largest_change(run: Run) -> float:
    """Return the largest change of a rod rate from one sample to the next, m/s."""
    return max(float(np.abs(np.diff(run.variables()[name])).max()) for name in _RODS)


def _stays_inside(runs: Runs, expected: Expected) -> Sequence[Check]:
    largest = {
        law: max(float(run.variables()["rho"].max()) for run in [runs(law, "paper"), *random_runs(runs, law)])
        for law in ("sliding", "path")
    }
    run = runs("path", "paper")
    size = float(run.t[np.flatnonzero(np.abs(run.variables()["u_w3"]) >= 0.05 * (1 - 1e-9))[-1]])
    excess = largest["path"] - _R
    return (
        below(f"sliding: largest ρ over {_PAIRS + 1} pairs", _R, largest["sliding"]),
        Check(f"path: largest ρ over {_PAIRS + 1} pairs", f"≤ R + {_OUTSIDE:g}", f"R {excess:+.1g}", excess < _OUTSIDE),
        about("path: μ′ is limited until", expected("size_limited"), size, "s"),
        about("path: the arc is limited until", expected("arc_limited"), _limit_ends(runs, run), "s"),
    )


def _limit_ends(runs: Runs, run: Run) -> float:
    """Return the last instant at which the path law's command depends on R, s."""
    names = [q.name for q in run.controller.parameters]
    wider = run.parameters.c.copy()
    wider[names.index("R")] = 0.7071  # a little below the collinear shapes, at sqrt(1/2)
    reference = runs.model.functions["reference"](0.0, run.parameters.p, run.parameters.s)
    command = runs.model.functions["path"](run.x, reference, run.parameters.p, wider)
    differs = np.abs(command - run.u).max(axis=1) > 1e-9  # of rates near 0.1: rounding is 1e-17
    return float(run.t[np.flatnonzero(differs)[-1]])


def _gain_scales_time(runs: Runs, expected: Expected) -> Sequence[Check]:
    checks: list[Check] = []
    doubled: dict[str, dict[str, Any]] = {"sliding": {"k_phi": 6.0, "eta_rho": 1.3}, "path": {"k_phi": 1.0}}
    for law, faster in doubled.items():
        slow, fast = runs(law, "paper", dt_out=0.02), runs(law, "paper", t_end=17.5, **faster)
        off = float(np.abs(fast.x[:, [0, 3]] - slow.x[:, [0, 3]]).max())
        ratio = _shape_rates(runs, fast) / _shape_rates(runs, slow)
        checks += [
            below(f"{law}: largest |ρ(t; 2k) − ρ(2t; k)|, and of θ", 1e-6, off),
            about(f"{law}: ratio of the rod rates at the same μ", 2.0, ratio, tolerance=1e-5),
        ]
    return checks


def _shape_rates(runs: Runs, run: Run) -> float:
    """Return the largest rod rate needed for the change of shape by itself at mu = 1 m^2, m/s."""
    x, u = run.x.copy(), run.u.copy()
    x[:, 2], u[:, 2] = 1.0, 0.0
    return float(np.abs(runs.model.functions["length_rates"](x, u)).max())


def _exponent(runs: Runs, expected: Expected) -> Sequence[Check]:
    checks: list[Check] = []
    for m in (2.0, 3.0, 4.0):
        metrics = runs.metrics("sliding", "paper", m=m)
        checks.append(count(f"m = {m:g}: sign changes of the rod rates", expected(f"flips_{m:g}"), metrics["flips"]))
        time = expected(f"time_{m:g}")
        what, reached = f"m = {m:g}: time after which ρ̃ < 0.02", metrics["T_rho"]
        if math.isfinite(time):
            checks.append(about(what, time, reached, "s"))
        else:
            least, end = expected("slow"), float(runs("sliding", "paper", m=m).t[-1])
            text = f"{reached:.4g} s" if math.isfinite(reached) else f"more than {end:g} s"
            checks.append(Check(what, f"more than {least:g} s", text, reached > least))
    return checks


def _sign_chatters(runs: Runs, expected: Expected) -> Sequence[Check]:
    held = {"hold": 0.01, "t_end": 30.0}
    plain = runs.metrics("sliding", "paper", s_min=1e-12, theta_min=1e-12, **held)["flips"]
    smooth, more = runs.metrics("sliding", "paper", **held)["flips"], expected("more")
    return (
        count("smoothed, held for 0.01 s, 30 s: sign changes", expected("smooth"), smooth),
        Check(
            "plain: sign changes, likewise",
            f"more than {more:g} times as many",
            f"{plain / smooth:.0f} times",
            plain > more * smooth,
        ),
        not_essential(about("plain: sign changes in 30 s", expected("plain"), plain)),
    )


def _limit_cycle(runs: Runs, expected: Expected) -> Sequence[Check]:
    long: dict[str, Any] = {"disturbance": _DRIFT, "t_end": 200.0}
    path, sliding = (_cycle(runs(law, "paper", **long)) for law in ("path", "sliding"))
    k, still = 0.5, runs.model.rhs([0.4, 0.0, 0.43, 0.0], [0.0, 0.0, 0.0], runs("path", "paper", **long).parameters.p)
    pole = _cycle_pole(runs, math.sqrt(_DRIFT / k), math.pi * _DRIFT / (4 * k))
    return (
        about("rods held still: θ′", _DRIFT, float(still[3]), "rad/s", 1e-12),
        _exactly("path: least ρ̃ = √(d/k)", math.sqrt(_DRIFT / k), path["least"]),
        _exactly("path: largest ρ̃ = √(d/k)", math.sqrt(_DRIFT / k), path["most"]),
        _exactly("path: |θ̃| = πd/(4k)", math.pi * _DRIFT / (4 * k), path["shifted"], "rad"),
        _exactly("path: mean φ̃′ = −k", -k, path["turn"], "rad/s"),
        about("path: decay towards the cycle", expected("decay"), pole.real, "1/s", 1e-3),
        about("path: frequency of the decay", expected("frequency"), pole.imag, "rad/s", 1e-3),
        about("path: largest |θ|", expected("path_theta"), path["theta"], "rad", AMPLITUDES),
        about("path: largest rod rate", expected("path_rate"), path["rate"], "m/s", AMPLITUDES),
        about("sliding: least ρ̃", expected("sliding_least"), sliding["least"], "", AMPLITUDES),
        about("sliding: largest ρ̃", expected("sliding_most"), sliding["most"], "", AMPLITUDES),
        about("sliding: largest |θ|", expected("sliding_theta"), sliding["theta"], "rad", AMPLITUDES),
        about("sliding: largest rod rate", expected("sliding_rate"), sliding["rate"], "m/s", AMPLITUDES),
        not_essential(about("sliding: mean φ̃′", expected("sliding_turn"), sliding["turn"], "rad/s")),
    )


def _exactly(what: str, expected: float, measured: float, unit: str = "") -> Check:
    return Check(
        what, f"{expected:.6f} {unit}", f"{measured:.6f} {unit}", math.isclose(measured, expected, rel_tol=_EXACT)
    )


def _cycle(run: Run) -> dict[str, float]:
    """Return the size of the cycle over the last 100 s of a run."""
    series, late = run.variables(), run.t >= run.t[-1] - 100.0
    turned = np.unwrap(series["phi_error"])[late]
    return {
        "least": float(series["rho_error"][late].min()),
        "most": float(series["rho_error"][late].max()),
        "shifted": float(np.abs(series["theta_shifted"][late]).max()),
        "theta": float(np.abs(series["theta_error"][late]).max()),
        "rate": max(float(np.abs(series[name][late]).max()) for name in _RODS),
        "turn": float((turned[-1] - turned[0]) / 100.0),
    }


def _cycle_pole(runs: Runs, rho: float, theta: float) -> complex:
    """Return the upper eigenvalue of rho~ and theta~ around the path law's cycle, 1/s."""
    run, step = runs("path", "paper", disturbance=_DRIFT, t_end=200.0), _STEP

    def rates(point: FloatArray) -> FloatArray:
        direction = law_direction(runs.model, run, point[0], point[1], 0.4)
        return np.array([point[0] * direction.real, point[0] ** 2 * direction.imag + _DRIFT])

    at = np.array([rho, theta])
    columns = [(rates(at + step * e) - rates(at - step * e)) / (2 * step) for e in np.eye(2)]
    poles = np.linalg.eigvals(np.stack(columns, axis=1))
    return complex(poles[np.argmax(poles.imag)])


def _area_term(runs: Runs, expected: Expected) -> Sequence[Check]:
    derived, printed = (runs("path", "paper-b", area_factor=factor, t_end=30.0) for factor in (1.0, 0.5))
    late = printed.variables()["rho_error"][printed.t >= 25.0]
    settles = runs.metrics("path", "paper-b", area_factor=0.5, t_end=30.0)["T_rho"]
    settling = f"at {settles:.1f} s" if math.isfinite(settles) else "never"
    return (
        below("without the factor: ρ̃ at 30 s", expected("derived"), float(errors_at(derived, 30.0)[1])),
        about("with it: ρ̃ at 30 s", expected("printed"), float(late[-1]), tolerance=0.1),
        about("with it: least ρ̃ of the last 5 s", expected("printed"), float(late.min()), tolerance=0.1),
        Check("with it: ρ̃ < 0.02 for good", "never", settling, math.isinf(settles)),
    )


CHECKS: Mapping[str, Checks] = {
    "1": _reaches_target,
    "2": _times_agree,
    "3": _path_is_calmer,
    "4": _stays_inside,
    "5": _gain_scales_time,
    "6": _exponent,
    "7": _sign_chatters,
    "8": _limit_cycle,
    "9": _area_term,
    "10": attitude_is_area,
    "11": smooth_laws_fail,
    "12": usual_laws_leave,
    "13": _attitude_falls,
}
"""Functions by the number of their claim in claims.toml."""
