# SPDX-License-Identifier: Apache-2.0
"""Sampled laws: adaptive control that keeps the plant's zero, the paper's law (32) that cancels it, and PD (50).

Each axis has a reference model C1 w = D r and, in the adaptive laws, an estimator. A command computed from y(k) acts
over [k, k+1) with d = 1, or one sample later with d = 2.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import sympy as sp

from mehvar.base.names import identifier

from ..system import LARGEST, Condition, Controller, Derivation, Expr, Group, Quantity
from . import estimator
from .dynamics import AXES, angles, inertia_matrix, rates
from .estimator import HALF, SAMPLES, SENSOR_LOST, Estimate, smallest_gain
from .polynomials import (
    RIGHT,
    a1,
    a2,
    b0,
    b1,
    cancelling,
    closed_loop,
    numerators,
    put,
    resultant,
    retaining,
    s1,
)
from .wheels import Wheels

REFERENCES = Group("r", tuple(Quantity(f"ref_{axis}", "rad", f"wanted {axis}", f"r_{{{axis}}}") for axis in AXES))

_PAST = 4
"""Past values of w needed for a delay d = 2, as Ac has degree four."""

Law = Callable[[int, Estimate, "ReferenceModel", Group, Group, Derivation], Expr]


@dataclass(frozen=True)
class ReferenceModel:
    """Reference model of an axis at this sample.

    Attributes
    ----------
    w : tuple of Expr
        w(k), w(k-1), ...
    delayed : Rel
        d = 2: the delayed case.
    """

    w: tuple[Expr, ...]
    delayed: sp.Rel


def model_memory(axis: str, keeps_zero: bool) -> tuple[Quantity, ...]:
    """Return the memory of an axis's reference model."""
    past = (
        Quantity(f"wm{k}_{axis}", "rad", f"reference model of {axis} before its zero, {k} samples ago", f"w(k-{k})")
        for k in range(1, (_PAST if keeps_zero else 2) + 1)
    )
    return (Quantity(f"ym_{axis}", "rad", f"reference model's {axis}", "y_m"), *past)


def reference_models(law: Group, plant: Group, d: Derivation) -> tuple[ReferenceModel, ...]:
    """Define w(k) of each axis: C1 w = D r, with a double pole and unit gain (16)."""
    pole = d.define("model_pole", sp.exp(-plant.Ts / law.tau_m), "", "double pole of C1", latex="p")
    C1 = closed_loop(pole, 2)
    models = []
    for k, axis in enumerate(AXES):
        past = tuple(q.symbol for q in model_memory(axis, True)[1:])
        moved = sp.factor(sp.Add(*C1)) * REFERENCES.symbols[k] - C1[1] * past[0] - C1[2] * past[1]
        now = d.define(
            f"w_{axis}",
            moved,
            "(16)",
            f"reference model of {axis} before its zero",
            "rad",
            rf"w_{{\mathrm{{{axis}}}}}(k)",
        )
        models.append(ReferenceModel((now, *past), law.design_delay > HALF))
    return tuple(models)


def _model_update(model: ReferenceModel, keeps_zero: bool) -> dict[str, Expr]:
    """Return the reference model's next memory; y_m is the value at the next sample."""
    w = model.w
    if keeps_zero:
        ahead = sp.Piecewise(((w[1] + w[2]) / 2, model.delayed), ((w[0] + w[1]) / 2, True))
    else:
        ahead = sp.Piecewise((w[1], model.delayed), (w[0], True))
    return {"ym": ahead, **{f"wm{k}": w[k - 1] for k in range(1, _PAST + 1)}}


def retain(axis: int, estimate: Estimate, model: ReferenceModel, law: Group, plant: Group, d: Derivation) -> Expr:
    """Place the poles, keep the zero of B and compensate the estimated offset."""
    name = AXES[axis]
    ea1, ea2, eb0, eb1, offset = estimate.theta
    floor = smallest_gain(axis, law, plant)
    lift = d.define(
        f"lift_{name}", sp.Max(0, floor - (eb0 + eb1) / 2), "", "what b0 and b1 lack", "rad/N/m", r"\delta_b"
    )
    gain = d.define(f"B1_{name}", eb0 + eb1 + 2 * lift, "", "B(1)", "rad/N/m", "B(1)")
    values = {a1: ea1, a2: ea2, b0: eb0 + lift, b1: eb1 + lift}
    direct, delayed = retaining(law.rho, 1), retaining(law.rho, 2)
    first = d.define(
        f"s1_{name}", put(delayed.first[0], values), "(22)", "first coefficient of S when d = 2", latex="s_1"
    )
    values |= {s1: first}
    right = [
        d.define(f"e{i + 1}_{name}", sp.Piecewise((put(two, values), model.delayed), (put(one, values), True)), "(22)",
                 f"right-hand side {i + 1} of the polynomial equation", latex=f"e_{i + 1}")
        for i, (one, two) in enumerate(zip(direct.right, delayed.right, strict=True))
    ]  # fmt: skip
    values |= dict(zip(RIGHT, right, strict=True))
    size = d.define(f"res_{name}", put(resultant(direct.matrix), values), "", "resultant of A and B", latex="R(A,B)")
    last, t0, t1 = (
        d.define(f"{n}_{name}", put(numerator, values) / size, "(22)", f"{n} of A S + q^-d B T = Ac", latex=latex)
        for (n, latex), numerator in zip(
            (("sd", "s_d"), ("t0", "t_0"), ("t1", "t_1")), numerators(direct.matrix), strict=True
        )
    )
    first = sp.Piecewise((first, model.delayed), (0, True))
    goal = sp.Add(*(
        sp.Piecewise((two, model.delayed), (one, True)) * w
        for one, two, w in zip((*closed_loop(law.rho, 3), sp.S.Zero), closed_loop(law.rho, 4), model.w, strict=True)
    ))  # fmt: skip
    goal = d.define(f"Acw_{name}", goal, "", "Ac w(k)", "rad", "A_c w")
    past = last * estimate.torque + first * estimator.symbols(name)["u1"]
    return (goal - (1 + first + last) * offset) / gain - t0 * estimate.y - t1 * estimate.y1 - past


