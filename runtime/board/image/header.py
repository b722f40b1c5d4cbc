# SPDX-License-Identifier: Apache-2.0
"""C headers that describe a model and a law for the portable firmware."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mehvar.base.errors import unknown_name
from mehvar.base.manifest import Controller, Manifest
from mehvar.base.names import identifier

from ...model.parameters import Resolved

SUBSTEPS = 5
"""Runge-Kutta steps per period in the self-test."""
_RAW_NUMBERS = 18
"""Number of values in the paper's bare packet of 72 bytes."""
_LICENSE = "/* SPDX-License-Identifier: Apache-2.0 */"
_LAW_ARGUMENTS = (
    "const real *x, const real *r, const real *v, const real *z, const real *p, const real *c, real *u, real *z_next"
)


@dataclass(frozen=True)
class Layout:
    """Sizes and names of the data on the link, in C `float`.

    Attributes
    ----------
    inputs : tuple of str
        Payload of a step: measurements, references, and, for a law with memory, the inputs applied before.
    outputs : tuple of str
        The law's inputs to the plant.
    memory : tuple of str
        The law's memory z.
    sizes : tuple of int
        Sizes in HELLO: numbers in a step, its answer, z, p, c, s, x.
    hash : bytes
        Hash of model, law and layout.
    """

    model: str
    law: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    memory: tuple[str, ...]
    sizes: tuple[int, ...]
    hash: bytes


def layout(manifest: Manifest, law: Controller) -> Layout:
    """Return the layout of a model and a law."""
    applied = [f"{q.name}_applied" for q in manifest.inputs] if law.memory else []
    inputs = (*(q.name for q in manifest.seen), *(q.name for q in manifest.references), *applied)
    outputs = tuple(q.name for q in manifest.inputs)
    memory = tuple(q.name for q in law.memory)
    counts = (len(inputs), len(outputs), len(memory))
    groups = (manifest.parameters, law.parameters, manifest.scenario_parameters, manifest.states)
    numbers = (*counts, *(len(group) for group in groups))
    digest = hashlib.sha256(repr((manifest.hash, law.name, inputs, outputs, memory, numbers)).encode()).digest()[:16]
    return Layout(manifest.model, law.name, inputs, outputs, memory, numbers, digest)


def raw_numbers(link: Layout) -> int:
    """Return the number of values in a bare packet to the board; those after the inputs are zero."""
    return max(len(link.inputs), _RAW_NUMBERS)


def board_model_header(manifest: Manifest, law: Controller, period: float) -> str:
    """Return the text of mehvar/board_model.h: sizes and names, for the firmware and its users."""
    link, nr = layout(manifest, law), len(manifest.references)
    lines = [
        _LICENSE,
        f"/* {manifest.model} under {law.name}: what goes over the line. Written by mehvar board. */",
        "#ifndef MEHVAR_BOARD_MODEL_H",
        "#define MEHVAR_BOARD_MODEL_H",
        "",
        f'#define MV_BOARD_MODEL "{manifest.model}"',
        f'#define MV_BOARD_LAW "{law.name}"',
        f"#define MV_BOARD_HASH {{{', '.join(f'0x{b:02x}' for b in link.hash)}}}",
        "",
        "enum {",
        *(f"    MV_BOARD_N{n} = {size}," for n, size in zip("ZPCSX", link.sizes[2:], strict=True)),
        f"    MV_BOARD_NU = {len(link.outputs)},",
        f"    MV_BOARD_NSEEN = {len(manifest.seen)},",
        f"    MV_BOARD_NR = {nr},",
        f"    MV_BOARD_NV = {len(link.inputs) - len(manifest.seen) - nr},",
        f"    MV_BOARD_PERIOD_MS = {max(1, round(1000 * period))}",
        "};",
        "",
        "/* payload of a step, and of its answer */",
        "enum {",
        *(f"    MV_BOARD_IN_{identifier(n).upper()} = {k}," for k, n in enumerate(link.inputs)),
        f"    MV_BOARD_IN = {len(link.inputs)}",
        "};",
        "enum {",
        *(f"    MV_BOARD_OUT_{identifier(n).upper()} = {k}," for k, n in enumerate(link.outputs)),
        f"    MV_BOARD_OUT = {len(link.outputs)}",
        "};",
        "",
        "#endif",
    ]
    return "\n".join(lines) + "\n"


def board_law_header(
    manifest: Manifest,
    law: Controller,
    resolved: Resolved,
    period: float,
    delay: int,
    tunable: Sequence[str] | None = None,
) -> str:
    """Return the text of mehvar/private/board_law.h: functions and numbers for the firmware.

    Parameters
    ----------
    resolved : Resolved
        Initial parameters of the program, until the host sets others.
    period : float
        Sample period of the law, s.
    delay : int
        Samples between a command and its action in the self-test, 0 or 1.
    tunable : sequence of str, optional
        Parameters that stay variable while all others are constants of the law's code; None for all.

    Raises
    ------
    InputError
        If a name is not a parameter of model or law.
    """
    link = layout(manifest, law)
    model, upper = identifier(manifest.model), identifier(manifest.model).upper()
    own = f"p[{upper}_P_{identifier(law.period).upper()}]" if law.period else f"K({_number(period)})"
    nu, nx = len(link.outputs), len(manifest.states)
    payload = max(4 * max(link.sizes) + 1, 4 * raw_numbers(link), 12 + 4 * (nx + nu), 64 + 4 * nu, 128)
    lines = [
        _LICENSE,
        f"/* {manifest.model} under {law.name}, as the firmware of mehvar calls it. Written by mehvar board. */",
        "#ifndef MEHVAR_PRIVATE_BOARD_LAW_H",
        "#define MEHVAR_PRIVATE_BOARD_LAW_H",
        "",
        f'#include "{manifest.model}.h"',
        '#include "mehvar/board_model.h"',
        '#include "mehvar/private/operations.h"',
        "",
        "enum {",
        f"    MV_BOARD_PAYLOAD = {payload},",
        f"    MV_BOARD_RAW_IN = {raw_numbers(link)},",
        f"    MV_BOARD_SUBSTEPS = {SUBSTEPS},",
        f"    MV_BOARD_DELAY = {delay},",
        f"    MV_BOARD_LAW_TOLERATES_LOSS = {int(law.tolerates_loss)} /* it checks its numbers itself */",
        "};",
        f"#define MV_BOARD_PERIOD(p) {own}",
        "",
        *(
            f"#define MV_BOARD_DEFAULT_{n} {{{', '.join(map(_float, values)) or 'K(0)'}}}"
            for n, values in (("P", resolved.p), ("C", resolved.c), ("S", resolved.s))
        ),
        "",
        *_functions(manifest, law, model, inlined=tunable is not None),
        *_tunable(manifest, law, tunable),
        "#endif",
    ]
    return "\n".join(lines) + "\n"


