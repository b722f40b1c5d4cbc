# SPDX-License-Identifier: Apache-2.0
"""C code of a batch kernel: native/batch with the definitions of a model, law and method."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from mehvar.base.manifest import Controller, Event, Function, Manifest, Metric
from mehvar.base.names import identifier

from ..compiling.library import load_native, native_headers, native_sources
from ..compiling.structures import structures
from ..model.generated import generated_text
from ..run.calls import events_of, loop_calls
from ..run.metrics import metrics_of
from ..run.options import INTEGRATORS, STIFF, Integrator
from ..run.problem import STAGES

_RESULTS = {
    "reference": "r",
    "rhs": "dx",
    "loop": "dq",
    "rhs_jac": "J",
    "loop_jac": "J_q J_r",
    "observe": "x u u_cmd",
    "outputs": "y",
    "limits": "margin",
    "law": "u_cmd z_next",
    "actuate": "u",
    "measure": "x_seen",
    "diffuse": "x_step",
    "jump": "x_after",
    "input_delays": "d",
    "project": "q_next",
    "mass": "diagonal",
    "guards": "g",
    "loop_guards": "g",
    "resets": "x_next",
    "start": "z",
    "to_coordinates": "q",
    "from_coordinates": "x",
}
"""Names of results in the calls of native/step/calls.h and native/batch/block.h; arguments are named as in the
manifest.
"""

_INSTEAD = {
    "observe": "mv_copy(u_cmd, u, NU)",
    "actuate": "mv_copy(u, u_cmd, NU)",
    "measure": "mv_copy(x_seen, x, NX)",
    "to_coordinates": "mv_copy(q, x, NX)",
    "from_coordinates": "mv_copy(x, q, NX)",
}
"""Code in place of a call if the model lacks the function or its last result."""


_OWN = {
    "CALL_LAW": "mv_copy(u_cmd, m->u_own, NU); mv_copy(z_next, m->z_own, NZ)",
    "CALL_START": "mv_copy(z, m->z_own, NZ)",
    "LOCKSTEP": "",
}
"""Values that a Python law sets for the current sample; see native/batch/lockstep.h."""


@dataclass(frozen=True)
class KernelLoop:
    """Loop of a kernel, with law, variant of the plant, method, and stiffness test."""

    manifest: Manifest
    controller: Controller
    suffix: str
    sampled: bool
    method: Integrator
    stiff_test: bool = False

    @cached_property
    def sources(self) -> dict[str, str]:
        """C files of the kernel by name; batch.c is compiled. A generated folder may lack a function: InputError."""
        sources = native_headers() | native_sources("step/*.h", "batch/*.[ch]", "random/*.h")
        generated = {name: generated_text(self.manifest, name) for name in _loop_files(self)}
        return sources | generated | {"kernel.h": _kernel(self)}

    @cached_property
    def stiff(self) -> KernelLoop:
        """Loop for stiff runs."""
        return replace(self, method=STIFF, stiff_test=False)

    @property
    def calls(self) -> dict[str, Function]:
        """Generated functions that the loop calls."""
        return loop_calls(self.manifest, self.controller, self.suffix, self.sampled, self.method)

    @property
    def generated(self) -> bool:
        """True for a law of the model, False for one in Python."""
        return self.controller.name in self.manifest.controllers

    @property
    def variables(self) -> tuple[str, ...]:
        """Names of recorded variables, in the order of a result file's columns."""
        manifest = self.manifest
        names = [q.name for q in manifest.states] + [f"u_{q.name}" for q in manifest.inputs]
        if self.records_command:
            names += [f"u_cmd_{q.name}" for q in manifest.inputs]
        return (*names, *(q.name for q in manifest.outputs), *(q.name for q in self.controller.memory))

    @property
    def metrics(self) -> tuple[Metric, ...]:
        """Metrics of a run."""
        return tuple(metrics_of(self.manifest, self.controller.name, self.variables).values())

    @property
    def events(self) -> tuple[Event, ...]:
        """Events of a run."""
        return events_of(self.manifest, self.controller, self.sampled)

    @property
    def records_command(self) -> bool:
        """True if commanded and acting inputs may differ."""
        return self.sampled or "actuate" in self.manifest.functions


def generated_sources(manifest: Manifest) -> dict[str, str]:
    """Return the C files of a model that all kernels include, by name.

    Raises
    ------
    InputError
        If a file cannot be read, or differs from the generated one.
    """
    return {name: generated_text(manifest, name) for name in _files(manifest)}


def _kernel(loop: KernelLoop) -> str:
    """Return the model's code and definitions for native/batch/block.h."""
    manifest, files = loop.manifest, _loop_files(loop)
    lines = ["/* SPDX-License-Identifier: Apache-2.0 */", '#include "mehvar/private/arithmetic.h"']
    functions = (f for f in manifest.functions.values() if f.file in files)
    lines += [f"static {_declaration(manifest, f)};" for f in functions]
    lines += [f'#include "{file}"' for file in files if file.endswith(".c")]
    tables, method = _method(loop.method)
    definitions = _sizes(loop) | _calls(loop) | method
    lines += tables
    return "\n".join([*lines, *(f"#define {name} {text}" for name, text in definitions.items())]) + "\n"