def cancel(axis: int, estimate: Estimate, model: ReferenceModel, law: Group, plant: Group, d: Derivation) -> Expr:
    """Define law (32) as printed, with the offset term. It cancels B, whose true zero is at -1."""
    name = AXES[axis]
    ea1, ea2, eb0, eb1, offset = estimate.theta
    leading = d.define(
        f"b0_used_{name}",
        sp.Max(eb0, smallest_gain(axis, law, plant)),
        "",
        "b0 that the law divides by",
        "rad/N/m",
        "b_0",
    )
    values = {a1: ea1, a2: ea2, b0: leading, b1: eb1}
    direct, delayed = (cancelling((law.C2_pole, law.C2_pole), d_) for d_ in (1, 2))
    pairs = zip(("t0", "t1"), direct.T, delayed.T, strict=True)
    t0, t1 = (
        d.define(f"{n}_cancel_{name}", sp.Piecewise((put(two, values), model.delayed), (put(one, values), True)),
                 "(24)", f"{n} of C2 = A S + q^-d T", latex=f"t_{n[1]}")
        for n, one, two in pairs
    )  # fmt: skip
    first = d.define(f"s1_cancel_{name}", put(delayed.S[1], values), "(23)", "s1 of S when d = 2", latex="s_1")
    commanded = estimator.symbols(name)["u1"]
    two = (eb1 + leading * first) * commanded + eb1 * first * estimate.torque
    past = sp.Piecewise((two, model.delayed), (eb1 * estimate.torque, True))
    past = d.define(f"BSu_{name}", past, "(33)", "(B S - b0) u", "rad", "B_S' u")
    C2 = closed_loop(law.C2_pole, 2)
    goal = sp.Add(*(c * w for c, w in zip(C2, model.w, strict=False)))
    offset_gain = sp.Piecewise((1 + first, model.delayed), (1, True))
    return (goal - t0 * estimate.y - t1 * estimate.y1 - past - offset_gain * offset) / leading


@dataclass(frozen=True)
class Shared:
    """Common parts of the laws at a sample: reference models, estimators, wheels."""

    models: tuple[ReferenceModel, ...]
    estimates: tuple[Estimate, ...]
    wheels: Wheels


def adaptive(name: str, title: str, form: Law, law: Group, plant: Group, shared: Shared, d: Derivation) -> Controller:
    """Combine an adaptive law from its control equation and the common estimators."""
    keeps_zero = form is retain
    tag = identifier(name)
    commands = []
    for k, axis in enumerate(AXES):
        d.section(f"Law {name}, {axis}: {title}")
        torque = form(k, shared.estimates[k], shared.models[k], law, plant, d)
        commands.append(d.define(f"u_{axis}_{tag}", torque, "", f"torque about {axis}", "N m", "u(k)"))
    d.section(f"Law {name}: check of the numbers")
    traces = [estimate.trace for estimate in shared.estimates]
    needed = (*angles, *shared.wheels.acting, *shared.wheels.measured, *REFERENCES.symbols)
    healthy = _healthy(tag, (*needed, *commands, *traces), d)
    rows: list[tuple[Quantity, Expr, Expr]] = []
    for k, axis in enumerate(AXES):
        after = shared.estimates[k].update | {"u1": commands[k]} | _model_update(shared.models[k], keeps_zero)
        before = estimator.start(k, law, plant) | _model_start(k, law)
        for q in (*estimator.memory(axis), *model_memory(axis, keeps_zero)):
            key = q.name.removesuffix(f"_{axis}")
            rows.append((q, before[key], after[key]))
    count = sp.Piecewise((sp.Min(SAMPLES.symbol + 1, estimator.WARM), healthy), (0, True))
    extra = ((SAMPLES, sp.S.Zero, count),)
    # F = F0 I and its trace add numbers of different units
    return dataclasses.replace(
        _controller(name, title, law, commands, shared.wheels, healthy, rows, extra), in_numbers=True
    )


