# SPDX-License-Identifier: Apache-2.0
"""Models, laws and loops as python-control systems."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from mehvar.base.capabilities import INTEGRATED, Operation, refuse
from mehvar.base.errors import bad_value
from mehvar.base.manifest import Controller, Manifest, Quantity
from mehvar.base.names import identifier

from ..functions import FloatArray, Functions
from ..linear import LinearSystem
from .replacement import library


def state_space(system: LinearSystem) -> Any:
    """Return a linear system as a labelled `control.StateSpace`.

    Raises
    ------
    InputError
        If python-control is not installed, or the system has leading axes.
    """
    control = library("control", "control", "to_control")
    if system.A.ndim != 2:
        raise bad_value("x, u, p", system.A.shape[:-2], "one point, without leading axes")
    step = 0 if system.period is None else float(system.period)
    names = {"states": system.states, "inputs": system.inputs, "outputs": _distinct(system.outputs, system)}
    return control.ss(*system, step, **{kind: list(texts) for kind, texts in names.items()})


def _distinct(outputs: tuple[str, ...], system: LinearSystem) -> tuple[str, ...]:
    """Return output names that differ from the inputs' names, as python-control requires."""
    return tuple(f"{name}_out" if name in system.inputs else name for name in outputs)


def plant_system(manifest: Manifest, functions: Functions, p: FloatArray) -> Any:
    """Return the plant as a `control.NonlinearIOSystem` with inputs u and outputs x."""
    refuse(manifest, Operation.NLSYS)
    rhs = functions["rhs"]

    def update(_t: float, x: FloatArray, u: FloatArray, _more: Mapping[str, object]) -> Any:
        return rhs(x, u, p)

    return _system(manifest.model, update, None, manifest.states, manifest.inputs, manifest.states)


def law_system(manifest: Manifest, functions: Functions, law: Controller, p: FloatArray, c: FloatArray) -> Any:
    """Return a law with inputs x and r or, with memory, first the plant's input v of the previous sample."""
    INTEGRATED.refuse(manifest, Operation.NLSYS, law)
    call, nx, nz = functions[identifier(law.name)], len(manifest.seen), len(law.memory)
    inputs = (*manifest.seen, *manifest.references)
    if not law.memory:

        def command(_t: float, _z: FloatArray, v: FloatArray, _more: Mapping[str, object]) -> Any:
            return call(v[:nx], v[nx:], p, c)

        return _system(law.name, None, command, (), inputs, manifest.inputs, _period(manifest, law, p))
    nr = len(manifest.references)

    def both(z: FloatArray, v: FloatArray) -> Any:
        return call(v[:nx], v[nx : nx + nr], v[nx + nr :], z[:nz], p, c)

    applied = tuple(replace(q, name=f"applied_{q.name}") for q in manifest.inputs)
    return _system(
        law.name,
        lambda _t, z, v, _more: both(z, v)[1],
        lambda _t, z, v, _more: both(z, v)[0],
        law.memory,
        (*inputs, *applied),
        manifest.inputs,
        _period(manifest, law, p),
    )


def loop_system(manifest: Manifest, functions: Functions, law: Controller, p: FloatArray, c: FloatArray) -> Any:
    """Return the closed loop of a continuous law with inputs r and outputs x.

    Raises
    ------
    InputError
        For a sampled law, because python-control cannot connect sampled and continuous systems.
    """
    if law.period is not None:
        raise bad_value(
            "controller", law.name, "a continuous law; to_nlsys(part='law') has the sampled one, simulate runs the loop"
        )
    refuse(manifest, Operation.NLSYS, law)
    rhs, call, actuate = functions["rhs"], functions[identifier(law.name)], functions.get("actuate")
    measure, quiet = functions["measure"] if manifest.measured else None, np.zeros(len(manifest.noise))

    def update(_t: float, x: FloatArray, r: FloatArray, _more: Mapping[str, object]) -> Any:
        u = call(x if measure is None else measure(x, quiet, p), r, p, c)
        return rhs(x, u if actuate is None else actuate(x, u, p), p)

    name = f"{manifest.model} under {law.name}"
    return _system(name, update, None, manifest.states, manifest.references, manifest.states)


def _period(manifest: Manifest, law: Controller, p: FloatArray) -> float:
    names = [q.name for q in manifest.parameters]
    return float(p[names.index(law.period)]) if law.period else 0.0


def _system(
    name: str,
    update: Any,
    output: Any,
    states: tuple[Quantity, ...],
    inputs: tuple[Quantity, ...],
    outputs: tuple[Quantity, ...],
    step: float = 0.0,
) -> Any:
    """Return a nonlinear system of python-control; `step` is its period in s, 0 for continuous time."""
    control = library("control", "control", "to_nlsys")
    groups = {"states": states, "inputs": inputs, "outputs": outputs}
    labels = {kind: [q.name for q in group] for kind, group in groups.items()}
    return control.nlsys(update, output, name=identifier(name.replace(" ", "_")), dt=step, **labels)