def _calls(loop: KernelLoop) -> dict[str, str]:
    """Return the code of each call, and of the precomputed part in the model's structure."""
    manifest = loop.manifest
    functions = {identifier(name): function for name, function in manifest.functions.items()}
    parts = {call: _parts(functions, function) for call, function in loop.calls.items()}
    constants = [(call, part.results[0]) for call, group in parts.items() for part in group.values()]
    definitions = {"CONSTANTS": " ".join(f"real {array.name}_{call}[{array.size}];" for call, array in constants)}
    for step in ("prepare", "hold"):
        statements = [_statement(manifest, call, group[step]) for call, group in parts.items() if step in group]
        definitions[f"CALL_{step.upper()}"] = "; ".join(statements)
    if not loop.generated:
        definitions["CONSTANTS"] += " real u_own[NU + 1], z_own[NZ + 1];"
    for call, results in _RESULTS.items():
        function = loop.calls.get(call)
        if parts.get(call) and function is not None:
            function = functions[f"{identifier(function.name)}_prepared"]
        definitions[f"CALL_{call.upper()}"] = _call(manifest, call, function, results.split())
    return definitions if loop.generated else definitions | _OWN


def _parts(functions: Mapping[str, Function], function: Function) -> dict[str, Function]:
    """Return the precomputed parts of a function: once per run, and at each change of the input."""
    names = {step: f"{identifier(function.name)}_{step}" for step in ("prepare", "hold")}
    return {step: functions[name] for step, name in names.items() if name in functions}


def _files(manifest: Manifest) -> list[str]:
    """Return the files of the model that all kernels include."""
    names = {f.file for f in manifest.functions.values() if not f.file.endswith("_jac.c")}
    return [*sorted(names), f"{manifest.model}.h"]


def _loop_files(loop: KernelLoop) -> list[str]:
    """Return the files of the model that this kernel includes, with Jacobians if its method needs them."""
    files = _files(loop.manifest)
    return [*files, *sorted({function.file for function in loop.calls.values()} - {*files})]


def _sizes(loop: KernelLoop) -> dict[str, str]:
    """Return the macros with the sizes and features for which the kernel is compiled, and the table of its events."""
    manifest, calls = loop.manifest, loop.calls
    states = len(manifest.states)
    numbers = {
        "NX": states,
        "NU": len(manifest.inputs),
        "NY": len(manifest.outputs),
        "NZ": len(loop.controller.memory),
        "NR": len(manifest.references),
        "SEEN": len(manifest.seen),
        "NQ": states if loop.sampled else calls["loop"].results[0].size,
        "NP": len(manifest.parameters),
        "NC": len(loop.controller.parameters),
        "NS": len(manifest.scenario_parameters),
        "NOISE": len(manifest.noise),
        "WIENER": len(manifest.wiener),
        "JUMP": manifest.jump,
        "STRONG": loop.method == "platen",
        "STIFF_TEST": loop.stiff_test,
        "LIMITS": len(manifest.limits),
        "STATE_LIMITS": manifest.limits_of_state,
        "EVENTS": len(loop.events),
        "SAMPLED": loop.sampled,
        "DELAYED": bool(manifest.delays),
        "RECORDS_COMMAND": loop.records_command,
        "PROJECTED": "project" in calls,
        "ALGEBRAIC": manifest.algebraic,
        "REFERENCE_CONSTANT": manifest.reference_constant,
    }
    table = ", ".join("{{{}, {}, {}}}".format(*event.numbers) for event in loop.events) or "{0, 0, 0}"
    events = {"EVENT(e, k)": f"((const int[][3]){{{table}}}[e][k])"}
    return {name: str(int(value)) for name, value in numbers.items()} | events


def _declaration(manifest: Manifest, function: Function) -> str:
    arguments = ["const real *"] * len(function.arguments) + ["real *"] * len(function.results)
    return f"void {manifest.c_name(function.name)}({', '.join(arguments)})"


def _call(manifest: Manifest, call: str, function: Function | None, results: Sequence[str]) -> str:
    """Return the code of a call; empty if the loop never makes it."""
    present = results[: len(function.results)] if function is not None else ()
    statements = [] if function is None else [_statement(manifest, call, function, present)]
    if call in _INSTEAD and len(present) < len(results):
        statements.append(_INSTEAD[call])
    return "; ".join(statements)


def _statement(manifest: Manifest, call: str, function: Function, results: Sequence[str] = ()) -> str:
    """Return the C call of a generated function; unnamed results go into the model's structure."""
    arguments = [_expression(array.name, call) for array in function.arguments]
    arguments += results or [_expression(array.name, call) for array in function.results]
    return f"{manifest.c_name(function.name)}({', '.join(arguments)})"


