# SPDX-License-Identifier: Apache-2.0
"""manifest.json: names, defaults, bounds, scenarios and hashes, all that the runtime needs to know of a model."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any

from mehvar.models.system import Condition, Controller, Group, Metric, Output, Parameter, Scenario, System

from .code.files import PrintedFunction, file_of, model_hash
from .functions.requests import reference_moves

SCHEMA = 1


def manifest(
    system: System, functions: Sequence[PrintedFunction], inputs: Mapping[str, str], files: Mapping[str, str]
) -> dict[str, Any]:
    """Return the manifest of a generated model.

    Parameters
    ----------
    system : System
        What was generated.
    functions : sequence of PrintedFunction
        Its functions.
    inputs, files : mapping of str to str
        SHA-256 of every source file it depends on and of every other file that was written.
    """
    return {
        "schema": SCHEMA,
        "model": system.name,
        "title": system.title,
        "source": system.source,
        "structure": dict(system.structure),
        "hash": model_hash(system, functions),
        "states": _quantities(system.states),
        "inputs": _quantities(system.inputs),
        "references": _quantities(system.references),
        "outputs": _quantities(system.outputs),
        "coordinates": _quantities(system.coordinates.states) if system.coordinates else [],
        "parameters": _parameters(system.parameters),
        "scenario_parameters": _parameters(system.scenario_parameters),
        "controllers": {law.name: _controller(law) for law in system.controllers},
        "limits": _messages(system.limits),
        "constraints": _messages(system.constraints),
        "reference_constant": not reference_moves(system),
        "choices": {c.name: {"values": list(c.values), "description": c.description} for c in system.choices},
        "noise": _quantities(system.sensor.noise) if system.sensor else [],
        "scenarios": {scenario.name: _scenario(scenario) for scenario in system.scenarios},
        "metrics": {metric.name: _metric(metric) for metric in system.metrics},
        "functions": {f.name: _function(system.name, f) for f in functions},
        "versions": {package: version(package) for package in ("casadi", "sympy")},
        "inputs_sha256": dict(sorted(inputs.items())),
        "files_sha256": dict(sorted(files.items())),
    }


def _quantities(group: Group) -> list[dict[str, str]]:
    return [{"name": q.name, "unit": q.unit, "description": q.description} for q in group]


def _parameters(group: Group) -> list[dict[str, Any]]:
    return [_parameter(q) for q in group if isinstance(q, Parameter)]


def _parameter(q: Parameter) -> dict[str, Any]:
    formula = isinstance(q.default, str)
    return {
        "name": q.name,
        "unit": q.unit,
        "default": None if formula else q.default,
        "formula": q.default if formula else None,
        "lower": _finite(q.bounds.lower),
        "upper": _finite(q.bounds.upper),
        "lower_open": q.bounds.lower_open,
        "upper_open": q.bounds.upper_open,
        "source": q.source,
        "description": q.description,
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _controller(law: Controller) -> dict[str, Any]:
    return {
        "title": law.title,
        "memory": _quantities(law.memory),
        "period": law.period or None,
        "delay": law.delay or None,
        "bears_loss": law.bears_loss,
        "parameters": _parameters(law.parameters),
        "constraints": _messages(law.constraints),
        "outputs": [_output(output) for output in law.outputs],
        "warnings": [{"message": w.message, "shown": len(w.shown)} for w in law.warnings],
    }


def _output(output: Output) -> dict[str, Any]:
    q = output.quantity
    return {"name": q.name, "unit": q.unit, "description": q.description, "at_most": _finite(output.at_most)}


def _messages(conditions: Sequence[Condition]) -> list[str]:
    return [condition.message for condition in conditions]


def _scenario(scenario: Scenario) -> dict[str, Any]:
    expect = {law: {k: _finite(v) for k, v in values.items()} for law, values in scenario.expect.items()}
    return {
        "title": scenario.title,
        "duration": scenario.duration,
        "step": scenario.step,
        "set": dict(scenario.values),
        "controllers": {law: dict(values) for law, values in scenario.controllers.items()},
        "expect": expect,
    }


def _metric(metric: Metric) -> dict[str, Any]:
    return {
        "kind": metric.kind,
        "of": list(metric.of),
        "band": metric.band,
        "since": metric.since,
        "until": _finite(metric.until),
        "unit": metric.unit,
        "description": metric.description,
    }


def _function(model: str, f: PrintedFunction) -> dict[str, Any]:
    return {
        "description": f.description,
        "args": [[name, size] for name, size in f.arguments],
        "results": [[name, size] for name, size in f.results],
        "operations": f.operations,
        "file": file_of(model, f.part),
    }
