# SPDX-License-Identifier: Apache-2.0
"""Contents of an image: segments, symbols, sizes, and forbidden double-precision routines."""

from __future__ import annotations

import functools
import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from elftools.elf.elffile import ELFFile

_DOUBLE = re.compile(
    r"__(aeabi_(d\w+|[a-z0-9]+2d|cd\w+)|(add|sub|mul|div|neg|cmp|eq|ne|lt|le|gt|ge|unord)df[23]?\w*"
    r"|(extendsf|trunc|fix\w*|float\w*)df\w*|\w*sfdf2|truncdfsf2)"
    r"|(a?(sin|cos|tan)h?|atan2|exp|expm1|log|log1p|pow|sqrt|fmod|hypot|erf|floor|ceil|fabs)"
)


@dataclass(frozen=True)
class Elf:
    """An image as loaded into memory.

    Attributes
    ----------
    segments : tuple of (int, bytes)
        Address and content of the data stored in flash.
    symbols : dict of str to (int, int)
        Address (of code: without the Thumb bit) and size.
    flash, ram : int
        Bytes in flash; bytes of static data, without the stack.
    stack : int
        Bytes reserved for the stack.
    functions : dict of str to list of (int, int)
        Address and size of the instructions of each function, without the constants between them.
    riscv : bool
        True for RISC-V of 64 bits, False for a Cortex-M.
    """

    segments: tuple[tuple[int, bytes], ...]
    symbols: dict[str, tuple[int, int]]
    flash: int
    ram: int
    stack: int
    functions: dict[str, list[tuple[int, int]]] = field(default_factory=dict)
    riscv: bool = False

    def doubles(self) -> list[str]:
        """Return the double-precision routines in the image."""
        return sorted(name for name in self.symbols if _DOUBLE.fullmatch(name))

    @functools.cached_property
    def starts(self) -> dict[int, str]:
        """Functions by first address; of those with one address, the first."""
        return {parts[0][0]: name for name, parts in reversed(self.functions.items())}

    def stored(self, address: int, size: int) -> bytes:
        """Return the bytes of flash that the image occupies."""
        for start, content in self.segments:
            if start <= address and address + size <= start + len(content):
                return content[address - start : address - start + size]
        raise ValueError(f"{size} bytes at {address:#010x} are not in the image")


def read_elf(path: Path, stack: bool = True) -> Elf:
    """Read an image for a board; the stack of another project's image is unknown."""
    with path.open("rb") as file:
        elf = ELFFile(file)
        segments = tuple(
            (s["p_paddr"], s.data()) for s in elf.iter_segments() if s["p_type"] == "PT_LOAD" and s["p_filesz"]
        )
        table = list(elf.get_section_by_name(".symtab").iter_symbols())
        symbols = {
            s.name: (s["st_value"] & ~1 if s["st_info"]["type"] == "STT_FUNC" else s["st_value"], s["st_size"])
            for s in table
            if s.name and not s.name.startswith("$") and s["st_info"]["type"] != "STT_FILE"
        }
        functions = _functions(table)
        sizes = {s.name: s["sh_size"] for s in elf.iter_sections() if s["sh_flags"] & 2}
        riscv = elf["e_machine"] == "EM_RISCV"
    reserved = sizes.pop(".stack", 0)
    if stack and not reserved:
        reserved = symbols["__stack_top"][0] - symbols["__stack_limit"][0]
    ram = sizes.pop(".bss", 0) + sizes.get(".data", 0)
    return Elf(segments, symbols, sum(sizes.values()), ram, reserved, functions, riscv)


def _functions(table: Sequence[Any]) -> dict[str, list[tuple[int, int]]]:
    """Split each function at the symbols that start instructions ($t) and constants ($d)."""
    marks = sorted((s["st_value"], s.name[:2]) for s in table if s.name[:2] in ("$t", "$d"))
    functions: dict[str, list[tuple[int, int]]] = {}
    for symbol in table:
        first = symbol["st_value"] & ~1
        end = first + symbol["st_size"]
        if symbol["st_info"]["type"] == "STT_FUNC" and end > first:
            cuts = [(first, "$t"), *(mark for mark in marks if first < mark[0] < end), (end, "")]
            name = f"{symbol.name}@{first:#x}" if symbol.name in functions else symbol.name  # files may share names
            functions[name] = [(a, b - a) for (a, kind), (b, _) in itertools.pairwise(cuts) if kind == "$t"]
    return functions
