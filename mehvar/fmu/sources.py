# SPDX-License-Identifier: Apache-2.0
"""The C of an FMU: the generated files, our integrators, and a header that says how they belong together."""

from __future__ import annotations

from mehvar.manifest import file_of
from mehvar.names import identifier
from mehvar.runtime.compiling.library import native_headers, native_sources
from mehvar.runtime.model.generated import generated_text
from mehvar.runtime.run.calls import loop_calls, model_fields
from mehvar.runtime.run.options import INTEGRATORS, RunOptions, first_integrator

from .variables import KINDS, Subject

_GROUPS = ("T", "P", "C", "R", "U", "Q", "D", "X", "Y", "Z", "M")
UNITS = ("unit.c", "jacobians.c")
"""The files that are compiled."""
_UNOPTIMISED = (
    '#if defined __clang__\n#pragma clang optimize off\n#elif defined __GNUC__\n#pragma GCC optimize ("O0")\n#endif\n'
)
"""Before the derivatives, which are long and rarely called: compiling them counts for more than running them."""
_CLASSES = {"parameter": "p", "input": "i", "state": "s", "time": "t"}


def c_sources(subject: Subject, version: str, token: str) -> dict[str, str]:
    """Return the files of the folder `sources`, of which `UNITS` are compiled.

    Parameters
    ----------
    subject : Subject
        Model and law.
    version : str
        "2.0" or "3.0".
    token : str
        What an importer proves with that description and binary belong together.
    """
    manifest = subject.model.manifest
    files = [file_of(manifest.model, "jac" if subject.kind != "loop" else "loops_jac")]
    names = (f"{manifest.model}.h", file_of(manifest.model, ""), *files)
    generated = {name: generated_text(manifest, name) for name in names}
    adapter = f"fmi{version[0]}.c"
    units = [file_of(manifest.model, ""), "tableaux.c", adapter]
    native = native_sources("step/*.h", "single/*.[ch]", "methods/*.[ch]", "methods/*.inc", "random/*.h", "fmu/core.h")
    standard = native_sources(f"fmu/{adapter}", f"fmu/fmi/fmi{version[0]}*.h")
    return {
        **native_headers(),
        **native,
        **standard,
        **generated,
        "fmu_model.h": _header(subject, token),
        "unit.c": "".join(f'#include "{name}"\n' for name in units),
        "jacobians.c": _UNOPTIMISED + "".join(f'#include "{name}"\n' for name in files),
    }


def _header(subject: Subject, token: str) -> str:
    """Return the text of fmu_model.h; native/fmu/core.h says what its names are."""
    manifest, options = subject.model.manifest, RunOptions()
    sizes = {
        "NP": "P", "NC": "C", "NR": "R", "NU": "U", "NQ": "Q", "NY": "Y", "NZ": "Z", "NM": "M",
    }  # fmt: skip
    defines: dict[str, object] = {f"FMU_{name}": len(subject.groups[group]) for name, group in sizes.items()}
    defines |= {
        "FMU_NX": len(manifest.states),
        "FMU_NE": len(manifest.noise),
        "FMU_SEEN": len(manifest.seen),
        "FMU_KIND": KINDS.index(subject.kind),
        "FMU_VALUES": len(subject.variables),
        "FMU_TOKEN": f'"{token}"',
        "FMU_METHOD": INTEGRATORS.index(first_integrator(options.method)),
        "FMU_RTOL": repr(options.rtol),
        "FMU_ATOL": repr(options.atol),
        "FMU_MAX_STEPS": options.max_steps,
        "FMU_OUTPUTS": _symbol(subject, "outputs"),
    }
    defines |= {f"FMU_V_{group}": subject.first(group) for group in _GROUPS}
    if not subject.groups["X"]:
        defines["FMU_V_X"] = "FMU_V_Q"
    if subject.law and subject.law.period:
        names = [q.name for q in manifest.parameters]
        defines["FMU_PERIOD"] = names.index(subject.law.period)
    start = ", ".join(repr(v.start) for v in subject.variables)
    classes = "".join(_CLASSES.get(v.role, "-") for v in subject.variables)
    lines = [f'#include "{manifest.model}.h"', "", *(f"#define {name} {value}" for name, value in defines.items())]
    lines += [f"#define FMU_MODEL(m) {_assignments(subject)}", f"#define FMU_JACOBIANS{_jacobians(subject)}"]
    if subject.law and subject.law.memory:
        call = _symbol(subject, f"{identifier(subject.law.name)}_start")
        lines.append(f"#define FMU_START(x, r, p, c, z) {call}(x, r, p, c, z)")
    lines += ["", f"static const double fmu_start[] = {{{start}}};", f'static const char fmu_class[] = "{classes}";']
    return "\n".join(lines) + "\n"


def _symbol(subject: Subject, name: str) -> str:
    model = subject.model.manifest.model
    return f"{identifier(model)}_{identifier(name)}"


def _assignments(subject: Subject) -> str:
    """Return the C statement that fills in the addresses of an mv_model."""
    manifest = subject.model.manifest
    if subject.law is None:
        fields = {"rhs": "rhs", "limits": "limits"} if manifest.limits else {"rhs": "rhs"}
        names = {field: _symbol(subject, name) for field, name in fields.items()} | {"law": "fmu_input"}
    else:
        calls = loop_calls(manifest, subject.law, "", subject.kind == "sampled")
        given = ("reference", "outputs")  # by the importer, and by our own header
        functions = model_fields(calls, manifest, subject.law)
        names = {field: _symbol(subject, f.name) for field, f in functions.items() if field not in given}
    return ", ".join(f"(m)->{field} = {name}" for field, name in names.items())


def _jacobians(subject: Subject) -> str:
    """Return parameters and body of the macro that evaluates d(dq)/dq and d(dq)/d(inputs)."""
    if subject.kind == "loop":
        assert subject.law is not None
        function = subject.model.functions[f"{identifier(subject.law.name)}_loop_jac"].function
        by = {"J_q": "J_q", "J_r": "J_u"}  # the inputs of a loop are the references, where it has any
        results = ", ".join(by[result.name] for result in function.results)
        return f"(q, u, r, p, c, J_q, J_u) {_symbol(subject, function.name)}(q, r, p, c, {results})"
    by_x = f"{_symbol(subject, 'jac_x')}(q, u, p, J_q)"
    by_u = f"{_symbol(subject, 'jac_u')}(q, u, p, J_u)" if subject.kind == "plant" else "(void)(J_u)"
    return f"(q, u, r, p, c, J_q, J_u) {by_x}, {by_u}"
