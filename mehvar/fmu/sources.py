# SPDX-License-Identifier: Apache-2.0
"""C sources of an FMU: generated files, integrators, and a header that connects them."""

from __future__ import annotations

from mehvar.base.manifest import Manifest, file_of
from mehvar.base.names import identifier
from mehvar.runtime.compiling.library import native_headers, native_sources
from mehvar.runtime.model.generated import generated_text
from mehvar.runtime.run.calls import loop_calls, model_fields
from mehvar.runtime.run.options import INTEGRATORS, RunOptions, first_integrator

from .conditions import refusals
from .variables import KINDS, NO_LAW, Subject

_GROUPS = ("T", "P", "C", "R", "U", "Q", "D", "X", "Y", "Z", "M", "G")
UNITS = ("unit.c", "tangents.c")
"""C files of an FMU that are compiled."""
_UNOPTIMISED = (
    '#if defined __clang__\n#pragma clang optimize off\n#elif defined __GNUC__\n#pragma GCC optimize ("O0")\n#endif\n'
)
"""Compiler flags for derivatives, which are rarely called, so that compile time matters more than speed."""
_CLASSES = {
    "parameter": "p",
    "input": "i",
    "state": "s",
    "time": "t",
    "derivative": "d",
    "output": "o",
    "discrete": "o",
}


def c_sources(subject: Subject, version: str, token: str) -> dict[str, str]:
    """Return the files of the folder `sources`; those in `UNITS` are compiled.

    Parameters
    ----------
    subject : Subject
        Model and law.
    version : str
        "2.0" or "3.0".
    token : str
        Token by which an importer checks that description and binary belong together.
    """
    manifest = subject.model.manifest
    names = (f"{manifest.model}.h", file_of(manifest.model, ""))
    generated = {name: generated_text(manifest, name) for name in names}
    adapter = f"fmi{version[0]}.c"
    units = [file_of(manifest.model, ""), "tableaux.c", adapter]
    native = native_sources("step/*.h", "single/*.[ch]", "methods/*.[ch]", "methods/*.inc", "random/*.h", "fmu/*.h")
    standard = native_sources(f"fmu/{adapter}", f"fmu/fmi/fmi{version[0]}*.h")
    return {
        **native_headers(),
        **native,
        **standard,
        **generated,
        "fmu_model.h": _header(subject, token),
        "fmu_refusals.h": "\n".join(refusals(subject)) + "\n",
        "unit.c": "".join(f'#include "{name}"\n' for name in units),
        "tangents.c": _UNOPTIMISED + _tangents(manifest),
    }


def _tangents(manifest: Manifest) -> str:
    """Return C that compiles the generated functions a second time for dual numbers, under other names."""
    own = [f.name for f in manifest.functions.values() if f.file == file_of(manifest.model, "")]
    names = [f"{identifier(manifest.model)}_{identifier(name)}" for name in own]
    units = ("dual.h", file_of(manifest.model, ""), "tangents.h")
    return "".join((*(f"#define {name} {name}_dual\n" for name in names), *(f'#include "{unit}"\n' for unit in units)))


def _header(subject: Subject, token: str) -> str:
    """Return the text of fmu_model.h; native/fmu/core.h explains its names."""
    manifest, options = subject.model.manifest, RunOptions()
    sizes = {
        "NP": "P", "NC": "C", "NR": "R", "NU": "U", "NQ": "Q", "NY": "Y", "NZ": "Z", "NM": "M", "NV": "G",
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
        "FMU_OUTPUTS": manifest.c_name("outputs"),
        "FMU_STEP": repr(subject.step),
        "FMU_DURATION": repr(subject.duration),
    }
    defines |= {f"FMU_V_{group}": subject.first(group) for group in _GROUPS}
    if not subject.groups["X"]:
        defines["FMU_V_X"] = "FMU_V_Q"
    if subject.law and subject.law.period:
        names = [q.name for q in manifest.parameters]
        defines["FMU_PERIOD"] = names.index(subject.law.period)
    start = ", ".join(repr(v.start) for v in subject.variables)
    classes = "".join(_CLASSES.get(v.role, "-") for v in subject.variables)
    lines = [f'#include "{manifest.model}.h"', ""]
    lines += [f"#define {name} {value}" for name, value in defines.items()]
    lines += [f"#define FMU_MODEL(m) {_assignments(subject)}"]
    if subject.law and subject.law.memory:
        call = manifest.c_name(f"{subject.law.name}_start")
        lines.append(f"#define FMU_START(x, r, p, c, z) {call}(x, r, p, c, z)")
    events = ", ".join(str(number) for event in subject.events for number in event.numbers)
    lines += ["", f"static const int32_t fmu_events[] = {{{events or 0}}};"]
    lines += [f"static const double fmu_start[] = {{{start}}};", f'static const char fmu_class[] = "{classes}";']
    return "\n".join(lines) + "\n"


def _assignments(subject: Subject) -> str:
    """Return the C statement that sets the function addresses of an mv_model."""
    manifest = subject.model.manifest
    given = ("reference", "outputs")  # by the importer, and by our own header
    plant = ("actuate", "measure") if subject.law is None else ()  # whose input is what acts
    law = subject.law or NO_LAW
    functions = model_fields(loop_calls(manifest, law, "", subject.kind != "loop"), manifest, law)
    names = {field: manifest.c_name(f.name) for field, f in functions.items() if field not in (*given, *plant)}
    names |= {"law": "fmu_input"} if subject.law is None else {}
    return ", ".join(f"(m)->{field} = {name}" for field, name in names.items())
