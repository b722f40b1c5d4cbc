# SPDX-License-Identifier: Apache-2.0
"""Writer of law.c: a law with constant parameters, which writes its new memory as early as possible.

A law that tolerates missing measurements ends with `z_next[i] = SELECT(mask, new, z[i])` for each number i of its
memory. All new numbers would wait for the mask, most of them on the stack. z and z_next are two halves of a buffer,
so each number can be written when computed, and restored in a sample whose mask is false. Results are bit-identical.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from mehvar.base.manifest import Controller, Manifest
from mehvar.base.names import identifier

_INCLUDE = re.compile(r"^#include .*$", re.MULTILINE)
_CONTINUED = re.compile(r"\n {8,}")
_DEFINED = re.compile(r"^(?:const )?(?:real|mask) ([\w, ]+?)(?: =|;)")
_STORE = re.compile(r"^z_next\[(\d+)\] = (.*);$")
_MEMBER = re.compile(r"\[\w+\]")
_LAW_ARGUMENTS = (
    "const real *restrict x, const real *restrict r, const real *restrict v, const real *restrict z, "
    "const real *restrict set_p, const real *restrict set_c, real *restrict u, real *restrict z_next"
)


@dataclass(frozen=True)
class _Store:
    """Assignment z_next[index] = SELECT(mask, value, z[index])."""

    index: int
    mask: str
    value: str


def law_source(manifest: Manifest, law: Controller, tunable: Sequence[str], text: str) -> str:
    """Return the code of law.c, in which all parameters except tunable ones are constants.

    The compiler rounds like the processor, so that results are bit-identical.

    Parameters
    ----------
    text : str
        The generated C of the model.
    """
    statements = _body(text, f"{identifier(manifest.model)}_{identifier(law.name)}")
    groups = {"p": manifest.parameters, "c": law.parameters}
    lines = [
        "/* SPDX-License-Identifier: Apache-2.0 */",
        f"/* {manifest.model} under {law.name}, its parameters folded into its text. Written by mehvar board. */",
        '#include "mehvar/real.h" /* which may hold settings of a package */',
        "#undef MEHVAR_SMALL /* a function that is called folds no constants */",
        *_INCLUDE.findall(text),
        '#include "mehvar/private/board_law.h"',
        "",
        "/* a branch takes fewer instructions than a truth value */",
        "#undef AND",
        "#define AND(a, b) ((a) && (b))",
        "",
        f"void mv_app_law({_LAW_ARGUMENTS})",
        "{",
        *(f"    real {n}[] = MV_BOARD_DEFAULT_{n.upper()};" for n in groups),
        *(
            f"    {n}[{i}] = set_{n}[{i}];"
            for n, group in groups.items()
            for i, parameter in enumerate(group)
            if parameter.name in tunable
        ),
        "    (void)p, (void)c, (void)set_p, (void)set_c;",
        *(("    (void)v, (void)z, (void)z_next;",) if not law.memory else ()),
        *(f"    {statement}" for statement in _early(statements, [identifier(q.name) for q in law.memory])),
        "}",
    ]
    return "\n".join(lines) + "\n"


def _body(text: str, function: str) -> list[str]:
    """Return the statements of a generated function, one per line."""
    begin = text.index("{\n", text.index(f"void {function}(")) + 2
    return [line.strip() for line in _CONTINUED.sub(" ", text[begin : text.index("\n}\n", begin)]).splitlines()]


def _early(statements: list[str], memory: Sequence[str]) -> list[str]:
    """Write each new memory number as soon as possible, and restore it if the mask is false."""
    stores = {k: store for k, text in enumerate(statements) if (store := _store(text, memory))}
    if not stores:
        return statements
    last_mask = Counter(store.mask for store in stores.values()).most_common(1)[0][0]
    early = {k: store for k, store in stores.items() if store.mask == last_mask}
    after: dict[int, list[str]] = {}
    back: dict[tuple[int, str], list[str]] = {}
    for store in early.values():
        inner = _store(f"z_next[{store.index}] = {store.value};", memory)
        value = inner.value if inner else store.value
        at = _known(value, statements)
        after.setdefault(at, []).append(f"z_next[{store.index}] = {value};")
        if inner:
            place = max(at, _known(inner.mask, statements)), inner.mask
            back.setdefault(place, []).append(f"z_next[{store.index}] = z[{memory[store.index]}];")
    for (at, mask), texts in back.items():
        after.setdefault(at, []).append(f"if (NOT({mask})) {{ {' '.join(texts)} }}")
    last = f"if (NOT({last_mask})) for (int i = 0; i < MV_BOARD_NZ; i++) z_next[i] = z[i];"
    lines: list[str] = []
    for k, text in enumerate(statements):
        lines += [last] if k == min(early) else []
        lines += [] if k in early else [text]
        lines += after.get(k, [])
    return lines


def _known(expression: str, statements: Sequence[str]) -> int:
    """Return the statement after which all names of an expression are defined."""
    words = set(re.findall(r"\w+", _MEMBER.sub("", expression)))
    first = max(k for k, text in enumerate(statements) if text.startswith("enum"))
    return max((k for k, text in enumerate(statements) if words.intersection(_defined(text))), default=first)


def _store(text: str, memory: Sequence[str]) -> _Store | None:
    """Return a statement's masked memory assignment if its alternative is the old number."""
    match = _STORE.match(text)
    if match is None or not match[2].startswith("SELECT("):
        return None
    arguments = _arguments(match[2])
    index = int(match[1])
    if arguments is None or arguments[2] != f"z[{memory[index]}]" or not arguments[0].isidentifier():
        return None
    return _Store(index, arguments[0], arguments[1])


def _arguments(call: str) -> list[str] | None:
    """Return the arguments of a call that forms a complete expression."""
    parts, depth = [""], 0
    for k, character in enumerate(call[call.index("(") :], call.index("(")):
        depth += {"(": 1, ")": -1}.get(character, 0)
        if depth == 0:
            return [part.strip() for part in parts] if k == len(call) - 1 else None
        if depth == 1 and character == ",":
            parts.append("")
        elif depth > 1 or character != "(":
            parts[-1] += character
    return None


def _defined(text: str) -> list[str]:
    match = _DEFINED.match(text)
    return [name.strip() for name in match[1].split(",")] if match else []