def _tunable(manifest: Manifest, law: Controller, names: Sequence[str] | None) -> list[str]:
    """Return the tunable parameters."""
    head = "static inline int mv_board_tunable(uint32_t group, uint32_t i) /* group: 1 is p, 2 is c */"
    if names is None:
        return [head, "{", "    (void)group, (void)i;", "    return 1;", "}", ""]
    groups = [[q.name for q in group] for group in (manifest.parameters, law.parameters)]
    for name in names:
        if not any(name in group for group in groups):
            raise unknown_name("tunable", name, [n for group in groups for n in group])
    flags = [", ".join(str(int(name in names)) for name in group) or "0" for group in groups]
    return [
        head,
        "{",
        *(f"    static const uint8_t {n}[] = {{{values}}};" for n, values in zip("pc", flags, strict=True)),
        "    return group == 1 ? p[i] : group == 2 ? c[i] : 1;",
        "}",
        "",
    ]


def _law_call(manifest: Manifest, law: Controller, p: str, c: str) -> str:
    function = f"{identifier(manifest.model)}_{identifier(law.name)}"
    return f"{function}(x, r, v, z, {p}, {c}, u, z_next)" if law.memory else f"{function}(x, r, {p}, {c}, u)"


def _functions(manifest: Manifest, law: Controller, model: str, inlined: bool) -> list[str]:
    """Return definitions that adapt the model's functions to the firmware's names and arguments."""
    name = identifier(law.name)
    names = {identifier(f) for f in manifest.functions}
    memory, start = bool(law.memory), f"{name}_start" in names
    lines: list[str] = []
    if inlined:
        lines += [f"void mv_app_law({_LAW_ARGUMENTS}); /* law.c */", ""]
    call = "mv_app_law(x, r, v, z, p, c, u, z_next)" if inlined else _law_call(manifest, law, "p", "c")
    lines += _inline("law", _LAW_ARGUMENTS, call, () if memory or inlined else ("v", "z", "z_next"))
    call = f"{model}_{name}_start(x, r, p, c, z)" if start else ""
    unused: tuple[str, ...] = () if start else ("x", "r", "p", "c", "z")
    lines += _inline("start", "const real *x, const real *r, const real *p, const real *c, real *z", call, unused)
    lines += _inline("rhs", "const real *x, const real *u, const real *p, real *dx", f"{model}_rhs(x, u, p, dx)")
    lines += _inline("initial", "const real *p, const real *s, real *x", f"{model}_initial(p, s, x)")
    lines += _inline(
        "reference", "const real *t, const real *p, const real *s, real *r", f"{model}_reference(t, p, s, r)"
    )
    if manifest.measured:
        none = ", ".join(["K(0)"] * max(len(manifest.noise), 1))
        call, unused = f"static const real none[] = {{{none}}};\n    {model}_measure(x, none, p, seen)", ()
    else:
        call, unused = "for (int i = 0; i < MV_BOARD_NX; i++) seen[i] = x[i]", ("p",)
    lines += _inline("measure", "const real *x, const real *p, real *seen", call, unused)
    if "actuate" in names:
        call, unused = f"{model}_actuate(x, u_cmd, p, u)", ()
    else:
        call, unused = "for (int i = 0; i < MV_BOARD_NU; i++) u[i] = u_cmd[i]", ("x", "p")
    lines += _inline("actuate", "const real *x, const real *u_cmd, const real *p, real *u", call, unused)
    if "project" in names and "to_coordinates" not in names:
        of_parameters = manifest.projects_by_parameters
        call = f"{model}_project({'q, p' if of_parameters else 'q'}, projected)"
    else:
        of_parameters = False
        call = "for (int i = 0; i < MV_BOARD_NX; i++) projected[i] = q[i]"
    arguments = "const real *q, const real *p, real *projected"
    return lines + _inline("project", arguments, call, () if of_parameters else ("p",))


def _inline(name: str, arguments: str, call: str, unused: Sequence[str] = ()) -> list[str]:
    body = [f"    (void){n};" for n in unused] + ([f"    {call};"] if call else [])
    return [f"static inline void mv_board_{name}({arguments})", "{", *body, "}", ""]


def _float(value: float) -> str:
    """Return the C literal of the nearest float, bit-identical in all compilers."""
    return f"K({_number(float(np.float32(value)))})"


def _number(value: float) -> str:
    return float(value).hex()