def _expression(name: str, call: str) -> str:
    """Return the C expression of an argument array; the model's structure has parameters and precomputed values."""
    if name in ("h", "w"):
        return f"m->{name}_{call}"
    return {"p": "m->p", "c": "m->c", "s": "m->s", "t": "&t", "seen": "x", "event": "&event"}.get(name, name)


def _method(method: Integrator) -> tuple[list[str], dict[str, str]]:
    """Return the coefficients of a method: tables, and definitions that use them or contain its sums."""
    kind: Any = structures("methods/tableaux.h")["mv_tableau"]
    tableau = (kind * len(INTEGRATORS)).in_dll(load_native(), "mv_tableaux")[INTEGRATORS.index(method)]
    stages = tableau.stages
    estimated = str(int(bool(tableau.e or tableau.d)))
    common = {"STAGES": str(stages), "ORDER": str(tableau.order), "ESTIMATED": estimated, **_dense(tableau)}
    if tableau.d:
        return _implicit(tableau, common)
    return [], common | {
        "END_IN_ERROR": str(tableau.end_in_error),
        "THIRD": str(int(bool(tableau.e3))),
        "STAGE_SUMS": _stages(tableau, range(1, stages)),
        "END_SUM": _sum(_numbers(tableau.b, stages)),
        "ERROR_SUM": _sum(_numbers(tableau.e, stages + tableau.end_in_error) if tableau.e else ()),
        "THIRD_ERROR_SUM": _sum(_numbers(tableau.e3, stages) if tableau.e3 else ()),
        "GAMMA": "0",
        **{f"IMPLICIT_{name}": "0" for name in ("A(s, j)", "G(s, j)", "C(s)", "D(s)")},
    }


def _stages(tableau: Any, numbers: range) -> str:
    """Return the weighted sums of slopes, stage by stage."""
    if not numbers:
        return "(void)k, (void)h;"
    a, c = _rows(tableau.a, numbers.stop), _numbers(tableau.c, numbers.stop)
    return _lines(f"STAGE({i}, {c[i]!r}, {_sum(a[i][:i])})" for i in numbers)


def _dense(tableau: Any) -> dict[str, str]:
    """Return the sums of dense output, over slopes or, shifted by one, over stages of an implicit step."""
    shift = [0.0] * bool(tableau.d)
    rows = [shift + row[: tableau.slopes] for row in _rows(tableau.dense_g, tableau.dense)]
    return {
        "DENSE": str(tableau.dense),
        "SLOPES": str(tableau.slopes),
        "DENSE_STAGES": _stages(tableau, range(tableau.stages + 1, tableau.slopes)),
        "DENSE_SUMS": _lines(f"TERM({j}, {_sum(row)})" for j, row in enumerate(rows)) or "(void)k, (void)sums;",
    }


def _implicit(tableau: Any, common: dict[str, str]) -> tuple[list[str], dict[str, str]]:
    """Return the tables of an implicit method, and the macros of the step that they replace."""
    stages = tableau.stages - 1
    rows = {
        "a": _rows(tableau.a, stages),
        "g": _rows(tableau.g, stages),
        "cd": [_numbers(tableau.c, stages), _numbers(tableau.d, stages)],
    }
    tables = [
        f"static const double implicit_{name}[{len(table)}][{stages}] = "
        f"{{{', '.join(f'{{{str(row[:stages])[1:-1]}}}' for row in table)}}};"
        for name, table in rows.items()
    ]
    sums = dict.fromkeys(("END_SUM", "ERROR_SUM", "THIRD_ERROR_SUM"), "SPLAT(0)")
    return tables, common | sums | {
        "END_IN_ERROR": "0",
        "THIRD": "0",
        "STAGE_SUMS": "(void)k;",
        "GAMMA": repr(rows["cd"][1][0]),
        "IMPLICIT_A(s, j)": "implicit_a[s][j]",
        "IMPLICIT_G(s, j)": "implicit_g[s][j]",
        "IMPLICIT_C(s)": "implicit_cd[0][s]",
        "IMPLICIT_D(s)": "implicit_cd[1][s]",
    }


def _lines(parts: Iterable[str]) -> str:
    return " \\\n    ".join(["", *parts])


def _rows(address: int | None, count: int) -> list[list[float]]:
    numbers = _numbers(address, count * STAGES) if address else []
    return [numbers[i * STAGES : (i + 1) * STAGES] for i in range(count)]


def _numbers(address: int, count: int) -> list[float]:
    return list((ctypes.c_double * count).from_address(address))


def _sum(weights: Sequence[float]) -> str:
    return " + ".join(f"K({w!r}) * k[{j}][i]" for j, w in enumerate(weights) if w) or "SPLAT(0)"
