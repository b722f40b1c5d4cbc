# SPDX-License-Identifier: Apache-2.0
"""Instructions of a compiled function, counted in its disassembly."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

_FUNCTION = re.compile(r"^[0-9a-f]+ <(.+)>:$")
_INSTRUCTION = re.compile(r"^\s+[0-9a-f]+:\t(.+)$")
_CALL = re.compile(r"^(?:call|jmp)q?\s+[0-9a-f]+ <([^+>]+)>")
_ARITHMETIC = re.compile(r"v(add|sub|mul|fn?m(add|sub)\d+)[ps][ds]$")


@dataclass(frozen=True)
class Counts:
    """Counts of x86 instructions: all, memory accesses, and vector arithmetic by cost."""

    instructions: int = 0
    loads: int = 0
    stores: int = 0
    arithmetic: int = 0
    quotients: int = 0
    roots: int = 0

    def __add__(self, other: Counts) -> Counts:
        return Counts(*(a + b for a, b in zip(vars(self).values(), vars(other).values(), strict=True)))


def counts(library: Path, function: str) -> Counts:
    """Count the instructions of a function and of its calls, each as often as it is called.

    Every instruction counts once: generated functions do not loop or branch on data.

    Raises
    ------
    subprocess.CalledProcessError
        If there is no objdump for this library.
    """
    command = ["objdump", "-d", "--no-show-raw-insn", str(library)]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    bodies: dict[str, list[str]] = {}
    for line in text.splitlines():
        if match := _FUNCTION.match(line):
            body = bodies.setdefault(match[1], [])
        elif match := _INSTRUCTION.match(line):
            body.append(match[1].split("#")[0].strip())
    return _of(bodies, function)


def _of(bodies: dict[str, list[str]], function: str) -> Counts:
    total = Counts()
    for text in bodies[function]:
        total += _kind(text)
        called = _CALL.match(text)
        if called and called[1] in bodies and called[1] != function:
            total += _of(bodies, called[1])
    return total


def _kind(text: str) -> Counts:
    name, _, operands = text.partition(" ")
    memory = "(" in operands and not name.startswith(("lea", "nop", "call", "jmp"))
    writes = memory and operands.rstrip().endswith(")") and name.startswith(("vmov", "mov", "vextract"))
    return Counts(1, int(memory and not writes), int(writes), int(bool(_ARITHMETIC.match(name))),
                  int(name.startswith("vdiv")), int(name.startswith("vsqrt")))  # fmt: skip