def pd(title: str, omega: Iterable[Expr], plant: Group, law: Group, shared: Shared, d: Derivation) -> Controller:
    """Define law (50): proportional to the angle error, with damping by the rate relative to the orbit axes."""
    d.section(f"Law pd: {title}")
    commands, rows = [], []
    for k, (i, rate) in enumerate(zip("xyz", omega, strict=True)):
        axis, model = AXES[k], shared.models[k]
        memory = model_memory(axis, False)
        goal = sp.Piecewise((memory[0].symbol, law.follow_model > HALF), (REFERENCES.symbols[k], True))
        torque = getattr(law, f"Kp_{i}") * (goal - angles[k]) - getattr(law, f"Kd_{i}") * rate
        commands.append(d.define(f"u_{axis}_pd", torque, "(50)", f"torque about {axis}", "N m", "u(k)"))
        after, before = _model_update(model, True), _model_start(k, law)
        for q in memory:
            key = q.name.removesuffix(f"_{axis}")
            rows.append((q, before[key], after[key]))
    healthy = _healthy("pd", (*angles, *rates, *shared.wheels.measured, *REFERENCES.symbols, *commands), d)
    unstable = tuple(_wrong_sign(k, plant, law) for k in range(3))
    return _controller("pd", title, law, commands, shared.wheels, healthy, rows, (), unstable)


def _wrong_sign(k: int, plant: Group, law: Group) -> Condition:
    """Warn about gains that destabilise an axis: both roots of I s^2 + Kd s + Kp must have negative real parts."""
    i, inertia = "xyz"[k], inertia_matrix(plant)[k, k]
    stiffness, damping = getattr(law, f"Kp_{i}"), getattr(law, f"Kd_{i}")
    middle = -damping / (2 * inertia)
    discriminant = middle**2 - stiffness / inertia
    root, turn = sp.sqrt(sp.Max(discriminant, 0)), sp.sqrt(sp.Max(-discriminant, 0))
    message = (
        f"Kp_{i} = {{Kp_{i}:g}} N m/rad and Kd_{i} = {{Kd_{i}:g}} N m s/rad make the loop about {i} unstable: "
        "its poles are {0:.4g}{1:+.4g}i and {2:.4g}{3:+.4g}i rad/s"
    )
    return Condition(sp.Min(stiffness, damping), message, (middle + root, turn, middle - root, -turn))


def _model_start(axis: int, law: Group) -> dict[str, Expr]:
    """Return the initial memory of a reference model at rest, at the measured angle or at zero."""
    first = sp.Piecewise((angles[axis], law.matched > HALF), (0, True))
    return {"ym": first, **{f"wm{k}": first for k in range(1, _PAST + 1)}}


def _healthy(tag: str, numbers: Iterable[Expr], d: Derivation) -> sp.Rel:
    """Return the condition that all inputs and outputs of a law are finite; a comparison with NaN is false."""
    finite = sp.And(*(sp.Abs(number) < LARGEST for number in numbers))
    flag = d.define(f"healthy_{tag}", sp.Piecewise((1, finite), (0, True)), "", "1 when all numbers are finite")
    return flag > HALF


def _controller(
    name: str,
    title: str,
    law: Group,
    torque: list[Expr],
    wheels: Wheels,
    healthy: sp.Rel,
    rows: list[tuple[Quantity, Expr, Expr]],
    extra: tuple[tuple[Quantity, Expr, Expr], ...],
    warnings: tuple[Condition, ...] = (),
) -> Controller:
    """Guard a law: if a number is not finite, keep the memory and command zero."""
    update = [sp.Piecewise((after, healthy), (q.symbol, True)) for q, _, after in rows]
    flag = sp.Piecewise((0, healthy), (1, True))
    memory = Group("z", (*(q for q, _, _ in rows), *(q for q, _, _ in extra), SENSOR_LOST))
    return Controller(
        name,
        title,
        law,
        tuple(sp.Piecewise((u, healthy), (0, True)) for u in wheels.commands(torque, law)),
        constraints=_conditions(law),
        warnings=warnings,
        period="Ts",
        applied=wheels.applied,
        memory=memory,
        start=(*(before for _, before, _ in rows), *(before for _, before, _ in extra), sp.S.Zero),
        update=(*update, *(after for _, _, after in extra), flag),
        delay="delay",
        tolerates_loss=True,
    )


def _conditions(law: Group) -> tuple[Condition, ...]:
    samples = law.design_delay
    # a margin must be positive: the slack admits exactly 0 and 1, and no other sensible value is so close to them
    whole = sp.Rational(1, 10**9) - sp.Abs(samples * (1 - samples))
    return (Condition(whole, "design_delay = {design_delay:g} samples is not known: it must be 0 or 1"),)
