# SPDX-License-Identifier: Apache-2.0
"""The C text of a batch kernel: a model under one law by one method, around the loop in native/batch.c."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from mehvar.errors import InputError

from ..compiling.library import NATIVE, load_native, native_headers
from ..model.manifest import Controller, Function, Manifest, identifier
from ..run.options import METHODS, Method
from ..run.problem import STAGES

_FILES = ("batch.c", "batch.h", "batch_metrics.h", "batch_step.h", "noise.h", "philox.h")
_RK4_ERROR = (0.0, 0.0, 0.0, 1 / 6, -1 / 6)  # against the third-order method that ends with the slope at the end

_CALLS = {
    "rhs": ("x u", "dx"),
    "loop": ("q r", "dq"),
    "observe": ("q r", "x u u_cmd"),
    "outputs": ("x u r", "y"),
    "limits": ("x u", "margin"),
    "law": ("x r v z", "u_cmd z_next"),
    "actuate": ("x u_cmd", "u"),
    "measure": ("x e", "x_seen"),
    "project": ("q", "q_next"),
    "start": ("x r", "z"),
    "to_coordinates": ("x", "q"),
    "from_coordinates": ("q", "x"),
}
"""Arguments and results of what the loop calls; parameters come from the constants of the run."""

_INSTEAD = {
    "observe": "u_cmd = u NU",
    "actuate": "u = u_cmd NU",
    "measure": "x_seen = x NX",
    "to_coordinates": "q = x NX",
    "from_coordinates": "x = q NX",
}
"""What is copied where a model has no such function, or where it lacks the last result."""


@dataclass(frozen=True)
class Loop:
    """Which loop a kernel runs: a law, a variant of the plant, a method."""

    manifest: Manifest
    controller: Controller
    suffix: str
    sampled: bool
    method: Method

    @property
    def variables(self) -> tuple[str, ...]:
        """Names of what is recorded, in the order of the columns: as in a result file."""
        manifest = self.manifest
        names = [q.name for q in manifest.states] + [f"u_{q.name}" for q in manifest.inputs]
        if self.records_command:
            names += [f"u_cmd_{q.name}" for q in manifest.inputs]
        return (*names, *(q.name for q in manifest.outputs), *(q.name for q in self.controller.memory))

    @property
    def records_command(self) -> bool:
        """Whether the input that the law asks for may differ from the one that acts."""
        return self.sampled or "actuate" in self.manifest.functions


def kernel_sources(loop: Loop) -> dict[str, str]:
    """Return the C files of a kernel by name; batch.c is to be compiled.

    Raises
    ------
    InputError
        If the generated folder lacks a function.
    """
    sources = native_headers() | {name: (NATIVE / name).read_text(encoding="utf-8") for name in _FILES}
    for name in _files(loop.manifest):
        sources[name] = (loop.manifest.folder / name).read_text(encoding="utf-8")
    return sources | {"calls.h": _calls(loop), "stages.h": _stages(loop.method)}


def _roles(loop: Loop) -> dict[str, Function]:
    """Return the generated functions that stand behind the calls."""
    functions = {identifier(name): function for name, function in loop.manifest.functions.items()}
    law, charted = identifier(loop.controller.name), "to_coordinates" in functions
    names = {"outputs": "outputs", "reference": "reference"}
    if loop.manifest.limits:
        names["limits"] = "limits"
    if loop.sampled:
        names |= {"rhs": f"rhs{loop.suffix}", "law": law}
        names |= {name: name for name in ("actuate", "measure") if name in functions}
        names |= {"start": f"{law}_start"} if loop.controller.memory else {}
    else:
        names |= {"loop": f"{law}_loop{loop.suffix}", "observe": f"{law}_observe"}
        names |= {name: name for name in ("to_coordinates", "from_coordinates") if charted}
    if "project" in functions and not (loop.sampled and charted):
        names["project"] = "project"
    missing = [name for name in names.values() if name not in functions]
    if missing:
        raise InputError(f"the generated folder lacks the function {missing[0]}; generate the model again")
    return {role: functions[name] for role, name in names.items()}


def _calls(loop: Loop) -> str:
    """Return the sizes, the constants of a run, and the calls of generated functions."""
    manifest, roles = loop.manifest, _roles(loop)
    functions = {identifier(name): function for name, function in manifest.functions.items()}
    parts = {role: _parts(functions, function) for role, function in roles.items()}
    lines = ["/* SPDX-License-Identifier: Apache-2.0 */", '#include "mehvar/private/arithmetic.h"']
    lines += [f"static {_declaration(manifest, f)};" for f in functions.values() if f.file in _files(manifest)]
    lines += [f'#include "{file}"' for file in _files(manifest) if file.endswith(".c")]
    lines += [*_sizes(loop, roles), "typedef struct {"]
    lines += [f"    real {name}[N{name.upper()} + 1];" for name in "pcs"]
    for role, found in parts.items():
        lines += [f"    real {f.results[0].name}_{role}[{f.results[0].size}];" for f in found.values()]
    lines.append("} mv_constants;")
    for step, received in (("prepare", "r"), ("hold", "u")):
        lines += [
            f"static void mv_{step}(mv_constants *k, const real *{received})",
            "{",
            f"    (void)k; (void){received};",
        ]
        for role, found in parts.items():
            lines += [f"    {_invocation(manifest, role, found[step])};" for _ in range(step in found)]
        lines.append("}")
    lines += _reference(manifest, roles["reference"])
    for role in _CALLS:
        function = roles.get(role)
        if parts.get(role):
            function = functions[f"{identifier(roles[role].name)}_prepared"]
        lines += _call(manifest, role, function)
    return "\n".join(lines) + "\n"


def _parts(functions: Mapping[str, Function], function: Function) -> dict[str, Function]:
    """Return what is computed of a function before it is called: once per run, and when the input changes."""
    names = {step: f"{identifier(function.name)}_{step}" for step in ("prepare", "hold")}
    return {step: functions[name] for step, name in names.items() if name in functions}


def _files(manifest: Manifest) -> list[str]:
    """Return the files of the model that a kernel takes in."""
    names = {f.file for f in manifest.functions.values() if not f.file.endswith("_jac.c")}
    return [*sorted(names), f"{manifest.model}.h"]


def _sizes(loop: Loop, roles: Mapping[str, Function]) -> list[str]:
    manifest = loop.manifest
    nx, nu, ny, nz = (len(g) for g in (manifest.states, manifest.inputs, manifest.outputs, loop.controller.memory))
    commanded = nx + nu + (nu if loop.records_command else 0)
    numbers = {
        **{"NX": nx, "NU": nu, "NZ": nz, "NOISE": len(manifest.noise), "NR": len(manifest.references)},
        **{"NP": len(manifest.parameters), "NC": len(loop.controller.parameters)},
        **{"NS": len(manifest.scenario_parameters), "NQ": roles["loop"].results[0].size if not loop.sampled else nx},
        **{"U_COLUMN": nx, "U_CMD_COLUMN": nx + nu, "Y_COLUMN": commanded, "Z_COLUMN": commanded + ny},
        **{"COLUMNS": commanded + ny + nz, "LIMITS": len(manifest.limits)},
        **{"SAMPLED": loop.sampled, "RECORDS_COMMAND": loop.records_command, "PROJECTED": "project" in roles},
        **{"REFERENCE_CONSTANT": manifest.reference_constant, **_method_numbers(loop.method)},
    }
    return [f"#define {name} {int(value)}" for name, value in numbers.items()]


def _declaration(manifest: Manifest, function: Function) -> str:
    arguments = ["const real *"] * len(function.arguments) + ["real *"] * len(function.results)
    return f"void {_symbol(manifest, function.name)}({', '.join(arguments)})"


def _symbol(manifest: Manifest, name: str) -> str:
    return f"{identifier(manifest.model)}_{identifier(name)}"


def _given(name: str, role: str) -> str:
    """Return the C expression of an argument."""
    if name in ("p", "c", "s"):
        return f"k->{name}"
    return f"k->{name}_{role}" if name in ("h", "w") else name


def _invocation(manifest: Manifest, role: str, function: Function) -> str:
    arrays = (*function.arguments, *function.results)
    return f"{_symbol(manifest, function.name)}({', '.join(_given(a.name, role) for a in arrays)})"


def _reference(manifest: Manifest, function: Function) -> list[str]:
    given = ", ".join("&t" if a.name == "t" else _given(a.name, "") for a in function.arguments)
    return [
        "static inline void mv_call_reference(const mv_constants *k, real t, real *r)",
        f"{{ (void)k; (void)t; {_symbol(manifest, function.name)}({given}, r); }}",
    ]


def _call(manifest: Manifest, role: str, function: Function | None) -> list[str]:
    """Return a call with the same arguments and results for every model."""
    arguments, results = (text.split() for text in _CALLS[role])
    received = [f"const real *{name}" for name in arguments] + [f"real *{name}" for name in results]
    lines = [f"static inline void mv_call_{role}(const mv_constants *k, {', '.join(received)})", "{"]
    lines.append("    " + " ".join(f"(void){name};" for name in ("k", *arguments, *results)))
    found = [] if function is None else [r.name for r in function.results]
    if function is not None:
        given = [_given(a.name, role) for a in function.arguments]
        lines.append(f"    {_symbol(manifest, function.name)}({', '.join([*given, *results[: len(found)]])});")
    if role in _INSTEAD and len(found) < len(results):
        target, _, source, size = _INSTEAD[role].split()
        lines.append(f"    for (int i = 0; i < {size}; i++) {target}[i] = {source}[i];")
    return [*lines, "}"]


class _Tableau(ctypes.Structure):
    """Mirrors mv_tableau of tableaux.h."""

    _fields_ = (
        *((name, ctypes.c_int) for name in ("stages", "order", "end_in_error")),
        ("a", ctypes.POINTER(ctypes.c_double * STAGES)),
        *((name, ctypes.POINTER(ctypes.c_double)) for name in ("b", "c", "e", "e3")),
    )


def _tableau(method: Method) -> _Tableau:
    return (_Tableau * len(METHODS)).in_dll(load_native(), "mv_tableaux")[METHODS.index(method)]


def _method_numbers(method: Method) -> dict[str, int]:
    tableau = _tableau(method)
    end_in_error = tableau.end_in_error or method == "rk4"
    return {
        **{"STAGES": tableau.stages, "ORDER": tableau.order, "END_IN_ERROR": end_in_error},
        "THIRD": bool(tableau.e3),
    }


def _stages(method: Method) -> str:
    """Return the sums of a method over its nonzero coefficients."""
    tableau = _tableau(method)
    stages = tableau.stages
    lines = [
        "/* SPDX-License-Identifier: Apache-2.0 */",
        "static inline void mv_stages(mv_block *b, real h)",
        "{",
        "    real (*const k)[NQ] = b->k;",
    ]
    for i in range(1, stages):
        lines.append(f"    for (int i = 0; i < NQ; i++) b->stage[i] = b->q[i] + h * ({_sum(tableau.a[i][:i])});")
        lines.append(f"    mv_slope(b, b->t + K({tableau.c[i]!r}) * h, b->stage, k[{i}]);")
    lines.append(f"    for (int i = 0; i < NQ; i++) b->y[i] = b->q[i] + h * ({_sum(tableau.b[:stages])});")
    main = _RK4_ERROR if method == "rk4" else tableau.e[: stages + tableau.end_in_error]
    errors = {"mv_error": main} | ({"mv_third_error": tableau.e3[:stages]} if tableau.e3 else {})
    for name, weights in errors.items():
        lines += ["}", f"static inline real {name}(const real (*k)[NQ], int i)", "{", f"    return {_sum(weights)};"]
    return "\n".join([*lines, "}"]) + "\n"


def _sum(weights: Sequence[float]) -> str:
    return " + ".join(f"K({w!r}) * k[{j}][i]" for j, w in enumerate(weights) if w)
