# SPDX-License-Identifier: Apache-2.0
"""Check of functions under a change of units: results must scale with their units."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
import sympy as sp

from mehvar.base.units import dimension
from mehvar.codegen.functions.requests import Request
from mehvar.models.check import formulas
from mehvar.models.system import Definition, Group, System
from mehvar.physics.machine import Array, Machine, draw

SCALES = {"kg": 1.7, "m": 0.6, "s": 1.3, "A": 1.9, "K": 2.3, "mol": 2.9, "cd": 3.1, "deg": 1.0}
"""Number of new units in one old unit. No product of small powers equals 1, so that errors cannot cancel."""
SAME_TORQUE = SCALES | {"kg": SCALES["s"] ** 2 / SCALES["m"] ** 2}
"""Units in which a newton metre keeps its value."""


def scale(unit: str, scales: Mapping[str, float]) -> float:
    """Return the number of new units in one old unit."""
    return float(np.prod([scales[base] ** float(exponent) for base, exponent in dimension(unit).items()]))


def misfit(subject: Machine, name: str, scales: Mapping[str, float] = SCALES, n: int = 16) -> float:
    """Return the relative difference between a function in new units and its converted result."""
    request = subject.requests[name]
    rng = np.random.default_rng(sum(map(ord, name)))
    values = [draw(subject.ranges, group, n, rng) for group in request.arguments]
    changed = [v * _factors(group, scales) for v, group in zip(values, request.arguments, strict=True)]
    before, after = subject(name, *values), _with_constants(subject, scales)(name, *changed)
    expected = _results(subject.system, request)
    factors = _observed(before, after) if expected is None else np.array([scale(unit, scales) for unit in expected])
    size = np.maximum(np.abs(before).max(axis=0), 1e-6)  # a result that is zero everywhere is compared as it is
    error = np.abs(after / factors - before) / size
    return float(error.max()) if error.size else 0.0


def _with_constants(subject: Machine, scales: Mapping[str, float]) -> Machine:
    """Return the machine with the constants of nature converted to the new units."""
    factors = {
        step.symbol: scale(step.unit, scales)
        for step in subject.system.steps
        if isinstance(step, Definition) and step.unit and not sp.sympify(step.expr).free_symbols
    }
    if all(factor == 1 for factor in factors.values()):
        return subject
    steps = tuple(
        dataclasses.replace(step, expr=step.expr * factors[step.symbol])
        if isinstance(step, Definition) and step.symbol in factors
        else step
        for step in subject.system.steps
    )
    return Machine(dataclasses.replace(subject.system, steps=steps), subject.ranges)


def _factors(group: Group, scales: Mapping[str, float]) -> Array:
    return np.array([scale(q.unit, scales) for q in group] or [1.0])


def _observed(before: Array, after: Array) -> Array:
    """Return the measured factor of each result without a stated unit, such as a margin."""
    nonzero = np.abs(before).argmax(axis=0)
    columns = np.arange(before.shape[1])
    top, bottom = after[nonzero, columns], before[nonzero, columns]
    return np.where(bottom == 0, 1.0, np.abs(top) / np.where(bottom == 0, 1.0, np.abs(bottom)))


def _results(system: System, request: Request) -> list[str] | None:
    """Return the units of a function's results, with None for margins."""
    own = {f.name: [q.unit for q, _ in f.results] for f in system.functions}
    if request.name in own:
        return own[request.name]
    parts = [_units(system, request, name) for name, _ in request.results]
    return None if None in parts else [unit for part in parts if part is not None for unit in part]


def _units(system: System, request: Request, name: str) -> list[str] | None:
    chart = system.coordinates
    q, n = (chart.states, chart.inputs) if chart else (system.states, system.inputs)
    memory = request.law.memory if request.law else ()
    groups = {
        "x": system.states, "u": system.inputs, "y": system.outputs, "r": system.references,
        "q": q, "n": n, "q_next": q, "u_cmd": system.inputs, "x_seen": system.states, "seen": system.seen,
        "x_step": system.states, "x_after": system.states, "z": memory, "z_next": memory,
    }  # fmt: skip
    integrated = (*q, *memory) if request.law and not request.law.period else tuple(q)
    rates = {"dx": tuple(system.states), "dq": integrated, "dz": tuple(memory)}
    if name in rates:
        return [f"{quantity.unit}/s" for quantity in rates[name]]
    if name == "derived":
        (group,) = request.arguments
        return [p.unit for p in group if p.name in formulas(group)]
    return [quantity.unit for quantity in groups[name]] if name in groups else None
